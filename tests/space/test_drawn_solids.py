"""Structures are drawn from behind to the front, whole, and their films are small."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.image import imread
from support.fmus import ROOT

from solver import Motion, simulate
from solver.models.structure.model import Structure
from solver.plotting.structures import draw_blocks

TRILITH = ROOT / "examples" / "structures" / "trilith.toml"


def drawn(structure: Structure, scale: float = 0.0, azimuth: float = -62.0) -> tuple[Figure, np.ndarray]:
    """Return a picture of a structure whose first block is moved along x, and the order of its blocks."""
    figure = Figure(figsize=(4.0, 4.0))
    axes = figure.add_subplot(projection="3d")
    u = np.zeros((structure.n, 3))
    u[0, 0] = scale
    solids = draw_blocks(axes, structure, u, np.zeros((structure.n, 3)))
    axes.view_init(elev=18, azim=azimuth)
    FigureCanvasAgg(figure).draw()
    return figure, solids._order


@pytest.mark.parametrize(("azimuth", "first"), [(-62.0, "left"), (-118.0, "right")])
def test_the_beam_hides_what_it_lies_on(azimuth: float, first: str) -> None:
    structure = Structure.from_toml(TRILITH)
    _, order = drawn(structure, azimuth=azimuth)
    assert [structure.names[i] for i in order][-1] == "beam"  # seen from above
    assert structure.names[order[0]] == first


def test_what_has_moved_far_stays_in_the_picture(tmp_path: Path) -> None:
    figure, _ = drawn(Structure.from_toml(TRILITH), scale=-12.0)
    figure.savefig(tmp_path / "far.png")
    inside = imread(tmp_path / "far.png")[..., :3].min(axis=2)
    assert inside.min() < 0.7
    assert inside[[0, -1]].min() == inside[:, [0, -1]].min() == 1.0


def test_a_film_shows_its_progress_and_is_small(tmp_path: Path) -> None:
    response = simulate(Structure.from_toml(TRILITH), Motion.harmonic(3.0, 2.0, 2.0, direction=0.4), settle=0.0)
    seen: list[tuple[int, int]] = []
    response.film(tmp_path / "film.gif", callback=lambda done, total: seen.append((done, total)))
    assert seen == [(k, 41) for k in range(1, 42)]
    assert (tmp_path / "film.gif").stat().st_size < 41 * 3600  # 3 MB for 820 pictures
