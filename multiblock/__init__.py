"""The seismic response of columns and structures of rigid blocks with no-tension joints: the public interface.

This module has every name that a program needs; the modules behind it (`solver`, `fmu_src`) may move.
"""

import solver as _solver  # isort: skip  # first: from here on Ctrl-C ends the process by a line

from solver import (
    Block,
    Column,
    InitialState,
    InputError,
    InputWarning,
    Joint,
    Motion,
    Response,
    Settings,
    SolverError,
    Spread,
    Table,
    natural_frequencies,
    simulate,
    simulate_many,
    studies,
)
from solver.checks import spectra
from solver.checks.artificial import artificial_motions
from solver.checks.check import Check, check
from solver.checks.limits import Limits, Plan
from solver.commands.progress import RunsLine
from solver.ground import wavelets
from solver.ground.building import Building, floor_motion
from solver.ground.intensity import Intensity, Spectrum, intensity, pgv, rotd, spectrum
from solver.ground.loads import Load
from solver.models.column.modes import Modes, natural_modes
from solver.models.structure.builders import arch, colonnade, wall
from solver.models.structure.model import Structure
from solver.models.structure.modes import SpatialModes, modes_in_space
from solver.models.structure.push import PushOver, push_over
from solver.models.structure.response import SpatialResponse
from solver.models.structure.run import SpatialState
from solver.models.uncertainty import Ensemble, ErrorEstimate
from solver.runs.many import ExecutorError, parts_of_many
from solver.statics import calibrate
from solver.statics.capacity import CapacityCurve, Rest, capacity_curve, rest_of, uplift_accelerations
from solver.statics.rocking import housner_restitution, restitution
from solver.studies import Results, Study, run_study
from solver.studies.cluster import Cluster

__version__ = _solver.__version__

__all__ = [
    "Block",
    "Building",
    "CapacityCurve",
    "Check",
    "Cluster",
    "Column",
    "Ensemble",
    "ErrorEstimate",
    "ExecutorError",
    "InitialState",
    "InputError",
    "InputWarning",
    "Intensity",
    "Joint",
    "Limits",
    "Load",
    "Modes",
    "Motion",
    "Plan",
    "PushOver",
    "Response",
    "Rest",
    "Results",
    "RunsLine",
    "Settings",
    "SolverError",
    "SpatialModes",
    "SpatialResponse",
    "SpatialState",
    "Spectrum",
    "Spread",
    "Structure",
    "Study",
    "Table",
    "__version__",
    "arch",
    "artificial_motions",
    "calibrate",
    "capacity_curve",
    "check",
    "colonnade",
    "floor_motion",
    "housner_restitution",
    "intensity",
    "modes_in_space",
    "natural_frequencies",
    "natural_modes",
    "parts_of_many",
    "pgv",
    "push_over",
    "rest_of",
    "restitution",
    "rotd",
    "run_study",
    "simulate",
    "simulate_many",
    "spectra",
    "spectrum",
    "studies",
    "uplift_accelerations",
    "wall",
    "wavelets",
]


def __dir__() -> list[str]:
    return sorted(__all__)
