"""A picture shows the numbers it was given, and importing the solver does not bring in what draws it."""

import json
import re
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.image import imread
from matplotlib.lines import Line2D
from support.child import call
from support.fmus import PHOCAS, ROOT
from support.inside import imports

from multiblock import wavelets
from solver import Block, Column, InputError, Joint, Motion, Response, simulate
from solver.plotting import plots
from solver.plotting.lines import COLUMNS, thinned
from solver.plotting.plots import PEAK
from solver.plotting.style import FEW_COLOURS, block_colours

pytestmark = pytest.mark.long  # draws pictures


def histories(n: int, samples: int = 500) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Return the times over 5 s and smooth histories of n blocks, the top one moving most."""
    time = np.linspace(0.0, 5.0, samples)
    shape = np.linspace(1.0, 1.0 / n, n)
    wave = np.sin(7.0 * time)[:, None] * shape
    scales = {"ux": 0.03, "ry": 2e-3, "N": 1e6, "My": 5e5, "S": 1e5, "Tx": 1e5, "sigma_max": 1e6}
    return time, {name: scale * wave for name, scale in scales.items()} | {"contact": 0.5 + 0.5 * wave}


def plot_histories(time: np.ndarray, given: dict[str, np.ndarray], title: str | None = None, **options: Any) -> Figure:
    """Return the picture of histories of equal blocks."""
    blocks = (Block(1.0, 1.0, 1.0, 2000.0, Joint(1e9, 1e-3)),) * given["ux"].shape[1]
    return plots.plot_histories(time, given, Column("stack", blocks), title=title, **options)


def panel(figure: Figure, words: str):
    """Return the one panel with these words in its heading."""
    (found,) = [axes for axes in figure.axes if words in axes.get_title(loc="left")]
    return found


def heights(line: Line2D) -> list[float]:
    return [float(value) for value in np.asarray(line.get_ydata())]


def histories_of(axes: Axes) -> dict[str, Line2D]:
    """Return colour -> line of a panel, without the marks of peaks."""
    return {to_hex(line.get_color()).upper(): line for line in axes.lines if line.get_label() != PEAK}


def marks(axes: Axes) -> dict[str, tuple[float, str]]:
    """Return colour -> height and marker of the peaks that rows miss."""
    found = [line for line in axes.lines if line.get_label() == PEAK]
    return {to_hex(line.get_color()).upper(): (heights(line)[0], str(line.get_marker())) for line in found}


@pytest.fixture(scope="module")
def response() -> Response:
    return simulate(Column.from_toml(PHOCAS), Motion.harmonic(0.05 * 9.80665, 2.0, 2.0))


@pytest.mark.parametrize(
    ("imported", "absent"),
    [
        ("multiblock", ["pythonfmu", "fmpy", "matplotlib", "scipy", "numba"]),
        ("solver", ["pythonfmu", "fmpy", "matplotlib", "solver.studies", "solver.models.structure.kind"]),
        ("solver.plotting.plots", ["matplotlib.pyplot"]),
    ],
)
def test_an_import_brings_nothing_that_it_can_do_without(imported: str, absent: list[str]) -> None:
    assert call(imports.loaded_with, imported, absent) == []


def test_response_is_drawn_as_it_is(response: Response) -> None:
    figure = response.plot()
    assert len(figure.axes) == 9
    for words, name, factor in [
        ("displacement", "ux", 1e3),
        ("rotation", "ry", 1e3),
        ("normal force", "N", 1e-3),
        ("moment", "My", 1e-3),
        ("shear", "S", 1e-3),
        ("pressure", "sigma_max", 1e-6),
    ]:
        lines = histories_of(panel(figure, words))
        for i, colour in enumerate(block_colours(3)):
            np.testing.assert_array_equal(lines[colour.upper()].get_xdata(), response.time)
            np.testing.assert_array_equal(lines[colour.upper()].get_ydata(), factor * getattr(response, name)[:, i])
    assert figure.get_suptitle() == "phocas under a harmonic of 2 Hz, PGA 0.05 g"
    assert any(text.get_text().startswith("Stands: largest displacement") for text in figure.texts)
    assert all(axes.get_xlim() == (0.0, 2.0) for axes in figure.axes)


def test_ground_motion_stands_on_top(response: Response) -> None:
    ground = response.plot().axes[0]
    assert "acceleration of the base" in ground.get_title(loc="left")
    (line,) = ground.lines
    assert np.max(line.get_ydata()) == pytest.approx(0.05, rel=1e-4)
    assert response.motion is not None
    ax, _ = response.motion.acceleration(np.asarray(line.get_xdata()))
    np.testing.assert_allclose(np.asarray(line.get_ydata(), dtype=float), ax / 9.80665, atol=1e-15)


@pytest.mark.parametrize("hold", [False, True])
def test_samples_are_drawn_as_they_are_followed(hold: bool) -> None:
    motion = Motion.from_samples(1.0, [1.0, 2.0, -1.0, 0.5, 0.5, 0.0], [0.0, 3.0, 0.0, 0.0, 0.0, 0.0], hold=hold)
    ground = plot_histories(*histories(2), motion=motion).axes[0]
    horizontal, vertical = ground.lines
    inside = np.array([0.5, 1.2, 2.7])
    for line, wanted in zip((horizontal, vertical), motion.acceleration(inside), strict=True):
        drawn = np.interp(inside, np.asarray(line.get_xdata(), dtype=float), 9.80665 * np.asarray(line.get_ydata()))
        np.testing.assert_allclose(drawn, wanted, atol=1e-12)


def test_friction_is_drawn_where_the_joint_is_pressed(response: Response) -> None:
    axes = panel(response.plot(), "friction")
    lines = {colour: np.asarray(line.get_ydata()) for colour, line in histories_of(axes).items()}
    for i, colour in enumerate(block_colours(3)):
        N, T = response.N[:, i], response.Tx[:, i]
        pressed = 0.05 * N[0] < N
        np.testing.assert_allclose(lines[colour.upper()][pressed], np.abs(T / N)[pressed])
        assert np.all(np.isnan(lines[colour.upper()][~pressed]))


def test_many_samples_are_one_line_through_their_extremes() -> None:
    time = np.linspace(0.0, 5.0, 100 * COLUMNS)
    _, given = histories(2, len(time))
    given["N"] = 1e6 * np.column_stack([2.0 + np.sin(900.0 * time), 3.0 + np.sin(900.0 * time)])
    given["N"][31_234, 0] = 9e6  # nothing is lost, however short it lasts
    lines = panel(plot_histories(time, given), "normal force").lines
    assert len(lines) == 2
    for line in lines:
        assert len(line.get_xdata()) <= 2 * COLUMNS + 2
        assert np.min(np.diff(line.get_xdata())) > 0.0
    (spiked,) = [line for line in lines if np.max(line.get_ydata()) == 9e3]
    k = int(np.argmax(spiked.get_ydata()))
    assert spiked.get_xdata()[k] == time[31_234]


def test_a_thinned_history_goes_through_samples_and_keeps_gaps() -> None:
    time = np.linspace(0.0, 1.0, 20 * COLUMNS)
    values = np.sin(40.0 * time)
    values[500:3000] = np.nan
    instants, line = thinned(time, values)
    np.testing.assert_array_equal(line, values[np.searchsorted(time, instants)])
    assert np.sum(np.isnan(line)) >= 2500 // 20 - 1
    assert (instants[0], instants[-1]) == (0.0, 1.0)


def test_peaks_between_rows_are_marked() -> None:
    time, given = histories(3)
    largest = np.max(np.abs(given["N"]), axis=0)
    peaks = {"N": largest * np.array([1.0, 1.5, 20.0]), "My": np.max(np.abs(given["My"]), axis=0)}
    figure = plot_histories(time, given, peaks=peaks)
    axes, (_, second, third) = panel(figure, "normal force"), block_colours(3)
    found = marks(axes)
    assert set(found) == {second.upper(), third.upper()}
    height, marker = found[second.upper()]
    assert abs(height) == pytest.approx(1e-3 * peaks["N"][1])
    assert marker == "<"
    # so large that the rows could not be read: an arrow outwards, and the number over the panel
    assert found[third.upper()][1] in "^v"
    assert abs(found[third.upper()][0]) <= 3e-3 * np.max(largest) * (1.0 + 1e-12)
    assert axes.get_title(loc="right") == f"peak {1e-3 * peaks['N'][2]:.4g} kN, joint 3"
    low, high = axes.get_ylim()
    assert all(low <= height <= high for height, _ in found.values())
    assert not marks(panel(figure, "moment"))
    assert figure.legends[0].get_texts()[-1].get_text() == PEAK


def test_slips_and_what_is_left_of_them_are_drawn() -> None:
    time, given = histories(2)
    given["slip"] = np.linspace(0.0, 1.0, len(time))[:, None] * np.array([-4e-3, 2e-3])
    blocks = (Block(1.0, 1.0, 1.0, 2000.0, Joint(1e9, 1e-3, friction=0.5)),) * 2
    figure = plots.plot_histories(time, given, Column("stack", blocks))
    assert np.min([np.min(line.get_ydata()) for line in panel(figure, "slip").lines]) == pytest.approx(-4.0)
    bars = panel(figure, "offset left").patches
    assert [bar.get_width() for bar in bars] == pytest.approx([-4.0, 2.0])
    assert not [axes for axes in plot_histories(time, given).axes if "slip" in axes.get_title(loc="left")]


def test_contact_is_drawn_by_its_least() -> None:
    time, given = histories(2, 4 * COLUMNS)
    given["contact"] = np.ones((len(time), 2))
    given["contact"][1001, 1] = 0.25
    (image,) = panel(plot_histories(time, given), "contact").images
    shown = np.asarray(image.get_array())
    assert shown.shape == (2, COLUMNS)
    assert np.all(shown[0] == 1.0)
    assert shown[1, 250] == 0.25


def test_an_ensemble_is_a_band(response: Response, monkeypatch: pytest.MonkeyPatch) -> None:
    shape = response.time[:, None] * np.ones(3)
    alone = panel(response.plot(), "displacement")
    ensemble = SimpleNamespace(ux=np.array([0.01 * shape, 0.02 * shape, 0.03 * shape]), overturned=1, size=16)
    monkeypatch.setitem(vars(response), "ensemble", ensemble)
    figure = response.plot()
    assert any("1 of 16 varied runs overturn" in text.get_text() for text in figure.texts)
    with_band = panel(figure, "displacement")
    assert len(with_band.collections) == len(alone.collections) + 3
    medians = [line for line in with_band.lines if line.get_linestyle() == "--"]
    assert [np.max(line.get_ydata()) for line in medians] == pytest.approx([40.0] * 3)


def test_a_column_without_weight_is_drawn() -> None:
    time, given = histories(1)
    block = Block(1.0, 1.0, 1.0, 2000.0, Joint(1e9, 1e-3))
    figure = plots.plot_histories(time, given, Column("floating", (block,), g=0.0))
    headings = [axes.get_title(loc="left") for axes in figure.axes]
    assert any("pressure" in heading for heading in headings)
    assert not any("friction" in heading for heading in headings)  # there is no weight to compare with


def test_smaller_motion_is_drawn_over_larger() -> None:
    time, given = histories(3)
    lines = panel(plot_histories(time, given), "displacement").lines
    ranges = [np.ptp(line.get_ydata()) for line in lines]
    assert ranges == sorted(ranges, reverse=True)


@pytest.mark.parametrize(("largest", "unit", "factor"), [(0.999, "(mm)", 1e3), (1.0, "(m)", 1.0)])
def test_unit_of_displacement(largest: float, unit: str, factor: float) -> None:
    time, given = histories(2)
    given["ux"] *= largest / np.max(np.abs(given["ux"]))
    axes = panel(plot_histories(time, given), "displacement")
    assert unit in axes.get_ylabel()
    assert np.max(np.abs(axes.lines[0].get_ydata())) == pytest.approx(factor * largest)


def fallen() -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Return the histories of three blocks, 1 m wide, that fall from 2 s on, lie at 3 s and stay there."""
    time, given = histories(3)
    falling = np.clip(time - 2.0, 0.0, 1.0)[:, None] ** 2 * np.array([2.5, 1.5, 0.5])
    given["ux"] = 0.1 * given["ux"] + falling
    given["ry"] = given["ry"] + falling
    return time, given | {"uz": np.zeros_like(falling)}


def test_overturning_is_marked_and_said() -> None:
    figure = plot_histories(*fallen(), title="a column", overturn_time=3.0)
    assert figure.get_suptitle() == "a column"
    assert "Overturned at 3.00 s." in [text.get_text() for text in figure.texts]
    over_time = [axes for axes in figure.axes if axes.get_ylabel() not in ("",)]
    for axes in over_time:
        assert [3.0, 3.0] in [np.asarray(line.get_xdata()).tolist() for line in axes.lines]


def test_a_fall_is_drawn_until_shortly_after_it() -> None:
    time, given = fallen()
    figure = plot_histories(time, given, overturn_time=3.0, peaks={"N": np.full(3, 1e9)})
    displacement = panel(figure, "displacement")
    assert displacement.get_xlim()[1] == pytest.approx(3.09, abs=time[1])
    # fitted to what comes before: later the top has moved by more than the width
    assert 1000.0 < displacement.get_ylim()[1] < 1300.0
    assert "before the fall" in displacement.get_title(loc="right")
    assert not marks(panel(figure, "normal force"))  # whose peaks may be those of the fall
    texts = [text.get_text() for axes in figure.axes for text in axes.texts]
    assert "3.00 s" in texts  # the last of the last moments
    assert len(panel(figure, "last moments").patches) == 3


def test_standing_column_has_no_mark() -> None:
    time, given = histories(3)
    figure = plot_histories(time, given, "a column")
    assert figure.get_suptitle() == "a column"
    assert len(figure.texts) == 1  # the title: no verdict is known
    assert all(len(line.get_xdata()) == len(time) for line in panel(figure, "rotation").lines)


@pytest.mark.parametrize("n", [1, 2, len(FEW_COLOURS)])
def test_few_blocks_have_a_legend(n: int) -> None:
    figure = plot_histories(*histories(n))
    (legend,) = figure.legends
    texts = [text.get_text() for text in legend.get_texts()]
    assert len(texts) == n
    assert texts[0].startswith("block and joint 1")
    assert n == 1 or texts[-1] == f"block and joint {n} (bottom)"


@pytest.mark.parametrize("n", [len(FEW_COLOURS) + 1, 200])
def test_of_many_blocks_some_have_lines_and_all_a_band(n: int, tmp_path: Path) -> None:
    time, given = histories(n)
    figure = plot_histories(time, given, path=tmp_path / "many.png")
    displacement = panel(figure, "displacement")
    assert len(displacement.lines) == 4
    (band,) = displacement.collections
    corners = band.get_paths()[0].vertices
    assert np.max(corners[:, 1]) == pytest.approx(1e3 * np.max(given["ux"]))
    names = [text.get_text() for text in figure.legends[0].get_texts()]
    assert names[0] == "block and joint 1 (top); grey: all"
    assert names[-1] == f"block and joint {n} (bottom)"
    profile = panel(figure, "over the height").lines[0]
    np.testing.assert_allclose(profile.get_xdata(), 1e3 * np.max(np.abs(given["ux"]), axis=0))
    np.testing.assert_allclose(profile.get_ydata(), np.arange(n, 0, -1))
    assert len(set(block_colours(n))) > 0.9 * n
    assert imread(tmp_path / "many.png").shape[1] == 1500


def test_files(response: Response, tmp_path: Path) -> None:
    response.plot(tmp_path / "picture.PNG")
    pixels = imread(tmp_path / "picture.PNG", format="png")
    assert pixels.shape[:2] == (1500, 1500)
    assert np.std(pixels[..., :3]) > 0.05  # something is drawn
    response.plot(tmp_path / "picture.pdf")
    assert (tmp_path / "picture.pdf").read_bytes().startswith(b"%PDF")


@pytest.mark.parametrize("name", ["picture.xyz", "picture", "picture.csv"])
def test_unknown_format_is_refused(response: Response, tmp_path: Path, name: str) -> None:
    with pytest.raises(InputError, match=r"must end in one of .*\.png"):
        response.plot(tmp_path / name)
    assert not list(tmp_path.iterdir())


def test_missing_folder_is_an_error_of_the_system(response: Response, tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError):
        response.plot(tmp_path / "none" / "picture.png")


def test_one_instant_is_no_history() -> None:
    time, given = histories(2)
    with pytest.raises(InputError, match="at least 2"):
        plot_histories(time[:1], {name: values[:1] for name, values in given.items()})


def test_the_number_of_a_fall_is_the_same_in_figure_and_page(tmp_path: Path) -> None:
    """Check a slender block that falls: both show what it moved by before it could not come back, and no mark
    is later.
    """
    block = Column("slender", (Block(2.0, 0.3, 0.3, 400.0, Joint(2e9, 2e-3)),))
    run = simulate(block, wavelets.one_sine(9.80665, 0.8), duration=6.0, check=False)
    assert run.overturn_time < 5.0
    before = np.abs(run.ux[:, 0])
    gone = int(np.flatnonzero(before > 0.3)[0])
    expected = 1e3 * np.max(before[:gone])
    assert run.peak_top_ux[0] > 2.0 * 0.3  # the fall itself
    title = panel(run.plot(), "displacement").get_title(loc="right")
    assert title == f"before the fall {expected:.3g} mm, block 1"
    run.view(tmp_path / "fall.html")
    page = (tmp_path / "fall.html").read_text(encoding="utf-8")
    assert f"Largest displacement before the fall {expected:.3g} mm." in page
    marks = dict(json.loads(re.search(r'"marks":(\[\[.*?\]\])', page)[1]))  # type: ignore[index]
    assert marks["peak"] < marks["fall"] == pytest.approx(run.overturn_time)


def test_the_figure_of_a_report_shows_peaks_between_rows() -> None:
    block = Column("block", (Block(2.0, 0.5, 0.5, 1200.0, Joint(2e9, 2e-3)),))
    run = simulate(block, wavelets.one_sine(0.25 * 9.80665, 1.2), output_step=0.2, check=False)
    assert run.verdict == "standing"
    assert np.max(np.abs(run.ux)) < 0.98 * run.peak_top_ux[0]
    title = panel(plots.plot_response(run, None, "a block", plots.HISTORIES), "displacement").get_title(loc="right")
    assert title == f"peak {1e3 * run.peak_top_ux[0]:.3g} mm, block 1"


def test_a_fall_after_the_histories_leaves_their_peaks() -> None:
    """Let a statue strike its pedestal between two rows and fall after the run."""
    statue = Column.from_toml(ROOT / "examples" / "columns" / "statue.toml")
    run = simulate(statue, wavelets.one_sine(0.7 * 9.80665, 1.5))
    assert run.overturn_time > run.time[-1]
    most = 1e-3 * run.peaks["N"].max()
    assert most > 3e-3 * np.max(run.N)
    axes = panel(plots.plot_response(run), "normal force")
    assert axes.get_title(loc="right") == f"before the fall {most:.3g} kN, joint 2"
    assert len(marks(axes)) == 2
