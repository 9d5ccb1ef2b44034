"""The entries that Python calls: the engine over arrays."""

from .engine import assemble, base_of, column_over, see
from .formulations.base import Samples, enter
from .formulations.exact import Motion
from .formulations.outputs import observe
from .formulations.slips import phase_size, size_of_snapshot
from .jit import entry
from .joint.circle import ring_part
from .joint.energy import least_energy
from .joint.law import joint_potential, law_of
from .joint.section import contact_of
from .layout import MODEL, OK, ROW, SNAPSHOT, SPLIT
from .stepping.advance import advance
from .stepping.watch import Watch
from .views import row_of

_model = MODEL.over
_row, _split, _snapshot = ROW.over, SPLIT.over, SNAPSHOT.over
_ROW_FIELDS, _ROW_BESIDE = ROW.per_n, ROW.beside

# a column is (n, model, state, counts, base, work); a record (times, ax, az, scale, held)


@entry
def assemble_column(n, model, state, counts, base, work, given, afresh, scratch, detail):
    """`engine.assemble`. All but n and afresh are arrays."""
    samples = Samples(0, row_of(given), row_of(given), row_of(given), 1.0, False)
    column = column_over(n, row_of(model), row_of(state), row_of(counts), row_of(base), samples, row_of(work))
    return assemble(column, row_of(given), afresh, row_of(scratch), row_of(detail))


@entry
def run(n, model, state, counts, base, work, times, ax, az, scale, held, t, h, at, snapshots, peaks):
    """Take the column from t to t + h over the record; a snapshot for each of the times `at`. Returns a code.

    peaks: whether they are kept.
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
def observe_snapshots(n, model, state, counts, base, work, snapshots, rows, count):
    """Fill every row with what is visible of the snapshot of the same number. Returns (code, number of the last)."""
    samples = Samples(0, row_of(base), row_of(base), row_of(base), 1.0, False)
    column = column_over(n, row_of(model), row_of(state), row_of(counts), row_of(base), samples, row_of(work))
    between = column.work.between
    kept, filled, size = row_of(snapshots), row_of(rows), size_of_snapshot(column.work)
    for k in range(count):
        snapshot = _snapshot(kept[size * k :], n)
        for i in range(phase_size(column.work)):
            between.row[i] = snapshot.phase.row[i]
        motion = Motion(snapshot.base.ax, snapshot.base.az, 0.0, 0.0, 0.0)
        code = observe(column, between, motion, _row(filled[k * (_ROW_FIELDS * n + _ROW_BESIDE) :], n))
        if code != OK:
            return code, k
    return OK, count


# --- joints, where Python has no closed form of its own


@entry
def joint_potentials(n, model, openings, slopes, slips, found):
    """Elastic energy of every joint, J; openings in the middle of the contacts."""
    blocks = _model(row_of(model), n).blocks
    for i in range(n):
        found[i] = joint_potential(contact_of(blocks, i, slips[i]), law_of(blocks, i), openings[i], slopes[i])


@entry
def joint_energies(n, model, i, slip, slopes, weights, found):
    """`least_energy` of joint i, slipped by so much, for every slope and weight."""
    blocks = _model(row_of(model), n).blocks
    contact, law = contact_of(blocks, i, slip), law_of(blocks, i)
    for k in range(slopes.size):
        found[k] = least_energy(contact, law, slopes[k], weights[k])


@entry
def rings_beyond(outer, inner, edges, first, second):
    """Of what of each annulus lies beyond an edge, m from its centre: first and second moment about that, m3 and m4.

    outer, inner: radii, m; no inner one: 0. All are arrays, a number for each.
    """
    for k in range(edges.size):
        middle, area, about, square = ring_part(outer[k], inner[k], edges[k], outer[k])
        off = middle - edges[k]
        first[k] = about + off * area
        second[k] = square + off * (2.0 * about + off * area)
