"""How the equations of a column are written and integrated."""

from __future__ import annotations

from dataclasses import dataclass

from ...common.errors import InputError, shown
from ...common.ranges import check, check_choice
from ...kernels.layout import spaces as at

# names -> codes of the kernels
FORMULATION_CODES = {"exact": at.EXACT, "paper": at.PAPER}
INTEGRATOR_CODES = {"auto": at.AUTO, "central-difference": at.CENTRAL_DIFFERENCE}
SKIP_CODES = {  # what can be left out: short cuts, to check or to measure them, and the peaks of all but ux
    "elastic": at.ELASTIC,
    "rest": at.REST,
    "dashpots": at.DASHPOTS,
    "resultants": at.RESULTANTS,
    "implicit": at.IMPLICIT,
    "peaks": at.EXTREMES,
}
FORMULATIONS, INTEGRATORS, SKIPS = tuple(FORMULATION_CODES), tuple(INTEGRATOR_CODES), tuple(SKIP_CODES)


@dataclass(frozen=True)
class Settings:
    """How the equations are written and integrated."""

    formulation: str = "exact"  # one of FORMULATIONS
    integrator: str = "auto"  # one of INTEGRATORS
    step: float = 1e-4  # s, of an integrator with a fixed step
    tolerance: float = 1e-5  # relative error of an integrator that chooses its steps
    without: tuple[str, ...] = ()  # of SKIPS: what is not to be done

    def __post_init__(self) -> None:
        if isinstance(self.without, list):  # as TOML and JSON have it
            object.__setattr__(self, "without", tuple(self.without))


def check_settings(key: str, settings: object) -> None:
    if not isinstance(settings, Settings):
        raise InputError(f"{key} = {shown(settings)}: must be Settings")
    check_choice(f"{key}.formulation", settings.formulation, FORMULATIONS)
    check_choice(f"{key}.integrator", settings.integrator, INTEGRATORS)
    check(f"{key}.step", settings.step)
    check(f"{key}.tolerance", settings.tolerance)
    if not isinstance(settings.without, tuple):
        raise InputError(f"{key}.without = {shown(settings.without)}: must be a list of names of {', '.join(SKIPS)}")
    for name in settings.without:
        check_choice(f"{key}.without", name, SKIPS)
