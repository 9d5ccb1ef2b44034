"""Seismic response of stacked rigid blocks with no-tension elastic joints."""

from .common import loading

loading.begin()  # before what takes a second to load

# ruff: noqa: E402
from .column.block import Block, Joint
from .column.column import Column
from .column.packing import InitialState
from .column.settings import Settings
from .common.errors import InputError, InputWarning, SolverError
from .dynamics.response import Response
from .dynamics.uncertainty import Spread
from .ground.motion import Motion
from .runs.many import simulate_many
from .runs.simulate import simulate
from .runs.table import Table
from .statics.modes import natural_frequencies

__version__ = "0.1.0"

__all__ = [
    "Block",
    "Column",
    "InitialState",
    "InputError",
    "InputWarning",
    "Joint",
    "Motion",
    "Response",
    "Settings",
    "SolverError",
    "Spread",
    "Table",
    "__version__",
    "natural_frequencies",
    "simulate",
    "simulate_many",
]
