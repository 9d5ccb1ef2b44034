"""Which joints slide, and which way: decided where forces may jump, kept within a step (theory.md section 9)."""

from ..jit import kernel, leaf
from ..joint.sliding import can_slide
from ..layout import OK, PHASE_FIELDS, RIGID_FIELDS
from .either import evaluate


@leaf
def phase_size(work):
    """How many numbers of a phase there are to be copied."""
    return (PHASE_FIELDS if work.slips.count != 0.0 else RIGID_FIELDS) * work.n


@leaf
def begin_slips(model, work):
    """Note whether the phases in `work` have slips."""
    work.slips.count = model.n if can_slide(model) else 0.0


@kernel
def take_directions(work, phase):
    """Let the joints slide as a phase says."""
    for i in range(int(work.slips.count)):
        work.hold.sliding[i] = int(phase.sliding[i])


@kernel
def note_directions(work, phase):
    """Let a phase say how the joints slide."""
    for i in range(int(work.slips.count)):
        phase.sliding[i] = work.hold.sliding[i]


@leaf
def spare(joints, i):
    """What joint i bears beyond what it has to, N; negative where it slides."""
    return joints.bearable[i] - abs(joints.tangential[i] - joints.drift[i])


@kernel
def evaluate_anew(column, phase, motion):
    """`evaluate` where forces may have jumped: every joint that does not move sticks or slides as its forces want.

    The joints that move are those of the phase; it is changed where one of them has come to rest. Returns a code.
    """
    if not can_slide(column.model):
        return evaluate(column, phase, motion)
    work = column.work
    rows, n = work.hold, work.n
    for i in range(n):
        direction = int(phase.sliding[i])
        if direction * phase.slip_rate[i] <= 0.0:
            direction = 0
            phase.slip_rate[i] = 0.0
        rows.sliding[i] = direction
    code = evaluate(column, phase, motion)
    for _ in range(2 * n + 2):
        if code != OK or not _change_directions(column, phase):
            break
        code = evaluate(column, phase, motion)
    note_directions(work, phase)
    return code


@kernel
def _change_directions(column, phase):
    """Let joints go that bear too little, and stop those that would slide backwards; whether there were any."""
    rows, joints = column.work.hold, column.work.joints
    changed = False
    for i in range(column.model.n):
        direction = rows.sliding[i]
        if direction == 0:
            if spare(joints, i) < 0.0:
                rows.sliding[i] = -1 if joints.tangential[i] > joints.drift[i] else 1
                changed = True
        elif phase.slip_rate[i] == 0.0 and direction * phase.slip_acceleration[i] < 0.0:
            rows.sliding[i] = 0
            changed = True
    return changed
