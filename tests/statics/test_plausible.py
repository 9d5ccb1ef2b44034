"""Warnings of values that are probably not intended: columns, structures and motions have one list."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.fmus import ROOT

from multiblock import Column, InputWarning, Motion, Structure, modes_in_space, simulate, simulate_many
from solver.ground.motion import check_strength
from solver.models.column.rest import warnings_of
from solver.models.structure.rest import known_warnings_in_space
from solver.studies import Study
from solver.studies.execution import run_study

G = 9.80665
LAW = {"stiffness": 1e9, "damping": 1e-3, "friction": 0.7, "strength": 7e7}
SIZES = {"width": 0.9, "depth": 0.9, "height": 1.0}


def structure_with(density: float = 2700.0, g: float = G, law: dict[str, float] = LAW, **sizes: Any) -> Structure:
    block = {"name": "stone", "on": "base", **SIZES, "density": density, **sizes}
    return Structure.from_dict({"name": "one", "g": g, "joints": law, "block": [block]})


def column_with(density: float = 2700.0, g: float = G, law: dict[str, float] = LAW, **sizes: Any) -> Column:
    block = {**SIZES, "density": density, "joint": law, **sizes}
    return Column.from_dict({"name": "one", "g": g, "block": [block]})


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({}, None),
        (
            {"density": 2.7, "law": {**LAW, "damping": 0.0}},
            ".mass = 2.187: is 2.7 kg/m3 in 0.81 m3, should be 500 to 12000",
        ),
        ({"height": 31.0, "width": 20.0, "depth": 20.0}, ".height = 31: should be 30 at most"),
        ({"g": 981.0}, "g = 981: should be 9.7 to 9.9 on Earth"),
        ({"law": {**LAW, "friction": 70.0}}, ".friction = 70: should be 1.5 at most"),
        ({"law": {**LAW, "strength": 70.0}}, ".strength = 70: should be 100000 at least"),
        ({"law": {**LAW, "damping": 2.0}}, ".damping = 2: the first mode has"),
        ({"law": {**LAW, "stiffness": 2e5}, "height": 0.1}, ".stiffness = 200000: "),
    ],
)
def test_columns_and_structures_are_warned_of_the_same(changes: dict[str, Any], said: str | None) -> None:
    column = column_with(**changes)
    found = [warnings_of(column), known_warnings_in_space(structure_with(**changes))]
    for lines in found:
        assert len(lines) == (said is not None)
        assert said is None or said in lines[0]
    assert list(known_warnings_in_space(Structure.stack(column))) == found[0]


def test_the_first_damping_ratio_is_that_of_the_modes() -> None:
    structure = structure_with(law={**LAW, "damping": 0.02})
    ratio = modes_in_space(structure).damping_ratio[0]
    (line,) = known_warnings_in_space(structure)
    said = float(line.partition("first mode has ")[2].split()[0])
    assert said == pytest.approx(ratio, rel=1e-2)  # three digits; measured: 3e-5 before they are rounded


def test_the_stiffness_of_a_tie_is_no_damping() -> None:
    tie = {"between": ["stone", "base"], "from": [0.45, 0.0, 0.5], "to": [2.0, 0.0, 0.0], "tension_only": False}
    stone = {"name": "stone", "on": "base", **SIZES, "density": 2700.0}
    data = {"name": "tied", "joints": {**LAW, "damping": 1e-4}, "block": [stone], "tie": [{**tie, "stiffness": 1e7}]}
    assert known_warnings_in_space(Structure.from_dict(data)) == ()


def test_what_is_sound_is_not_warned_of() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for path in sorted((ROOT / "examples" / "structures").glob("*.toml")):
            assert known_warnings_in_space(Structure.from_toml(path)) == ()
        assert not check_strength(Motion.harmonic(2.9 * G, 1.0, 1e9))


@pytest.mark.parametrize("key", ["ax", "ay", "az"])
def test_a_motion_in_other_units_is_warned_of(key: str) -> None:
    samples: dict[str, Any] = {"ax": np.zeros(3), key: [0.0, -98.1, 0.0]}
    motion = Motion.from_samples(1.0, samples.pop("ax"), **samples)
    with pytest.warns(InputWarning, match=rf"^motion.{key}: reaches 10 g, should be [34] g at most"):
        assert check_strength(motion)


def test_runs_warn_once_wherever_they_are_made() -> None:
    law, strong = {**LAW, "friction": 70.0}, Motion.harmonic(50.0, 2.0, 0.01)
    subjects: list[Any] = [structure_with(law=law), column_with(law=law)]
    for subject in subjects:
        runs = (
            lambda one=subject: simulate(one, strong, settle=0.0),
            lambda one=subject: simulate_many([one, one], strong, settle=0.0),
        )
        for make in runs:
            with pytest.warns(InputWarning) as found:
                make()
            said = [str(warning.message) for warning in found]
            assert len(said) == 2
            assert any("degrees" in line for line in said)
            assert any("motion.ax: reaches 5.099 g" in line for line in said)


def test_studies_in_other_units_are_warned_of() -> None:
    """Check levels of 0.3 g in m/s2, and drawn ones whose median is."""
    drawn = {"distribution": "lognormal", "median": 4.0, "deviation": 0.2}
    for varied in ({"grid": {"intensity": [1.47, 4.0]}}, {"random": {"intensity": drawn}, "samples": 40}):
        motion = {"formula": "harmonic", "frequency": 2.0, "duration": 0.01}
        data = {
            "name": "odd",
            "kind": "fragility",
            "column": str(ROOT / "examples" / "columns" / "phocas.toml"),
            "motion": [motion],
            "duration": 0.01,
        }
        study = Study.from_dict(data | {"intensity": {"measure": "pga"}} | varied)
        with pytest.warns(InputWarning, match=r"^intensity: reaches [34].* g, should be 3 g at most; pga is in g"):
            run_study(study, threads=1)


def test_studies_warn_of_structures_too(tmp_path: Path) -> None:
    blocks = '[[block]]\nname = "stone"\non = "base"\nwidth = 0.9\ndepth = 0.9\nheight = 1.0\ndensity = 2.7\n'
    (tmp_path / "one.toml").write_text(f'name = "one"\njoints = {{stiffness = 1e9, damping = 0.0}}\n{blocks}')
    motion = {"formula": "harmonic", "amplitude": 1.0, "frequency": 2.0, "duration": 0.01}
    data = {"name": "odd", "kind": "ida", "structure": "one.toml", "motion": [motion], "samples": 1}
    study = Study.from_dict(data | {"intensity": {"measure": "pga"}, "grid": {"intensity": [0.1]}}, tmp_path)
    with pytest.warns(InputWarning, match=r"^columns\[0\]: block\[stone\].mass = 2.187: is 2.7 kg/m3"):
        run_study(study, threads=1)
