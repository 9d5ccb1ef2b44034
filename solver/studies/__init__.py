"""Studies: the runs of columns and motions that differ by a plan, in one table."""

from typing import Any

from ..models.pictures import drawing_of
from .definition import Study
from .distributions import Distribution, Random
from .execution import StudyError, run_study
from .exports import write_fragilities
from .motions import Measure, Shaking
from .results import Results
from .risk import Hazard, Risk, risk
from .standard import fragility, ida, montecarlo, spectrum, sweep
from .statistics import fit_fragility, ida_curves, influences


@drawing_of.register
def _pictures(result: Results | Risk) -> Any:
    from . import pictures

    return pictures


__all__ = [
    "Distribution",
    "Hazard",
    "Measure",
    "Random",
    "Results",
    "Risk",
    "Shaking",
    "Study",
    "StudyError",
    "fit_fragility",
    "fragility",
    "ida",
    "ida_curves",
    "influences",
    "montecarlo",
    "risk",
    "run_study",
    "spectrum",
    "sweep",
    "write_fragilities",
]
