"""Seismic response of stacked rigid blocks with no-tension elastic joints."""

from .block import Block, Joint
from .column import Column
from .errors import InputError, InputWarning, SolverError
from .many import simulate_many
from .modes import natural_frequencies
from .motion import Motion
from .packing import InitialState
from .response import Response
from .settings import Settings
from .simulate import simulate
from .table import Table
from .uncertainty import Spread

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
