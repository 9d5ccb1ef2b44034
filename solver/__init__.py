"""Seismic response of columns and structures of rigid blocks with no-tension elastic joints."""

from . import registrations  # noqa: F401  # kinds of models, pictures of results
from .common.errors import InputError, InputWarning, SolverError
from .ground.motion import Motion
from .models.column.block import Block, Joint
from .models.column.model import Column
from .models.column.modes import natural_frequencies
from .models.column.packing import InitialState
from .models.column.response import Response
from .models.column.settings import Settings
from .models.uncertainty import Spread
from .runs.many import simulate_many
from .runs.simulate import simulate
from .runs.table import Table

__version__ = "1.0.0"

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
