"""Entries: the engine over flat buffers. Those of every kind of column are made by `entries_of`.

Native FMUs call `assemble` and the entries of driven_entries.py, Python the others.

A column is (n, model, state, counts, base, work). It follows (times, ax, az, scale, held, loads): instants of base and
loads, accelerations of the base, which may end before, and loads on each segment by component, then their slopes.
Inputs at ports lie behind those of the base, peaks of ports behind the state, outputs of ports behind an output row.
"""

from ...engine.circle import ring_part
from ...engine.samples import no_samples, samples_over
from ...layout.spaces import BASE, MODEL, ROW, SPLIT
from ...machine.entry import entry
from ...machine.kinds import Int, Ints, Real, Reals, SizedReals
from ..formulations.allowed_step import examine_step
from ..formulations.base_motion import enter
from ..formulations.coupled_base import arrive, couple, show_driven
from ..joint.energy import least_energy
from ..joint.law import joint_potential, law_of
from ..output.watch import Watch
from ..sections.faces import FaceShape
from ..sections.section import contact_of, lay_out, part_stiffness
from ..stepping.advance import advance
from . import driven_entries, engine
from .engine import BASE_INPUTS
from .observing import observe_all, see_at

_model = MODEL.over
_row, _split, _base, _base_inputs, _INPUTS = ROW.over, SPLIT.over, BASE.over, BASE_INPUTS.over, BASE_INPUTS.beside


def entries_of(group, module, column_over=engine.column_over, assembled=engine.assemble, at_rest=None):
    """Return `assemble`, `run`, `observe_state`, `observe_snapshots`, and three of a base that bodies drive.

    Parameters
    ----------
    group, module : str
        Group of the entries (machine/groups.py), and the module that they are made for.
    column_over : callable
        A leaf that returns the column over its rows (engine.py, `column_in`).
    assembled : callable
        A kernel with the arguments of `engine.assemble`.
    at_rest : str, optional
        Group of `assemble` and of the base; None: the same.
    """

    def assemble(
        n: Int, model: Reals, state: Reals, counts: Ints, base: Reals, work: Reals, given: Reals, from_rest: Int,
        scratch: Reals, detail: Reals,
    ) -> Int:  # fmt: skip
        """Run `engine.assemble`."""
        column = column_over(n, model, state, counts, base, no_samples(given), work)
        return assembled(column, given, from_rest, scratch, detail)

    def run(
        n: Int, model: Reals, state: Reals, counts: Ints, base: Reals, work: Reals, times: SizedReals, ax: SizedReals,
        ay: Reals, az: Reals, scale: Real, held: Int, loads: SizedReals, t: Real, h: Real, at: SizedReals,
        snapshots: Reals, peaks: Int,
    ) -> Int:  # fmt: skip
        """Advance the column from t to t + h over the record, with a snapshot at each of the times `at`.

        Returns a code. peaks: 1 if peaks are kept.
        """
        samples = samples_over(times, ax, ay, az, scale, held, loads)
        column = column_over(n, model, state, counts, base, samples, work)
        return advance(column, t, h, Watch(at.size, at.row, snapshots, peaks))

    def observe_state(
        n: Int, model: Reals, state: Reals, counts: Ints, base: Reals, work: Reals, times: SizedReals, ax: SizedReals,
        ay: Reals, az: Reals, scale: Real, held: Int, loads: SizedReals, t: Real, row: Reals, split: Reals,
    ) -> Int:  # fmt: skip
        """Run `observing.see_at` under the base as it stands. Returns a code."""
        samples = samples_over(times, ax, ay, az, scale, held, loads)
        column = column_over(n, model, state, counts, base, samples, work)
        enter(column.base, column.samples, t)
        parts = _split(split, 0)
        show_driven(column.base, column.model.settings, t, parts)
        return see_at(column, t, _row(row, n), parts)

    def observe_snapshots(
        n: Int, model: Reals, state: Reals, counts: Ints, base: Reals, work: Reals, times: SizedReals, ax: SizedReals,
        ay: Reals, az: Reals, scale: Real, held: Int, loads: SizedReals, at: Reals, snapshots: Reals, rows: Reals,
        count: Int, done: Ints,
    ) -> Int:  # fmt: skip
        """Run `observing.observe_all` of snapshots at the times `at`. Returns a code; done[0] is the number of rows."""
        samples = samples_over(times, ax, ay, az, scale, held, loads)
        column = column_over(n, model, state, counts, base, samples, work)
        code, done[0] = observe_all(column, at, snapshots, rows, count)
        return code

    def arrive_base(n: Int, model: Reals, base: Reals, inputs: Reals, t: Real):
        """Run `coupled_base.arrive`."""
        arrive(_base(base, 0), _model(model, n).settings, _base_inputs(inputs, 0), t)

    def couple_base(n: Int, model: Reals, base: Reals, inputs: Reals, split: Reals) -> Int:
        """Run `coupled_base.couple` by inputs without those of ports."""
        settings, given = _model(model, n).settings, _base_inputs(inputs, 0)
        return couple(_base(base, 0), settings, given, inputs, _INPUTS, _split(split, 0))

    def examine_base(n: Int, model: Reals, base: Reals, h: Real):
        """Run `allowed_step.examine_step`."""
        examine_step(_model(model, n), _base(base, 0), h)

    # entries of both groups
    of_rest, of_motion = entry(at_rest or group, module), entry(group, module)
    moving = [of_motion(made) for made in (run, observe_state, observe_snapshots)]
    return [of_rest(assemble), *moving, *(of_rest(made) for made in (arrive_base, couple_base, examine_base))]


assemble, run, observe_state, observe_snapshots, arrive_base, couple_base, examine_base = entries_of(
    "column", __name__, at_rest="statics"
)
driven_entries.of_columns(assemble.function)


# --- joints, for Python code without a closed form of its own


@entry("statics")
def joint_potentials(n: Int, model: Reals, openings: Reals, slopes: Reals, slips: Reals, found: Reals):
    """Fill `found` with the elastic energy of every joint (J); openings (m) are those in the middle of the contacts."""
    blocks = _model(model, n).blocks
    for i in range(n):
        found[i] = joint_potential(contact_of(blocks, i, slips[i]), law_of(blocks, i), openings[i], slopes[i])


@entry("statics")
def joint_energies(n: Int, model: Reals, i: Int, slip: Real, slopes: SizedReals, weights: Reals, found: Reals):
    """Fill `found` with `least_energy` of joint i at the given slip (m), for every slope (rad) and weight (N)."""
    blocks = _model(model, n).blocks
    # contact and law of the joint
    contact, law = contact_of(blocks, i, slip), law_of(blocks, i)
    for k in range(slopes.size):
        found[k] = least_energy(contact, law, slopes.row[k], weights[k])


@entry("statics")
def lay_joint(own: Reals, depths: Reals, count: Real, below: Reals, rim: Real, model: Reals, found: Reals):
    """Lay out the contact of the only joint of a model (section.py, `lay_out`) from the numbers of its faces.

    found: filled with its area (m2), and its first and second moment about the middle of the block (m3, m4).
    """
    blocks = _model(model, 1).blocks
    # faces of the block and of what is under it
    upper, lower = FaceShape(own[0], own[1], own[2], own[3]), FaceShape(below[0], below[1], below[2], below[3])
    lay_out(blocks, 0, upper, count, depths, lower, rim)
    found[0], found[1], found[2] = part_stiffness(contact_of(blocks, 0), 1.0, blocks.left[0], blocks.right[0])


@entry("statics")
def rings_beyond(outer: Reals, inner: Reals, edges: SizedReals, first: Reals, second: Reals):
    """Fill `first` and `second` with the first and second moment (m3, m4), about an edge, of each annulus beyond it.

    edges: distances from the centre (m). outer, inner: radii (m); inner is 0 for a circle.
    """
    for k in range(edges.size):
        edge = edges.row[k]
        middle, area, about, square = ring_part(outer[k], inner[k], edge, outer[k])
        # from the middle of the part to the edge
        off = middle - edge
        first[k] = about + off * area
        second[k] = square + off * (2.0 * about + off * area)
