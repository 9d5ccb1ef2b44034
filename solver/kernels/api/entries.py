"""Entries called from Python: the engine over arrays."""

from ..formulations.base_motion import Samples, enter
from ..joint.energy import least_energy
from ..joint.law import joint_potential, law_of
from ..layout.spaces import BASE, MODEL, ROW, SPLIT
from ..numba_ext.jit import entry
from ..numba_ext.views import row_of
from ..output.watch import Watch
from ..sections.circle import ring_part
from ..sections.faces import Face
from ..sections.section import contact_of, lay_out, part_stiffness
from ..stepping.advance import advance
from .engine import BASE_INPUTS, assemble, base_of, column_over, join, observe_all, see

_model = MODEL.over
_row, _split, _base, _INPUTS = ROW.over, SPLIT.over, BASE.over, BASE_INPUTS.beside

# a column is (n, model, state, counts, base, work); a record (times, ax, az, scale, held)


@entry
def assemble_column(n, model, state, counts, base, work, given, from_rest, scratch, detail):
    """`engine.assemble`. All but n and from_rest are arrays."""
    samples = Samples(0, row_of(given), row_of(given), row_of(given), 1.0, False)
    column = column_over(n, row_of(model), row_of(state), row_of(counts), row_of(base), samples, row_of(work))
    return assemble(column, row_of(given), from_rest, row_of(scratch), row_of(detail))


@entry
def run(n, model, state, counts, base, work, times, ax, az, scale, held, t, h, at, snapshots, peaks):
    """Take the column from t to t + h over the record, with a snapshot at each of the times `at`. Returns a code.

    peaks: whether peaks are kept.
    """
    samples = Samples(times.size, row_of(times), row_of(ax), row_of(az), scale, held)
    column = column_over(n, row_of(model), row_of(state), row_of(counts), row_of(base), samples, row_of(work))
    return advance(column, t, h, Watch(at.size, row_of(at), row_of(snapshots), peaks))


@entry
def observe_state(n, model, state, counts, base, work, times, ax, az, scale, held, t, row, split):
    """`engine.see` at time t under the base as it stands. Returns a code."""
    samples = Samples(times.size, row_of(times), row_of(ax), row_of(az), scale, held)
    column = column_over(n, row_of(model), row_of(state), row_of(counts), row_of(base), samples, row_of(work))
    enter(column.base, samples, t)
    return see(column, base_of(column, t), _row(row_of(row), n), _split(row_of(split), 0))


@entry
def join_base(n, model, base, inputs, t, split):
    """`engine.join` by inputs without those of ports."""
    settings = _model(row_of(model), n).settings
    return join(_base(row_of(base), 0), settings, row_of(inputs), _INPUTS, t, _split(row_of(split), 0))


@entry
def observe_snapshots(n, model, state, counts, base, work, snapshots, rows, count):
    """`engine.observe_all`."""
    samples = Samples(0, row_of(base), row_of(base), row_of(base), 1.0, False)
    column = column_over(n, row_of(model), row_of(state), row_of(counts), row_of(base), samples, row_of(work))
    return observe_all(column, row_of(snapshots), row_of(rows), count)


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
def lay_joint(own, depths, count, below, model, found):
    """Lay out the contact of the only joint of a model (section.py, `lay_out`) from arrays that describe its faces.

    found: its area m2, and first and second moment about the middle of the block, m3 and m4.
    """
    blocks = _model(row_of(model), 1).blocks
    face, other = row_of(own), row_of(below)
    upper, lower = Face(face[0], face[1], face[2], face[3]), Face(other[0], other[1], other[2], other[3])
    lay_out(blocks, 0, upper, count, row_of(depths), lower)
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
