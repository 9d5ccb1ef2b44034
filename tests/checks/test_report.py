"""The report of a check: its tables of the model, sources and files, and what its pictures show."""

from __future__ import annotations

import hashlib
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from multiblock import Block, Column, InputError, Joint, Motion, Structure, check, simulate
from solver.checks.check import Check
from solver.checks.limits import Plan
from solver.checks.report.html import write_report
from solver.checks.report.inputs import hashed, sources_of, with_meshes
from solver.checks.report.pictures import spectra_picture
from solver.models.column.materials import MATERIALS
from solver.plotting.plots import plot_response

STILL = Plan(ensemble=1, margin=False, joints=False)
JOINT = Joint(2e9, 2e-3, width=0.5, depth=0.4, tensile_strength=1e5, cohesion=1.5e5, friction=0.6)
PEDESTAL = Column(
    "pedestal",
    (
        Block(1.5, 0.6, 0.5, 1000.0, JOINT, centroid=0.6),
        Block(0.5, 1.0, 1.0, 1250.0, replace(JOINT, width=1.0, depth=1.0)),
    ),
)
FILE = """name = "pillar"
material = "marble"
[joint]
damping = 1e-3
[[block]]
height = 1.0
width = 0.5
depth = 0.5
[[block]]
height = 0.5
width = 0.7
depth = 0.7
density = 2000.0
[[block]]
height = 0.5
width = 1.0
depth = 1.0
material = "brick"
mass = 900.0
"""


@pytest.fixture(scope="module")
def found() -> Check:
    time = np.arange(0.0, 2.0, 0.01)
    motions = {f"{f} Hz": Motion.from_samples(0.01, np.sin(2.0 * np.pi * f * time)) for f in (1.0, 3.0)}
    return check(PEDESTAL, motions, plan=STILL)


@pytest.mark.long  # takes seconds
def test_the_report_has_sizes_strengths_files_and_fields(found: Check, tmp_path: Path) -> None:
    file, record = tmp_path / "pillar.toml", tmp_path / "record.csv"
    file.write_text(FILE, encoding="utf-8")
    record.write_text("0.0,1.0\n", encoding="utf-8")
    write_report([found], tmp_path / "report.html", inputs=[file, record])
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    rows = [re.findall(r">([^<>]*)</t[dh]>", row) for row in page.split("<tr>")]
    assert ["1", "rectangle", "1.5", "0.6", "0.5", "0.6", "1000"] in rows  # centroid 0.6 m above the bottom
    assert ["1", "rectangle", "0.5", "0.4", "2", "0.002", "0.6", "none"] in rows  # contact 0.5 x 0.4 m
    assert ["1 to 2", "0.1", "0.15"] in rows  # both strengths of mortar, MPa
    for path in (file, record):
        assert hashlib.sha256(path.read_bytes()).hexdigest() in page
    for words in ("signature", "checker", "Housner", "horizontal component", "Varied data", "counter(pages)"):
        assert words in page


def contacts_of(model: Column | Structure, folder: Path) -> tuple[str, list[list[str]]]:
    """Return the report of a check of a model under a short still motion, and the cells of its rows."""
    motion = Motion.from_samples(0.01, np.sin(np.arange(0.0, 1.0, 0.01)))
    write_report([check(model, {"still": motion}, plan=STILL)], folder / "page.html")
    page = (folder / "page.html").read_text(encoding="utf-8")
    return page, [re.findall(r">([^<>]*)</t[dh]>", row) for row in page.split("<tr>")]


def test_contacts_have_width_along_x_and_depth_along_y(tmp_path: Path) -> None:
    """Check a slab wider than it is deep and a heavy one, in space."""
    slab = {"density": 2500.0, "height": 0.5, "on": "base"}
    blocks = [
        {"name": "wide", "at": [0.0, 0.0], "width": 0.8, "depth": 0.5, **slab},
        {"name": "deep", "at": [9.0, 0.0], "width": 2.0, "depth": 5.0, **slab},
    ]
    structure = Structure.from_dict({"name": "slabs", "joints": {"stiffness": 2e9, "damping": 2e-3}, "block": blocks})
    page, rows = contacts_of(structure, tmp_path)
    # the more slender of both slabs, along y: 1 - 1.5 sin^2(45 degrees)
    assert "wide across, alone on its joint: Restitution" in page
    assert "rigid block 0.250" in page
    assert ["wide-base", "plane", "0.8", "0.5", "2", "0.002", "none", "none"] in rows
    assert ["deep-base", "plane", "2", "5", "2", "0.002", "none", "none"] in rows
    assert ["deep", "2 x 5 x 0.5", "0.25", "12500"] in rows


@pytest.mark.long  # needs machine code of its own
def test_contacts_are_named_as_strips(tmp_path: Path) -> None:
    strips = Joint(2e9, 2e-3, section="strips", strips=(0.4, 0.1, 0.1, 0.4))
    _, rows = contacts_of(Column("striped", (Block(1.5, 0.6, 0.5, 1000.0, strips),)), tmp_path)
    assert ["1", "4 strips, depth 0.1 to 0.4 m", "0.6", "0.5", "2", "0.002", "none", "none"] in rows


def test_sources_are_those_of_the_tables(tmp_path: Path) -> None:
    file = tmp_path / "pillar.toml"
    file.write_text(FILE, encoding="utf-8")
    first, second, third = sources_of(file)
    assert first == ("1", "marble", f"{MATERIALS['marble'].density:g}", MATERIALS["marble"].source)
    assert second[:3] == ("2", "marble", "2000")
    assert second[3].startswith("density or mass given in the file; else ")
    assert third[:3] == ("3", "brick", "mass 900 kg")


def test_meshes_of_blocks_are_inputs_too(tmp_path: Path) -> None:
    model = tmp_path / "model.toml"
    model.write_text('[[block]]\nfile = "head.obj"\n[[block]]\nshape = "box"\n', encoding="utf-8")
    (tmp_path / "head.obj").write_bytes(b"v 0 0 0\n")
    paths = with_meshes([model, model])
    assert paths == [model, tmp_path / "head.obj"]
    assert hashed(paths)[1][1] == hashlib.sha256(b"v 0 0 0\n").hexdigest()


def test_spectra_are_grey_and_their_mean_black(found: Check) -> None:
    lines = {line.get_label(): line for line in spectra_picture(found).axes[0].lines}
    each = lines["each of 2 motions"]
    assert (each.get_color(), lines["mean"].get_color()) == ("0.65", "black")
    assert each.get_linewidth() < lines["mean"].get_linewidth()


def test_panels_without_an_event_are_left_out() -> None:
    dry = Column("dry", tuple(replace(one, joint=Joint(2e9, 2e-3, friction=0.6)) for one in PEDESTAL.blocks))
    still = simulate(dry, Motion.from_samples(0.1, np.zeros(11)))
    rocks = simulate(dry, Motion.harmonic(4.0, 1.0, 2.0))
    shown = [[axes.get_title(loc="left")[4:] for axes in plot_response(run).axes] for run in (still, rocks)]
    contact, slip = "width in contact, white: all", "slip over the body below"
    assert (contact in shown[0], slip in shown[0], contact in shown[1]) == (False, False, True)


def test_a_model_without_a_report_is_refused() -> None:
    from types import SimpleNamespace

    from solver.checks.report.model import shown_of

    unknown = SimpleNamespace(kind=SimpleNamespace(word="bridge"))
    with pytest.raises(InputError, match="report: a bridge has none"):
        shown_of(unknown, None, None)  # type: ignore[arg-type]
