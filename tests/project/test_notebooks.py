"""The notebooks of the examples run, and show the results that are kept in them.

`jupyter execute --inplace examples/notebooks/*.ipynb` makes these again (extra `notebook`).
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import nbformat
import pytest
from nbclient import NotebookClient
from support.fmus import ROOT, environment

pytestmark = pytest.mark.long  # runs the notebooks

NOTEBOOKS = sorted((ROOT / "examples" / "notebooks").glob("*.ipynb"))
OURS = ("<Column", "<Motion", "<Response", "<Table", "<Study", "<Results")


def texts(notebook: Any) -> list[list[str]]:
    """Return the texts of every cell that are this project's own: pandas and xarray lay theirs out by their version."""
    found = []
    for cell in notebook.cells:
        shown = [output.get("text") or output["data"]["text/plain"] for output in cell.get("outputs", ())]
        found.append([text for text in shown if text.startswith(OURS) or "verdict:" in text])
    return found


@pytest.mark.long
@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebook(path: Path) -> None:
    kept = nbformat.read(path, 4)
    made = nbformat.from_dict(kept)
    for cell in made.cells:
        if cell.cell_type == "code":
            cell.outputs = []
    client = NotebookClient(made, timeout=600, resources={"metadata": {"path": str(path.parent)}})
    client.execute(env=environment())
    assert texts(made) == texts(kept)
    assert any(texts(made))


def test_notebooks_are_kept_with_small_results() -> None:
    assert len(NOTEBOOKS) == 4
    for path in NOTEBOOKS:
        assert path.stat().st_size < 200_000, path
        cells = [cell for cell in nbformat.read(path, 4).cells if cell.cell_type == "code"]
        assert [cell.execution_count for cell in cells] == list(range(1, len(cells) + 1))
        assert all(output.output_type != "error" for cell in cells for output in cell.outputs)
