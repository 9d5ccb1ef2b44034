"""The table of variables: value references that never change, true limits, the words of the solver."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.fmus import ROOT

from fmu_src.description_parts import About, Experiment
from fmu_src.model_description import model_description
from fmu_src.model_description3 import model_description3
from fmu_src.record import usual_experiment
from fmu_src.references import FAMILIES, FAMILY, REFERENCES
from fmu_src.structure_variables import structure_variables
from fmu_src.variables import ROLES, column_from, variables
from solver import Block, Column, Joint, Motion
from solver.common.ranges import MAX_BLOCKS, NUMBERS
from solver.ground.building import Building, floor_motion
from solver.models.column.settings import FORMULATIONS
from solver.models.structure.model import Structure

KEPT = Path(__file__).with_name("value_references.txt")
DAMPED = ROOT / "examples/columns/phocas-damped.toml"


def stack(n: int) -> Column:
    return Column("stack", (Block(1.0, 1.0, 1.0, 2000.0, Joint(1e9, 0.0)),) * n)


def test_value_references_never_change() -> None:
    """Compare with the file, which is added to, never changed: couplings and programs of users rely on these
    numbers.
    """
    kept = {name: int(number) for name, number in map(str.split, KEPT.read_text(encoding="utf-8").splitlines())}
    columns = [Column.from_toml(DAMPED).with_settings(formulation=formulation) for formulation in FORMULATIONS]
    table = {variable.name: variable.reference for column in columns for variable in variables(column)}
    assert table == kept


@pytest.mark.parametrize("n", [1, 3, MAX_BLOCKS])
def test_the_rule_for_any_number_of_blocks(n: int) -> None:
    table = variables(stack(n))
    references = [variable.reference for variable in table]
    assert len(set(references)) == len(references)
    assert 0 not in references
    for variable in table:
        if "[" in variable.name:
            owner, number, quantity = variable.name.replace("]", "").replace(".", "[").split("[")
            assert variable.reference == FAMILY * FAMILIES[f"{owner}.{quantity}"] + int(number)
        else:
            assert variable.reference == REFERENCES[variable.name]


def test_no_number_is_given_twice() -> None:
    assert len(set(REFERENCES.values())) == len(REFERENCES)
    assert len(set(FAMILIES.values())) == len(FAMILIES)
    assert max(REFERENCES.values()) < FAMILY * min(FAMILIES.values())


def test_inputs_come_first_then_outputs_then_parameters() -> None:
    table = variables(stack(3))
    root = model_description(About("stack", "{}", "", "1", Experiment(), {}, ""), list(reversed(table)))
    for roles in (
        [variable.causality for variable in table],
        [element.get("causality") for element in root.iter("ScalarVariable")],
    ):
        assert roles == sorted(roles, key=ROLES.index)


def test_limits_are_those_that_the_column_is_checked_by() -> None:
    for variable in variables(stack(2)):
        key = variable.name.rpartition(".")[2]
        if variable.causality != "parameter" or variable.kind != "Real" or variable.name == "base.record_scale":
            continue
        least, most = NUMBERS[key][0]
        of_joint = variable.name.startswith("joint") and key in ("width", "depth", "friction", "dowel", "rim")
        optional = of_joint or key in ("centroid", "inertia")
        assert (variable.minimum, variable.maximum) == (0.0 if optional else least, most), variable.name


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_the_table_gives_the_column_back(formulation: str) -> None:
    """Check that the formulation is that of the column as built; a step is a parameter where it is fixed."""
    column = Column.from_toml(DAMPED).with_settings(formulation=formulation, without=("rest", "elastic"))
    values: dict[str, Any] = {variable.name: variable.start for variable in variables(column)}
    assert column_from(column, values.__getitem__) == column
    assert ("solver.step" in values) == (formulation == "paper")
    assert values.keys().isdisjoint({"solver.formulation", "solver.integrator"})


def test_large_columns_do_not_list_what_grows_with_the_square_of_their_blocks() -> None:
    for n in (3, 200):
        by_name = {variable.name: variable for variable in variables(stack(n))}
        assert (by_name["block[1].ux"].initially is None) == (n == 200)
        assert by_name["base.R0x"].initially is not None
        assert by_name["overturned"].initially == ()


def sampled(times: list[float]) -> Motion:
    """Return a motion with samples at these times."""
    ones = np.ones(len(times))
    return Motion(np.array(times), ones, ones, times[-1] - times[0])


@pytest.mark.parametrize(
    ("dt", "count", "end"), [(0.01, 3000, 29.99), (0.005, 60000, 299.995), (1.0 / 128.0, 129, 1.0)]
)
def test_the_usual_experiment_has_the_numbers_of_the_record(dt: float, count: int, end: float) -> None:
    """Check what rounding leaves of them where times are multiplied, added up, or read."""
    experiment = usual_experiment(None, Motion.from_samples(dt, np.ones(count)))
    assert (experiment.start, experiment.stop, experiment.step) == (0.0, end, dt)
    read = sampled([float(f"{k * dt:.7f}") for k in range(count)])
    assert usual_experiment(1e-5, read).step == dt


def test_the_usual_experiment_has_the_shortest_interval_of_an_uneven_record() -> None:
    experiment = usual_experiment(None, sampled([1.0, 1.3, 1.7, 29.99]))
    assert (experiment.start, experiment.stop, experiment.step) == (1.0, 29.99, 0.3)


def test_the_usual_experiment_does_not_take_the_drop_at_the_end_of_the_ground_for_an_interval() -> None:
    ground = Motion.from_samples(0.01, np.sin(0.1 * np.arange(500)))  # ends with an acceleration
    moved = floor_motion(ground, Building.from_toml(ROOT / "examples" / "gallery" / "hall.toml"), 2)
    assert np.min(np.diff(moved.time)) < 1e-5
    assert usual_experiment(None, moved).step > 1e-3


def posts_that_go_on(after_fall: float) -> Structure:
    """Return three posts beside each other whose runs go on after a fall."""
    sizes = {"width": 0.5, "depth": 0.5, "height": 2.0, "density": 2500.0}
    blocks = [{"name": name, "on": "base", "at": [0.7 * k, 0.0], **sizes} for k, name in enumerate(("low", "hi", "up"))]
    law = {"reach": 0.3, "stiffness": 1e9, "restitution": 0.5, "friction": 0.4, "after_fall": after_fall}
    joints = {"stiffness": 1e9, "damping": 1e-3}
    return Structure.from_dict({"name": "posts", "joints": joints, "block": blocks, "neighbours": law})


def test_after_a_fall_and_in_arrays_descriptions_are_true() -> None:
    """Check words of structures that go on after a fall, and that arrays name no element."""
    showcase = ROOT / "examples" / "structures" / "showcase.toml"
    for structure, held in ((Structure.from_toml(showcase), "then"), (posts_that_go_on(1.5), "1.5 s later")):
        table = structure_variables(structure)
        by_name = {variable.name: variable for variable in table}
        assert by_name["overturned"].description == f"Whether it has overturned; {held} it is held"
        choice = by_name["verdict"].choice
        assert choice is not None
        assert choice.meanings["overturned"].endswith("is held" if held == "then" else "is held 1.5 s later")
    root = model_description3(About("posts", "{}", "", "1", Experiment(), {}, ""), table, ())
    said = {element.get("name"): element.get("description") or "" for element in root.iter("Float64")}
    assert {"contact.gap", "contact.force", "contact.gap_least", "contact.force_peak"} <= said.keys()
    for name, text in said.items():
        assert "(low" not in text, name
        if (name or "").startswith("contact."):
            assert "of contact i" in text
