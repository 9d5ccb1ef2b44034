"""The table of outputs of a model, and what is made from it."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from support.fmus import ROOT

from fmu_src.structure_variables import structure_variables
from fmu_src.variables import Variable, variables
from multiblock import Column, Motion, Structure, simulate
from solver.models.column.response import Response
from solver.models.outputs import BASE, BLOCK, JOINT, Histories, Output, peaks_by_name, places_of, units_of
from solver.models.protocol import Kept, kept_peaks
from solver.models.structure.response import SpatialResponse

PHOCAS = Column.from_toml(ROOT / "examples" / "columns" / "phocas-damped.toml")
COLONNADE = Structure.from_toml(ROOT / "examples" / "structures" / "colonnade.toml")
SIZES = {"block": 2, "joint": 1, "tie": 0, "base": 2}


class Three(Histories):
    """Outputs of two blocks with one joint."""

    u = Output(BLOCK, "m", "Place of {it}")
    c = Output(JOINT, "", "Contact of joint {i}", 0.0, 1.0, by_least=True)
    total = Output(BASE, "N", "Sum")
    both = Output(BASE, "", parts=(Output(BASE, "N", name="F"), Output(BASE, "N m", name="M")))
    late = Output(BLOCK, "s", only_peak=True)

    def __init__(self) -> None:
        self.rows = np.arange(12.0).reshape(2, 6)

    @property
    def model(self) -> SimpleNamespace:
        return SimpleNamespace(sizes=SIZES)


def test_a_row_of_the_table_is_the_history() -> None:
    one = Three()
    assert one.u.tolist() == [[0.0, 1.0], [6.0, 7.0]]
    assert one.c.tolist() == [[2.0], [8.0]]
    assert one.total.tolist() == [3.0, 9.0]
    assert one.both.tolist() == [[4.0, 5.0], [10.0, 11.0]]
    assert (Three.u.field, Three.u.unit, Three.c.most) == ("u", "m", 1.0)
    with pytest.raises(AttributeError, match="late: has no history, only a peak"):
        _ = one.late
    assert not hasattr(one, "late")


def test_names_places_and_units_follow(tmp_path: Path) -> None:
    one = Three()
    assert one.row_names == ["block[1].u", "block[2].u", "joint[1].c", "base.total", "base.F", "base.M"]
    assert [Three.u.peak_of(2), Three.c.peak_of(1)] == ["block[2].u_peak", "joint[1].c_least"]
    assert places_of(Three.outputs, SIZES)["late"] == slice(6, 8)
    assert units_of(Three.outputs) == {"time": "s", "u": "m", "total": "N", "late": "s"}
    one._write(tmp_path / "rows.csv", 3, {"time": np.array([0.0, 0.5])}, {"a,b": np.array([1.0, 1.0 / 3.0])})
    assert (tmp_path / "rows.csv").read_bytes() == (
        b'time,block[1].u,block[2].u,joint[1].c,base.total,base.F,base.M,"a,b"\r\n'
        b"0,0,1,2,3,4,5,1\r\n0.5,6,7,8,9,10,11,0.333\r\n"
    )


def test_peaks_and_what_can_be_kept_follow() -> None:
    stored = np.arange(8.0)
    peaks = peaks_by_name(Three.outputs, SIZES, stored)
    found = {name: values.tolist() for name, values in peaks.items()}
    assert found == {"u": [0.0, 1.0], "c": [-1.0], "total": [3.0], "both": [4.0, 5.0], "late": [6.0, 7.0]}
    peaks["u"][0] = 9.0
    assert stored[0] == 0.0  # copies
    kept = kept_peaks(Three.outputs)
    assert list(kept) == ["peak_u", "least_c", "peak_late", "peak_total", "peak_both"]
    assert kept["peak_total"] == Kept("N", np.float64, "base")  # one number of a run
    assert kept["peak_both"] == Kept("", None, "base")


@pytest.mark.parametrize(
    ("response", "model", "table"),
    [(Response, PHOCAS, variables(PHOCAS)), (SpatialResponse, COLONNADE, structure_variables(COLONNADE))],
)
def test_outputs_of_an_fmu_are_those_of_a_response(
    response: type[Histories], model: Column | Structure, table: list[Variable]
) -> None:
    """Compare in the order of the kernels: the row, and later on its peaks."""
    outputs = response.outputs
    assert outputs == model.kind.outputs
    labels = {owner: range(1, size + 1) for owner, size in model.sizes.items()} | {BASE: range(1)}
    each = [(output, one, i) for output in outputs for one in output.each for i in labels[output.owner]]
    row = [one.name_of(i) for output, one, i in each if not output.only_peak]
    peaks = [one.peak_of(i) for _, one, i in each]
    names = [variable.name for variable in table if variable.causality == "output"]
    assert names[: len(row)] == row
    first = names.index(peaks[0])
    assert names[first : first + len(peaks)] == peaks
    by_name = {variable.name: variable for variable in table}
    for output, one, i in each:
        peak = by_name[one.peak_of(i)]
        assert peak.unit == one.unit.replace(" ", ".")
        assert (peak.minimum, peak.maximum) == (output.least if output.by_least else 0.0, output.most)
        if not output.only_peak:
            own = by_name[one.name_of(i)]
            assert (own.minimum, own.maximum) == (output.least, output.most)
            assert (
                peak.description
                == f"{'Least' if output.by_least else 'Largest absolute'} value of the motion so far: {own.description}"
            )


MORTAR = {"friction": 0.6, "tensile_strength": 2e5, "cohesion": 3e5}
LAW = {"stiffness": 2e8, "damping": 2e-3}
BOX = {"height": 2.0, "width": 0.6, "depth": 0.5, "density": 2500.0}
RUBBER = {"kind": "elastomeric", "stiffness": 5e5, "damping": 5e3, "diameter": 0.2, "capacity": 0.5}
RUBBER |= {"vertical_stiffness": 2e8, "vertical_damping": 2e-3}
RUBBER |= {"between": ["a", "base"], "at": [[x, y, 0.1] for x in (-0.2, 0.2) for y in (-0.2, 0.2)]}


def _on_rubber(tension: bool) -> Structure:
    block, bearing = {"name": "a", "position": [0.0, 0.0, 0.1], **BOX}, {**RUBBER, "tension": tension}
    return Structure.from_dict({"name": "s", "block": [block], "bearing": [bearing]})


def _in_space(law: dict[str, float]) -> Structure:
    blocks = [{"name": f"b{k}", "on": "base", "at": [1.0 * k, 0.0], **BOX} for k in range(2)]
    pair = {"reach": 0.6, "stiffness": 1e9, "restitution": 0.5, "friction": 0.4}
    return Structure.from_dict({"name": "s", "joints": {**LAW, **law}, "block": blocks, "neighbours": pair})


@pytest.mark.parametrize(
    ("model", "pulled"),
    [
        (Column.from_dict({"name": "dry", "joint": LAW, "block": [BOX]}), set()),
        (Column.from_dict({"name": "mortar", "joint": {**LAW, **MORTAR}, "block": [BOX]}), {"N"}),
        (_in_space({}), set()),
        (_in_space(MORTAR), {"N"}),
        (_on_rubber(tension=False), set()),
        (_on_rubber(tension=True), {"N", "sigma_max"}),
    ],
    ids=lambda value: value.name if hasattr(value, "name") else "",
)
def test_what_an_fmu_says_of_the_range_of_outputs_is_so(model: Column | Structure, pulled: set[str]) -> None:
    """Compare with a run that pulls at joints and lets neighbours meet: just what bears tension has no minimum."""
    time = 0.005 * np.arange(201)
    motion = Motion.from_samples(0.005, 3.0 * np.sin(9.4 * time), az=25.0 * np.sin(12.6 * time))
    response = simulate(model, motion)
    table = variables(model) if isinstance(model, Column) else structure_variables(model)
    row = [variable for variable in table if variable.causality == "output"][: response.rows.shape[1]]
    for variable, lowest in zip(row, response.rows.min(axis=0), strict=True):
        if variable.minimum is not None:
            assert lowest >= variable.minimum, variable.name
        owner, _, quantity = variable.name.partition("].")
        if owner.startswith("joint[") and quantity in ("N", "sigma_max"):
            assert (variable.minimum is None, lowest < 0.0) == (quantity in pulled,) * 2, variable.name
    gaps = {variable.minimum for variable in table if variable.name.endswith(".gap_least")}
    assert gaps <= {None}
