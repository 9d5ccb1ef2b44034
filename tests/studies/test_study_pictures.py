"""Each kind of study has its picture, which says what it was made from."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from matplotlib.image import imread
from studies.test_study_statistics import made_up
from support.fmus import ROOT

from solver import Column, InputError
from solver.models.structure.model import Structure
from solver.plotting.style import Figure
from solver.studies import (
    Measure,
    Random,
    Results,
    Shaking,
    Study,
    fragility,
    ida,
    montecarlo,
    run_study,
    spectrum,
    sweep,
)
from solver.studies.pictures import (
    _by_frequency,
    _draw_boundary,
    _draw_broken,
    draw,
    last_before_falls,
    limits_of_model,
)

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


def test_the_caption_says_what_thick_curves_pool() -> None:
    said = " pool the models and the values of joint.friction."
    grid = {"intensity": (0.1, 0.5, 1.0), "joint.friction": (0.3, 0.6), "g": (9.81,)}
    for kind, curves in (("ida", "The thick curves"), ("fragility", "The fitted curves")):
        study = Study("few", kind, (column(), column()), (PULSE,), grid, measure=Measure("pga"))
        assert curves + said in " ".join(draw(run_study(study)).get_supxlabel().split())
    alone = ida(column(), PULSE, [0.1, 0.2], tolerance=1e-3)
    assert "pool" not in draw(alone).get_supxlabel()


def test_scenarios_have_their_legend_beside_the_small_panels() -> None:
    grid = {"motion.magnitude": (6.0, 7.0), "motion.distance": (5.0,)}
    motion = Shaking("near", "near-fault", {"seed": 1.0})
    random = {"motion.pgv_factor": Random.from_table("random", {"distribution": "uniform", "low": 0.2, "high": 2.0})}
    figure = draw(run_study(Study("few", "fragility", (column(),), (motion,), grid, random, limits=(0.5,), samples=16)))
    assert [panel.get_legend() for panel in figure.axes[:2]] == [None, None]
    (legend,) = figure.legends
    assert "overturned" in [text.get_text() for text in legend.get_texts()]


def test_intensities_have_the_measure_and_its_unit() -> None:
    grid = {"intensity": (0.1, 0.3, 0.5), "motion.frequency": (0.5, 1.0)}
    measures = {"PGV 0.3 m/s": Measure("pgv"), "Sa(0.5 s, 5 %) 0.3 g": Measure("sa", 0.5)}
    for said, measure in measures.items():
        results = run_study(Study("swept", "sweep", (column(),), (PULSE,), grid, measure=measure))
        figure = draw(results)
        _, second, _, share, *_ = figure.axes
        assert second.get_title(loc="left") == said
        assert share.get_ylabel() == f"{measure.label} ({measure.unit})"
        assert "Curves" not in figure.get_supxlabel()
    assert "Grid: intensity (3 values), motion.frequency (2 values)." in figure.get_supxlabel()


def test_pooled_motions_of_a_sweep_are_counted() -> None:
    grid, motions = {"intensity": (0.1,), "motion.frequency": (0.5, 1.0)}, (PULSE, Shaking("sine", "one-sine"))
    results = run_study(Study("swept", "sweep", (column(),), motions, grid, measure=Measure("pga")))
    figure = draw(results)
    assert "median of those that stand, of 2 runs at each point" in figure.get_supxlabel()
    assert len(figure.axes[0].collections) == 3  # a band of each block


def test_a_spectrum_has_a_panel_for_each_intensity() -> None:
    """Check sizes in falling order, two motions and two intensities, against the runs themselves."""
    sizes, slender = (2.0, 1.0, 0.5), (6.0, 3.0)
    grid = {"intensity": (0.2, 0.5), "column.size": sizes, "column.slenderness": slender}
    motions = (PULSE, Shaking("sine", "one-sine", {"frequency": 1.2}))
    results = run_study(Study("sizes", "spectrum", (column(),), motions, grid, measure=Measure("pga")))
    figure = draw(results)
    height = sum(block.height for block in column().blocks)
    panels = [axes for axes in figure.axes if axes.get_title(loc="left")]
    cases = [(k, level) for k in (0, 1) for level in (0.2, 0.5)]
    assert [axes.get_title(loc="left") for axes in panels] == [
        f"{motions[k].name}, PGA {level:g} g" for k, level in cases
    ]
    for axes, (k, level) in zip(panels, cases, strict=True):
        assert axes.get_xticks().tolist() == [10.0, 20.0]  # of 7 to 28 m
        cells: Any = axes.collections[0].get_array()
        stands = np.ma.filled(cells, np.nan)
        for i, slenderness in enumerate(sorted(slender)):
            for j, size in enumerate(sorted(sizes)):
                run = (results["motion"] == k) & (results["intensity"] == level) & (results["column.size"] == size)
                (largest,) = results.largest[run & (results["column.slenderness"] == slenderness)]
                of_width = largest / (size * height / slenderness)
                assert stands[i, j] == pytest.approx(of_width if np.isfinite(largest) else np.nan, nan_ok=True)
    assert "Each cell" not in figure.get_supxlabel()


def test_what_a_picture_would_mix_is_refused() -> None:
    grid = {"intensity": (0.1,), "motion.frequency": (1.0,), "joint.damping": (1e-3, 2e-3)}
    results = run_study(Study("swept", "sweep", (column(),), (PULSE,), grid, measure=Measure("pga")))
    with pytest.raises(InputError, match=r"grid\.joint\.damping: must be left out, the picture of kind = sweep"):
        draw(results)
    grid = {"column.size": (1.0,), "column.slenderness": (6.0,)}
    pulse = Shaking("my pulse", "ricker", {"frequency": 1.2, "amplitude": 4.0})
    results = run_study(Study("sizes", "spectrum", (column(), replace(column(), name="b")), (pulse,), grid))
    with pytest.raises(InputError, match="columns: must be one, the picture of kind = spectrum would mix them"):
        draw(results)
    results = spectrum(column(), pulse, [1.0], [6.0], random=SOFT, samples=3)
    assert "Each cell: the median of 3 runs." in draw(results).get_supxlabel()


def sentence(study: Study) -> str:
    """Return the last line of the caption of a study, without its runs."""
    results: Any = SimpleNamespace(study=study.to_dict())
    return limits_of_model(results)


HALF = Random.from_table("random", {"distribution": "uniform", "low": 0.4, "high": 0.6})
DRY = "without tension."
MORTAR = "with mortar that bears tension and cohesion until it breaks."


@pytest.mark.parametrize(
    ("law", "grid", "random", "said"),
    [
        ({}, {}, {}, f"neither slide nor crush, {DRY}"),
        ({}, {"joint.friction": (0.15, 0.5)}, {}, f"that do not crush, {DRY}"),
        ({}, {}, {"joint[2].friction": HALF}, f"that do not crush, {DRY}"),
        ({"friction": 0.6}, {}, {}, f"that do not crush, {DRY}"),
        ({"friction": 0.6, "tensile_strength": 1e5, "cohesion": 1e5}, {}, {}, f"that do not crush, {MORTAR}"),
        ({"friction": 0.6, "cohesion": 1e5}, {"joint[1].tensile_strength": (1e5,)}, {}, f"that do not crush, {MORTAR}"),
        ({"tensile_strength": 1e5}, {}, {}, "neither slide nor crush, with mortar that bears tension until it breaks."),
    ],
)
def test_the_caption_names_the_limits_of_the_model_that_runs(
    law: dict[str, float], grid: dict[str, tuple[float, ...]], random: dict[str, Random], said: str
) -> None:
    """Check laws of the lower of two blocks alone, and names of one joint or all, in the grid or at random."""
    block = {"height": 1.5, "width": 0.8, "depth": 0.8, "density": 2500.0}
    joint = {"stiffness": 2e9, "damping": 2e-3}
    one = Column.from_dict({"name": "c", "block": [{**block, "joint": joint}, {**block, "joint": joint | law}]})
    grid = {"intensity": (0.01,), **grid}
    for made in (one, one.in_space()):
        assert sentence(Study("few", "ida", (made,), (PULSE,), grid, random, Measure("pga"))).endswith(said)


def test_the_caption_names_bearings_that_bear_tension() -> None:
    """Check a slab on one, and that friction of neighbours is no friction of joints."""
    slab = {"name": "slab", "width": 1.0, "depth": 1.0, "height": 0.5, "density": 2500.0, "position": [0.0, 0.0, 0.1]}
    bearing = {"between": ["slab", "base"], "kind": "elastomeric", "at": [0.0, 0.0, 0.1], "diameter": 0.5}
    bearing |= {"stiffness": 1e5, "vertical_stiffness": 1e9, "vertical_damping": 1e-3, "damping": 1e4, "capacity": 0.3}
    for tension, said in ((False, "slide nor crush, without tension."), (True, "tension; bearings bear tension.")):
        data = {"name": "isolated", "block": [slab], "bearing": [bearing | {"tension": tension}]}
        made = Structure.from_dict({**data, "neighbours": {"stiffness": 1e8, "damping": 1e-3, "friction": 0.3}})
        grid = {"intensity": (0.1,), "neighbours.friction": (0.3,)}
        found = sentence(Study("few", "ida", (made,), (PULSE,), grid, measure=Measure("pga")))
        assert found.startswith("Motion in space of rigid blocks on elastic joints that neither slide nor crush, ")
        assert found.endswith(said)


def test_runs_that_failed_are_in_no_share_of_a_sweep() -> None:
    """Check a frequency at which one run fell, one stands and two failed: half of them fell, not a quarter."""
    u = np.array([0.1, math.inf, math.nan, math.nan, math.nan, math.nan])
    frequencies = np.array([1.0, 1.0, 1.0, 1.0, 2.0, 2.0])
    results = made_up(u, np.full(6, 0.2), "sweep", beside={"motion.frequency": frequencies})
    points, fell = _by_frequency(results, np.array([1.0, 2.0]), np.ones(6, dtype=bool))
    assert fell == pytest.approx([0.5, math.nan], nan_ok=True)
    assert points[1, :, 0] == pytest.approx([0.1, math.nan], nan_ok=True)
    figure = Figure()
    axes = figure.add_subplot()
    _draw_boundary(axes, figure, results, np.array([0.2, 0.4]), np.array([1.0, 2.0]))
    shares: Any = np.ma.filled(np.ma.asarray(axes.collections[0].get_array()), math.nan)
    assert shares.ravel() == pytest.approx([0.5, *[math.nan] * 3], nan_ok=True)
