"""Recorded accelerations in the formats of their networks: one module per family of formats."""

from .reader import NAMES, format_of, has_channels, read_record
from .record import Record
from .units import STANDARD_GRAVITY

__all__ = ["NAMES", "STANDARD_GRAVITY", "Record", "format_of", "has_channels", "read_record"]
