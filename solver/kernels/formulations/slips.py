"""Which joints slide, and which way: decided where forces may jump, kept within a step (theory.md section 9).

What decides serves one column and lanes of eight.
"""

from ..jit import kernel, leaf
from ..joint.sliding import can_slide
from ..lanes import magnitude, where
from ..layout import OK, PHASE_FIELDS, RIGID_FIELDS, SNAPSHOT
from .either import evaluate

_SNAPSHOT_BESIDE = SNAPSHOT.beside


@leaf
def phase_size(work):
    """How many numbers of a phase there are to be copied."""
    return (PHASE_FIELDS if work.slips.count != 0.0 else RIGID_FIELDS) * work.n


@leaf
def size_of_snapshot(work):
    """How many numbers a snapshot has: it holds as much of a phase as there is."""
    return _SNAPSHOT_BESIDE + phase_size(work)


@leaf
def keep_slips(work, phase):
    """Let the slips of a phase, if there are any, be those of the start of the step."""
    for i in range(phase_size(work) - RIGID_FIELDS * work.n):
        phase.slips[i] = work.start.slips[i]


@leaf
def begin_slips(model, work):
    """Note whether the phases in `work` have slips."""
    work.slips.count = model.n if can_slide(model) else 0.0


@kernel
def take_directions(work, phase):
    """Let the joints slide as a phase says."""
    for i in range(int(work.slips.count)):
        work.joints.sliding[i] = phase.sliding[i]


@kernel
def note_directions(work, phase):
    """Let a phase say how the joints slide."""
    for i in range(int(work.slips.count)):
        phase.sliding[i] = work.joints.sliding[i]


@leaf
def something_slides(work):
    """Whether any joint slides."""
    slides = False
    for i in range(int(work.slips.count)):
        slides = slides or work.joints.sliding[i] != 0.0
    return slides


@leaf
def spare(joints, i):
    """What joint i bears beyond what it has to, N; negative where it slides."""
    return joints.bearable[i] - magnitude(joints.tangential[i] - joints.drift[i])


@kernel
def evaluate_anew(column, phase, motion):
    """`evaluate` where forces may have jumped: every joint that does not move sticks or slides as its forces want.

    The joints that move are those of the phase; it is changed where one of them has come to rest. Returns a code.
    """
    if not can_slide(column.model):
        return evaluate(column, phase, motion)
    work = column.work
    stop_what_is_still(work.joints, phase, work.n)
    code = evaluate(column, phase, motion)
    for _ in range(2 * work.n + 2):
        if code != OK or not change_directions(work.joints, phase, work.n):
            break
        code = evaluate(column, phase, motion)
    note_directions(work, phase)
    return code


@leaf
def stop_what_is_still(joints, phase, n):
    """Let the joints slide as a phase says, but for those that do not move that way any more: they stop."""
    for i in range(n):
        moves = phase.sliding[i] * phase.slip_rate[i] > 0.0
        joints.sliding[i] = where(moves, phase.sliding[i], 0.0)
        phase.slip_rate[i] = where(moves, phase.slip_rate[i], 0.0)


@leaf
def change_directions(joints, phase, n):
    """Let joints go that bear too little, and stop those that would slide backwards; whether there were any."""
    changed = joints.sliding[0] != joints.sliding[0]  # nowhere
    for i in range(n):
        way = joints.sliding[i]
        sticks = way == 0.0
        goes = sticks & (spare(joints, i) < 0.0)
        stops = (way != 0.0) & (phase.slip_rate[i] == 0.0) & (way * phase.slip_acceleration[i] < 0.0)
        to = where(joints.tangential[i] > joints.drift[i], -1.0, 1.0)
        joints.sliding[i] = where(goes, to, where(stops, 0.0, way))
        changed = changed | goes | stops
    return changed
