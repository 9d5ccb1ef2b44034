"""Histories and tables in pandas and xarray, and how objects show themselves in a notebook."""

from __future__ import annotations

import itertools
import re
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from support.fmus import ROOT

from multiblock import (
    Column,
    Motion,
    Response,
    Structure,
    Study,
    Table,
    capacity_curve,
    natural_modes,
    simulate,
    simulate_many,
    spectrum,
    wavelets,
)
from solver.common.frames import Framed
from solver.common.notebook import NotebookRepr, history, outlines

PHOCAS = Column.from_toml(ROOT / "examples" / "columns" / "phocas-damped.toml")
STATUE = Column.from_toml(ROOT / "examples" / "columns" / "statue.toml")
PULSE = wavelets.ricker(3.0, 1.0)


@pytest.fixture(scope="module")
def response() -> Response:
    return simulate(PHOCAS, PULSE)


@pytest.fixture(scope="module")
def table() -> Table:
    return simulate_many(
        [PHOCAS, STATUE, PHOCAS], [PULSE, PULSE, PULSE.scaled(3.0)], keep=("peak_top_ux", "verdict", "path")
    )


@pytest.fixture(scope="module")
def framed(response: Response, table: Table) -> list[Framed]:
    return [response, table, PULSE, spectrum(PULSE, [0.5, 1.0]), natural_modes(PHOCAS), capacity_curve(PHOCAS)]


def test_both_have_every_number(framed: list[Framed]) -> None:
    for item in framed:
        data, frame = item.to_xarray(), item.to_pandas()
        (index,) = set(data.sizes) - {"block"}
        np.testing.assert_array_equal(frame.index, data[index])
        assert frame.index.name == index
        columns = 0
        for name, values in data.items():
            blocks = values.sizes.get("block", 0)
            names = [f"{name}[{i}]" for i in range(1, blocks + 1)] if blocks else [name]
            np.testing.assert_array_equal(frame[names].to_numpy().reshape(values.shape), values.to_numpy())
            columns += len(names)
        assert columns == frame.shape[1] > 0


def test_values_and_units_are_those_of_the_response(response: Response) -> None:
    data = response.to_xarray()
    for key, name in {"ux": "ux", "theta": "ry", "N": "N", "contact": "contact", "Fx": "base_Fx"}.items():
        np.testing.assert_array_equal(data[key], getattr(response, name))
    assert [data[name].attrs.get("units") for name in ("time", "ux", "M", "sigma_max")] == ["s", "m", "N m", "Pa"]
    assert data.attrs["verdict"] == response.verdict


def test_what_is_left_of_mortar_has_the_joints_as_its_dimension() -> None:
    folder, still = ROOT / "examples", Motion.from_samples(0.1, [0.0, 0.0])
    column = simulate(Column.from_toml(folder / "columns" / "mortar.toml"), still)
    structure = simulate(Structure.from_toml(folder / "structures" / "parapet.toml"), still)
    for response, names in ((column, [1, 2, 3, 4]), (structure, structure.model.bond_names)):
        bond = response.to_xarray()["bond"]
        assert bond.dims == ("time", "bonded_joint")
        assert list(bond["bonded_joint"].values) == list(names)
        np.testing.assert_array_equal(bond, response.bond)


def test_a_table_is_a_mapping(table: Table) -> None:
    found = dict(table)
    assert list(found) == list(table.keys()) == ["peak_top_ux", "verdict", "path"]
    for name, values in table.items():
        np.testing.assert_array_equal(values, found[name])
    assert len(list(table.values())) == 3
    assert table.get("steps") is None
    assert table.get("peak_top_ux") is not None
    assert len(table) == len(table.to_pandas()) == 3
    assert np.isnan(table.to_pandas().loc[1, "peak_ux[3]"])  # the statue has two blocks
    assert set(table.to_pandas()["verdict"]) <= {"standing", "overturned", "undecided"}


def test_a_record_may_be_a_path(tmp_path: Path) -> None:
    path = tmp_path / "pulse.csv"
    PULSE.to_csv(path)
    for motion in (path, str(path)):
        np.testing.assert_array_equal(simulate(STATUE, motion).peak_top_ux, simulate(STATUE, PULSE).peak_top_ux)


# what is shown


def test_lines_are_short(response: Response, table: Table) -> None:
    study = Study.from_toml(ROOT / "examples" / "studies" / "ida.toml")
    lines = [repr(item) for item in (PHOCAS, PULSE, Motion.harmonic(1.0, 2.0, 3.0), response, table, study)]
    assert max(map(len, lines)) < 100
    assert lines[0] == "<Column phocas_damped: 3 blocks, 14.07 m high, 81 t>"
    assert lines[1] == "<Motion of the base: 4 s, PGA 0.3059 g, 1601 samples>"
    assert f"{1e3 * response.peak_top_ux.max():.4g} mm at most" in lines[3]
    assert "5000 runs" in lines[5]


def test_a_motion_shows_the_peak_of_each_component() -> None:
    level, time = np.zeros(3), np.arange(3.0)
    ay, az = np.array([0.0, -1.0, 0.5]), np.array([0.0, 2.0, 0.0])
    assert "PGA 0.102 g along y, 0.2039 g along z, 3 samples, held" in repr(Motion(time, level, az, 3.0, True, ay=ay))
    assert "PGA 0.2039 g along z, 3 samples" in repr(Motion(time, level, az, 2.0))
    assert "PGA 0 g, 3 samples" in repr(Motion(time, level, level, 2.0))
    across = Motion.harmonic(1.0, 2.0, 3.0, direction=0.5)
    assert "PGA 0.08949 g along x, 0.04889 g along y, harmonic of 2 Hz" in repr(across)
    long = Motion.harmonic(1.0, 50.0, 1000.0, direction=0.5)  # its peaks need no segments
    assert long.peak("ay") == pytest.approx(np.sin(0.5))


def test_html_is_well_formed_and_small(response: Response, table: Table) -> None:
    many = Column("many", PHOCAS.blocks * 100)
    for item in (PHOCAS, STATUE, many, PULSE, Motion.harmonic(1.0, 2.0, 3.0), response, table):
        assert isinstance(item, NotebookRepr)
        html = item._repr_html_()
        ElementTree.fromstring(html.replace("<br>", "<br/>"))
        shown, _, scene = html.partition("<iframe")
        assert len(shown) < 40_000
        assert len(scene) < 250_000  # of the responses; the limit of a notebook that is kept
        assert html.count("<tr>") <= 8  # head, six rows, dots


def test_a_column_is_drawn_to_scale() -> None:
    path = re.search(r'd="([^"]*)"', PHOCAS._picture())
    assert path is not None
    x, z = np.array(re.findall(r"([\d.]+) ([\d.]+)", path[1]), dtype=float).T
    assert np.ptp(x) / np.ptp(z) == pytest.approx(1.56 / 14.07, rel=0.01)  # 0.1 px of 18
    assert outlines([[(0, 0), (1, 0), (1, 1)]]).count("M") == 1


def test_a_history_keeps_its_peaks() -> None:
    values = np.zeros(100_000)
    values[31_234] = 2.0
    values[77_777] = -1.0
    drawn = history(np.linspace(0.0, 10.0, len(values)), values, "a<b")
    assert "a&lt;b, -1 to 2, over 10 s" in drawn
    points = re.search(r'points="([^"]*)"', drawn)
    assert points is not None
    heights = [float(point.split(",")[1]) for point in points[1].split()]
    assert (min(heights), max(heights)) == (0.0, 120.0)  # px, from the top: the picture has room for the text below
    assert len(heights) <= 600


def test_a_motion_is_drawn_with_all_its_components() -> None:
    """Check that ay and az have lines of their own, and that held samples are steps: they were slanted."""
    time, sway = np.array([0.0, 1.0, 2.0]), np.array([1.0, -1.0, 0.5])
    for motion, names in (
        (Motion(time, sway, 0.0 * sway, 2.0), []),
        (Motion(time, sway, 0.5 * sway, 2.0, ay=2.0 * sway), ["ax", "ay", "az"]),
        (Motion.harmonic(1.0, 2.0, 3.0, direction=0.5), ["ax", "ay"]),
    ):
        drawn = motion._picture()
        assert re.findall(r"<tspan[^>]*>(\w+)</tspan>", drawn) == names
        assert drawn.count("<polyline") == max(1, len(names))
    held = Motion(time, sway, 0.0 * sway, 3.0, hold=True)._picture()
    points = re.search(r'points="([^"]*)"', held)
    assert points is not None
    corners = [tuple(map(float, point.split(","))) for point in points[1].split()]
    assert all(a[0] == b[0] or a[1] == b[1] for a, b in itertools.pairwise(corners))
    assert {x for x, _ in corners} == {0.0, 120.0, 240.0, 360.0}


def test_a_harmonic_along_y_is_not_lost() -> None:
    attributes = Motion.harmonic(1.0, 2.0, 3.0, direction=0.5).to_xarray().attrs
    assert attributes["amplitude_y"] == np.sin(0.5)
    assert "amplitude_y" not in Motion.harmonic(1.0, 2.0, 3.0).to_xarray().attrs


def test_a_figure_shows_itself(response: Response) -> None:
    png = response.plot_model()._repr_png_()  # type: ignore[attr-defined]
    assert png.startswith(b"\x89PNG")
    assert len(png) > 5_000
