"""Pictures of tables, short texts of fragilities, and the types of responses, which mypy checks: it reads tests too."""

import inspect
from collections.abc import Callable
from pathlib import Path
from types import FunctionType
from typing import Any, assert_type

import numpy as np
import pytest
from support.fmus import ROOT

import multiblock
from multiblock import (
    Column,
    InputError,
    Motion,
    Response,
    SpatialResponse,
    Structure,
    calibrate,
    simulate,
    simulate_many,
    studies,
    wavelets,
)

STATUE = Column.from_toml(ROOT / "examples" / "columns" / "statue.toml")
PULSES = [wavelets.ricker(size * 9.80665, 1.0) for size in (0.2, 0.4, 0.6, 0.8)]


def types(column: Column, structure: Structure, motion: Motion) -> None:
    """State types; it is never called."""
    assert_type(simulate(column, motion), Response)
    assert_type(simulate(structure, "RECORD.AT2"), SpatialResponse)
    assert_type(simulate(structure, motion, plane="auto"), Response | SpatialResponse)
    assert_type(column.in_space(), Structure)


def test_the_picture_of_a_table_has_a_mark_for_each_run(tmp_path: Path) -> None:
    table = simulate_many(STATUE, PULSES)
    (axes,) = table.plot(tmp_path / "table.png").axes
    assert (tmp_path / "table.png").stat().st_size > 1000
    drawn = np.sort(np.concatenate([np.asarray(line.get_xdata()) for line in axes.lines]))
    np.testing.assert_array_equal(drawn, range(len(PULSES)))
    stands = table["verdict"] == "standing"
    (standing,) = (line for line in axes.lines if str(line.get_label()).startswith("standing"))
    np.testing.assert_allclose(np.asarray(standing.get_ydata()), 1e3 * table["peak_top_ux"].max(axis=1)[stands])
    with pytest.raises(InputError, match="keep: must have one of peak_u, peak_top_ux, peak_centroid_ux for"):
        simulate_many(STATUE, PULSES, keep=("verdict",)).plot()


def test_results_draw_the_picture_of_their_kind_and_fragilities_are_short() -> None:
    motions = {f"pulse {k}": pulse for k, pulse in enumerate(PULSES)} | {"fast": Motion.harmonic(1.0, 4.0, 0.5)}
    results = studies.fragility(STATUE, motions, {}, 1, levels=[0.2, 0.4, 0.6, 0.8])
    assert results.plot().axes[0].get_ylabel() == "probability of failure"
    found = studies.fit_fragility(results)
    assert found.curves.shape == (200, 2)
    assert repr(found).startswith(f"<Fragility over pga: median {found.median:.3g} (")
    assert max(len(repr(found)), len(repr(found.bins))) < 160


def public_functions() -> list[Callable[..., Any]]:
    """Return the functions of the public interface that take anything but the path of a file."""
    found = {getattr(module, name) for module in (multiblock, studies) for name in module.__all__}
    found |= {item for item in vars(calibrate).values() if getattr(item, "__module__", "") == calibrate.__name__}
    of_files = {calibrate.read_history, studies.write_fragilities}
    public = [one for one in found - of_files if isinstance(one, FunctionType) and not one.__name__.startswith("_")]
    return sorted(public, key=lambda one: one.__qualname__)


@pytest.mark.parametrize("function", public_functions(), ids=lambda one: one.__qualname__)
def test_an_argument_of_another_type_is_refused_by_its_name(function: Callable[..., Any]) -> None:
    parameters = inspect.signature(function).parameters.values()
    needed = [one for one in parameters if one.default is one.empty and one.kind is not one.VAR_KEYWORD]
    with pytest.raises(InputError, match=r"^[\w.]+ = <object.*: must be "):
        for _ in function(*[object() for _ in needed]):  # of a generator: runs its body
            pass
