"""What an import brings with it."""

from __future__ import annotations

import importlib
import sys


def loaded_with(module: str, others: list[str]) -> list[str]:
    """Which of `others` are loaded once `module` is imported."""
    importlib.import_module(module)
    return [name for name in others if name in sys.modules]
