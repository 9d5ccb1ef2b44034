"""Each kind of study has its picture, which says what it was made from."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from matplotlib.image import imread
from support.fmus import ROOT

from solver import Column, InputError
from solver.plotting.style import Figure
from solver.studies import Results, Shaking, fragility, ida, montecarlo, spectrum, sweep
from solver.studies.pictures import _draw_broken, draw, last_before_falls

PULSE = Shaking("my pulse", "ricker", {"frequency": 1.2})
SOFT = {
    "joint.stiffness": {"distribution": "lognormal", "median": 1.0, "deviation": 0.3, "relative": True, "each": True}
}
MORE = {**SOFT, "intensity": {"distribution": "uniform", "low": 0.3, "high": 1.5}}


def column() -> Column:
    return Column.from_toml(ROOT / "examples" / "columns" / "phocas-damped.toml").with_settings(tolerance=1e-3)


STUDIES: dict[str, Callable[[], Results]] = {
    "sweep": lambda: sweep(column(), [0.5, 1.0, 2.0], [0.05, 0.2, 0.4], 3.0, random=SOFT, samples=2),
    "ida": lambda: ida(column(), PULSE, [0.1, 0.3, 0.5, 0.7, 0.9], random=SOFT, samples=6),
    "fragility": lambda: fragility(column(), PULSE, MORE, 60),
    "spectrum": lambda: spectrum(
        column(),
        Shaking("my pulse", "ricker", {"frequency": 1.2, "amplitude": 4.0}),
        [0.25, 0.5, 1.0, 2.0],
        [3.0, 6.0, 9.0],
    ),
    "montecarlo": lambda: montecarlo(
        column(), Shaking("my pulse", "ricker", {"frequency": 1.2, "amplitude": 5.0}), SOFT, 40, sampling="sobol"
    ),
}


@pytest.mark.parametrize("kind", STUDIES)
def test_a_picture_says_what_it_was_made_from(kind: str, tmp_path: Path) -> None:
    results = STUDIES[kind]()
    assert results.complete
    figure = draw(results, tmp_path / "picture.png")
    text = " ".join(figure.get_supxlabel().split())
    name = "harmonic" if kind == "sweep" else "my pulse"
    for said in (
        f"{kind}: phocas_damped (3 blocks)",
        f"base motion: {name}",
        f"{len(results)} of",
        "seed 0",
        "Plane motion",
    ):
        assert said in text
    assert figure.get_suptitle() == f"phocas_damped under {name}"
    pixels = imread(tmp_path / "picture.png")
    assert pixels.shape[1] > 1000
    assert np.std(pixels[..., :3]) > 0.05


def test_nothing_to_draw() -> None:
    results = STUDIES["montecarlo"]()
    with pytest.raises(InputError, match="no run is finished yet"):
        draw(Results(results.head, []))


def test_curves_have_gaps_where_they_fall_and_dots_between_two_falls() -> None:
    """Check levels 1 to 7; it falls at 2, 4 and 7, and level 5 was not run: the line ends before each fall."""
    levels = np.arange(1.0, 8.0)
    moved = np.array([0.1, np.inf, 0.3, np.inf, np.nan, 0.6, np.inf])
    axes = Figure().add_subplot()
    _draw_broken(axes, moved, levels)
    (line,) = axes.lines
    found = np.asarray(line.get_xdata(), dtype=np.float64)
    np.testing.assert_allclose(found, np.array([100.0, np.nan, 300.0, np.nan, 600.0, np.nan]))
    np.testing.assert_array_equal(line.get_ydata(), [1.0, 2.0, 3.0, 4.0, 6.0, 7.0])
    assert line.get_markevery() == [0, 2, 4]
    assert levels[last_before_falls(moved)].tolist() == [1.0, 3.0, 6.0]
    _draw_broken(axes, np.array([0.1, 0.2, np.inf]), levels[:3])
    assert axes.lines[1].get_markevery() == []


def test_a_curve_of_each_motion_has_its_name() -> None:
    motions = [Shaking(name, "ricker", {"frequency": frequency}) for name, frequency in (("slow", 0.7), ("fast", 1.4))]
    results = ida(column(), motions, [0.1, 0.2, 0.3], tolerance=1e-3)
    curves, ended = draw(results).axes
    places = {text.get_text(): text.xy for text in curves.texts}  # type: ignore[attr-defined]
    assert set(places) == {"slow", "fast"}
    for k, name in enumerate(("slow", "fast")):
        moved = results.largest[results["motion"] == k]
        last = int(np.flatnonzero(np.isfinite(moved))[-1])
        assert places[name] == pytest.approx((1e3 * moved[last], [0.1, 0.2, 0.3][last]))
    legend = ended.get_legend()
    assert legend is not None
    assert [text.get_text() for text in legend.get_texts()] == ["overturned", "undecided"]
