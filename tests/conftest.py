"""Fixtures shared by the tests."""

from pathlib import Path

import pytest

PROJECT = Path(__file__).resolve().parents[1]


@pytest.fixture(scope="session")
def records() -> Path:
    """Folder of the recorded ground motions, which are not part of the project."""
    folder = PROJECT.parent / "shared" / "records"
    if not folder.is_dir():
        pytest.skip(f"no recorded ground motions in {folder}")
    return folder
