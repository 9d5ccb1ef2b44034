"""Entries called from Python: the engine over arrays. Those of every kind of column are made by `entries_of`.

A column is (n, model, state, counts, base, work); what it follows (times, ax, az, scale, held, loads, ports): samples
of the base, and behind them what a column with ports has (ports/entries.py); of others both are empty.
"""

from ..formulations.allowed_step import examine_step
from ..formulations.base_motion import Samples, enter
from ..formulations.coupled_base import arrive, couple, show_driven
from ..joint.energy import least_energy
from ..joint.law import joint_potential, law_of
from ..layout.spaces import BASE, MODEL, ROW, SPLIT
from ..numba_ext.jit import entry, leaf
from ..numba_ext.views import row_of
from ..output.watch import Watch
from ..sections.circle import ring_part
from ..sections.faces import Face
from ..sections.section import contact_of, lay_out, part_stiffness
from ..stepping.advance import advance
from .engine import BASE_INPUTS, assemble, column_over
from .observing import base_of, observe_all, see

_model = MODEL.over
_row, _split, _base, _base_inputs, _INPUTS = ROW.over, SPLIT.over, BASE.over, BASE_INPUTS.over, BASE_INPUTS.beside


@leaf
def _samples(times, ax, az, scale, held, loads, ports, at):
    return Samples(times.size, row_of(times), row_of(ax), row_of(az), scale, held)


def entries_of(module, column_over=column_over, samples_of=_samples, assemble=assemble):
    """`assemble_column`, `run`, `observe_state` and `observe_snapshots` of a kind of column, for a module.

    column_over: a leaf, the column over its rows (engine.py, `column_in`). samples_of: a leaf, what is followed, with
    the times of snapshots, s. assemble: as `engine.assemble`.
    """

    @leaf
    def column_of(n, model, state, counts, base, work, times, ax, az, scale, held, loads, ports, at):
        samples = samples_of(times, ax, az, scale, held, loads, ports, at)
        return column_over(n, row_of(model), row_of(state), row_of(counts), row_of(base), samples, row_of(work))

    def assemble_column(n, model, state, counts, base, work, given, from_rest, scratch, detail):
        """`engine.assemble`. All but n and from_rest are arrays."""
        record = given, given, given, 1.0, False, given, given
        column = column_of(n, model, state, counts, base, work, *record, given)
        return assemble(column, row_of(given), from_rest, row_of(scratch), row_of(detail))

    # fmt: off
    def run(n, model, state, counts, base, work, times, ax, az, scale, held, loads, ports, t, h, at, snapshots, peaks):
        # fmt: on
        """Take the column from t to t + h over the record, with a snapshot at each of the times `at`. Returns a code.

        peaks: whether peaks are kept.
        """
        column = column_of(n, model, state, counts, base, work, times, ax, az, scale, held, loads, ports, at)
        return advance(column, t, h, Watch(at.size, row_of(at), row_of(snapshots), peaks))

    def observe_state(n, model, state, counts, base, work, times, ax, az, scale, held, loads, ports, t, row, split):
        """`observing.see` at time t under the base as it stands. Returns a code."""
        column = column_of(n, model, state, counts, base, work, times, ax, az, scale, held, loads, ports, row)
        enter(column.base, column.samples, t)
        parts = _split(row_of(split), 0)
        show_driven(column.base, column.model.settings, t, parts)
        return see(column, base_of(column, t), _row(row_of(row), n), parts)

    # fmt: off
    def observe_snapshots(n, model, state, counts, base, work, times, ax, az, scale, held, loads, ports, at, snapshots,
                          rows, count):
        # fmt: on
        """`observing.observe_all` of snapshots at the times `at`."""
        column = column_of(n, model, state, counts, base, work, times, ax, az, scale, held, loads, ports, at)
        return observe_all(column, row_of(snapshots), row_of(rows), count)

    return [entry(made, module) for made in (assemble_column, run, observe_state, observe_snapshots)]


assemble_column, run, observe_state, observe_snapshots = entries_of(__name__)


@entry
def arrive_base(n, model, base, inputs, t):
    """`coupled_base.arrive`."""
    arrive(_base(row_of(base), 0), _model(row_of(model), n).settings, _base_inputs(row_of(inputs), 0), t)


@entry
def couple_base(n, model, base, inputs, split):
    """`coupled_base.couple` by inputs without those of ports."""
    settings, given = _model(row_of(model), n).settings, _base_inputs(row_of(inputs), 0)
    return couple(_base(row_of(base), 0), settings, given, row_of(inputs), _INPUTS, _split(row_of(split), 0))


@entry
def examine_base(n, model, base, h):
    """`allowed_step.examine_step`."""
    examine_step(_model(row_of(model), n), _base(row_of(base), 0), h)


# --- joints, for Python code without a closed form of its own


@entry
def joint_potentials(n, model, openings, slopes, slips, found):
    """Elastic energy of every joint, J; openings in the middle of the contacts."""
    blocks = _model(row_of(model), n).blocks
    for i in range(n):
        found[i] = joint_potential(contact_of(blocks, i, slips[i]), law_of(blocks, i), openings[i], slopes[i])


@entry
def joint_energies(n, model, i, slip, slopes, weights, found):
    """`least_energy` of joint i, with the given slip, for every slope and weight."""
    blocks = _model(row_of(model), n).blocks
    contact, law = contact_of(blocks, i, slip), law_of(blocks, i)
    for k in range(slopes.size):
        found[k] = least_energy(contact, law, slopes[k], weights[k])


@entry
def lay_joint(own, depths, count, below, rim, model, found):
    """Lay out the contact of the only joint of a model (section.py, `lay_out`) from arrays that describe its faces.

    found: its area m2, and first and second moment about the middle of the block, m3 and m4.
    """
    blocks = _model(row_of(model), 1).blocks
    face, other = row_of(own), row_of(below)
    upper, lower = Face(face[0], face[1], face[2], face[3]), Face(other[0], other[1], other[2], other[3])
    lay_out(blocks, 0, upper, count, row_of(depths), lower, rim)
    found[0], found[1], found[2] = part_stiffness(contact_of(blocks, 0), 1.0, blocks.left[0], blocks.right[0])


@entry
def rings_beyond(outer, inner, edges, first, second):
    """First and second moment (m3, m4), about an edge, of the part of each annulus beyond it; edges: m from the centre.

    outer, inner: radii, m; inner is 0 for a circle. All are arrays, a number for each.
    """
    for k in range(edges.size):
        middle, area, about, square = ring_part(outer[k], inner[k], edges[k], outer[k])
        off = middle - edges[k]
        first[k] = about + off * area
        second[k] = square + off * (2.0 * about + off * area)
