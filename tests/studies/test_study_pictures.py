"""Each kind of study has its picture, which says what it was made from."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from matplotlib.image import imread
from support.fmus import ROOT

from solver import Column, InputError
from solver.studies import Results, Shaking, fragility, ida, montecarlo, spectrum, sweep
from solver.studies.pictures import draw

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
