"""The formulation of the equations of a column, and their integration."""

from __future__ import annotations

from dataclasses import dataclass

from ...common.errors import InputError, shown
from ...common.ranges import check, check_choice
from ...kernels.layout import spaces as at

OWN_INTEGRATOR = {"exact": "auto", "paper": "central-difference"}  # formulation -> its integrator
FORMULATIONS, INTEGRATORS = tuple(OWN_INTEGRATOR), tuple(OWN_INTEGRATOR.values())
WITHOUT_STEP = "must be left out, the exact formulation adapts its steps to the tolerance"
# names -> codes of the kernels
SKIP_CODES = {  # features that can be omitted: short cuts, to check or to measure them, and the peaks of all but ux
    "elastic": at.ELASTIC,
    "rest": at.REST,
    "dashpots": at.DASHPOTS,
    "resultants": at.RESULTANTS,
    "implicit": at.IMPLICIT,
    "peaks": at.EXTREMES,
}
SKIPS = tuple(SKIP_CODES)


@dataclass(frozen=True)
class Settings:
    """The formulation of the equations, and their integration."""

    formulation: str = "exact"  # one of FORMULATIONS
    integrator: str = ""  # that of the formulation (OWN_INTEGRATOR) by default
    step: float = 1e-4  # s, of the fixed steps of paper
    tolerance: float = 1e-5  # relative error of exact, which adapts its steps
    without: tuple[str, ...] = ()  # names of SKIPS: the features that are omitted

    def __post_init__(self) -> None:
        if isinstance(self.without, list):  # TOML and JSON have lists
            object.__setattr__(self, "without", tuple(self.without))
        if self.integrator == "" and isinstance(self.formulation, str):
            object.__setattr__(self, "integrator", OWN_INTEGRATOR.get(self.formulation, ""))


def check_settings(key: str, settings: object) -> None:
    if not isinstance(settings, Settings):
        raise InputError(f"{key} = {shown(settings)}: must be Settings")
    check_choice(f"{key}.formulation", settings.formulation, FORMULATIONS)
    if settings.integrator != (own := OWN_INTEGRATOR[settings.formulation]):
        given = f"{key}.integrator = {shown(settings.integrator)}"
        raise InputError(f'{given}: must be "{own}", or left out, where the formulation is {settings.formulation}')
    check(f"{key}.step", settings.step)
    check(f"{key}.tolerance", settings.tolerance)
    if not isinstance(settings.without, tuple):
        raise InputError(f"{key}.without = {shown(settings.without)}: must be a list of names of {', '.join(SKIPS)}")
    for name in settings.without:
        check_choice(f"{key}.without", name, SKIPS)
