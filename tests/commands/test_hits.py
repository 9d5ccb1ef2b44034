"""Neighbours in the summary of `simulate`: least gaps, forces and first contacts by pair, and the envelope."""

import math

import numpy as np
import pytest
from support.fmus import ROOT

from multiblock import Motion, Structure, simulate, wavelets
from solver.checks.answer import falls_sentence
from solver.commands.outcome import verdict_line
from solver.commands.structure import report, summary
from solver.models.structure.modes import frequencies_at_rest, modes_in_space
from solver.models.structure.response import SpatialResponse

CASK = {"on": "base", "shape": "drum", "diameter": 1.0, "height": 3.0, "density": 2000.0}
PLACES = {"first": 0.0, "second": 1.05, "far": 2.9}


@pytest.fixture(scope="module")
def run() -> SpatialResponse:
    """Shake three casks, of which the first two hit each other and the third stands too far away."""
    blocks = [{**CASK, "name": name, "at": [at, 0.0]} for name, at in PLACES.items()]
    blocks[0]["height"] = 2.0
    law = {"stiffness": 1e9, "damping": 3e-3, "friction": 0.6}
    meet = {"reach": 1.0, "line_stiffness": 1e8, "restitution": 0.4, "friction": 0.3}
    made = Structure.from_dict({"name": "row", "joints": law, "neighbours": meet, "block": blocks})
    return simulate(made, Motion.harmonic(3.6, 0.8, 1.5), check=False)


def test_impacts_are_in_the_order_of_first_contact(run: SpatialResponse) -> None:
    assert [one.between for one in run.impacts] == ["first-second", "second-far"]
    hit, missed = run.impacts
    assert hit.gap == run.peaks["gap"][0] < 0.0 < hit.force == run.peaks["hit"][0]
    assert 0.0 < run.time[np.argmax(run.hit[:, 0] > 0.0)] - hit.first < run.time[1]
    assert missed.gap > 0.0 == missed.force
    assert math.isnan(missed.first)
    assert missed.texts[2:] == ("0", "none", "")


def test_the_summary_has_gaps_forces_and_the_envelope(run: SpatialResponse) -> None:
    lines = summary(run).splitlines()
    heading = next(k for k, line in enumerate(lines) if line.startswith("neighbours "))
    for line, one in zip(lines[heading + 1 : heading + 3], run.impacts, strict=True):
        assert tuple(line.split()) == tuple(text for text in one.texts if text)
    envelope = next(line for line in lines if line.startswith("envelope of the centroids: "))
    assert f"x {1e3 * run.ux.min():.4g} to {1e3 * run.ux.max():.4g} mm" in envelope
    block = int(np.argmax(run.peaks["u"]))
    assert f"farthest {run.model.names[block]} by {1e3 * run.peaks['u'][block]:.4g} mm at" in envelope


def test_frequencies_say_that_neighbours_touch_at_rest() -> None:
    for gap, words in ((0.0, "frequencies, with neighbours in touch: "), (0.01, "frequencies ")):
        blocks = [{**CASK, "name": f"at {at:g}", "at": [at, 0.0]} for at in (0.0, 1.0 + gap)]
        law = {"stiffness": 1e9, "damping": 3e-3}
        meet = {"reach": 1.0, "line_stiffness": 1e8, "restitution": 0.4, "friction": 0.3}
        made = Structure.from_dict({"name": "row", "joints": law, "neighbours": meet, "block": blocks})
        found = modes_in_space(made).frequency if gap else frequencies_at_rest(made)
        lowest = ", ".join(f"{value:.4g}" for value in found[:3])
        assert f"first natural {words}{lowest} Hz\n" in report(made, Motion.harmonic(1.0, 1.0, 0.5))


def test_without_neighbours_there_is_no_table() -> None:
    alone = Structure.from_dict(
        {"name": "alone", "joints": {"stiffness": 1e9, "damping": 3e-3}, "block": [{**CASK, "name": "one"}]}
    )
    response = simulate(alone, Motion.harmonic(1.0, 1.0, 0.5), settle=0.0, check=False)
    assert response.impacts == ()
    assert "neighbours" not in summary(response)


def test_a_fall_names_the_hits_before_it() -> None:
    blocks = [{**CASK, "name": name, "at": [at, 0.0]} for name, at in PLACES.items()]
    law = {"stiffness": 1e9, "damping": 3e-3, "friction": 0.6}
    meet = {"reach": 1.0, "line_stiffness": 1e8, "restitution": 0.4, "friction": 0.3}
    made = Structure.from_dict({"name": "row", "joints": law, "neighbours": meet, "block": blocks})
    response = simulate(made, Motion.harmonic(4.5, 0.7, 4.0), check=False)
    assert response.overturned
    before = [one for one in response.impacts if one.first <= response.overturn_time]
    assert before
    said = ", ".join(f"{one.between} at {one.first:.4g} s" for one in before)
    assert verdict_line(response).endswith(f"{response.what_fell}; before it these hit each other: {said}")
    assert f"({response.what_fell}; before it {said} hit each other)" in falls_sentence("structure", ["m"], [response])


def test_rows_change_neither_steps_nor_peaks_nor_hits() -> None:
    """Compare rows 1 ms and 50 ms apart; the energy of the hit is that of its velocity, taken from fine rows."""
    structure = Structure.from_toml(ROOT / "examples" / "structures" / "facade.toml")
    motion = wavelets.ricker(0.4 * 9.80665, 1.5)
    fine, coarse = (simulate(structure, motion, output_step=step, settle=0.0) for step in (2e-4, 0.05))
    assert fine.stats["steps"] == coarse.stats["steps"]
    assert fine.impacts == coarse.impacts
    for name, peak in fine.peaks.items():
        assert np.array_equal(peak, coarse.peaks[name]), name
    assert np.all(fine.peaks["u"] >= np.maximum(fine.peaks["ux"], fine.peaks["uy"]))
    (k,) = np.flatnonzero(fine.peaks["hit"] > 0.0)
    last = int(np.argmax(fine.hit[:, k] > 0.0)) - 1
    rate = (fine.gap[last, k] - fine.gap[last - 1, k]) / 2e-4
    # measured: 1 % apart, by the rows
    assert fine.impacts[0].energy == pytest.approx(0.5 * structure.blocks[1].mass * rate**2, rel=0.03)
