"""A folder with a study, for all tests of studies."""

from pathlib import Path

import pytest
from support.columns import BLOCK
from support.study import TEXT


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Return a folder with a study of a single block, 24 runs."""
    (tmp_path / "block.toml").write_text(BLOCK, encoding="utf-8")
    (tmp_path / "study.toml").write_text(TEXT.format(samples=12), encoding="utf-8")
    return tmp_path
