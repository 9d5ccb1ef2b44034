"""The sliding joints and their directions: decided where forces may jump, kept within a step (theory.md section 9).

The functions that decide serve one column and lanes of eight.
"""

from ...layout.spaces import OK, PHASE, PHASE_FIELDS, RIGID_FIELDS, SNAPSHOT
from ...numba_ext.jit import kernel, leaf, varied
from ...numba_ext.lanes import magnitude, where
from ...numba_ext.views import copy
from ..joint.resultants import is_bonded
from ..joint.sliding import can_slide
from .bonds import drop_bonds, keep_lost, take_bonds
from .dispatch import evaluate

_SNAPSHOT_BESIDE, _PHASE_PER_N = SNAPSHOT.beside, PHASE.per_n


@leaf
def phase_size(work):
    """Return the number of values of a phase to copy: with slips and bonds, where there are any."""
    fields = PHASE_FIELDS if work.slips.count != 0.0 else RIGID_FIELDS
    return (_PHASE_PER_N if work.slips.bonds != 0.0 else fields) * work.n


@leaf
def size_of_snapshot(work):
    """Return the number of values of a snapshot: those of a phase and the scalars of SNAPSHOT."""
    return _SNAPSHOT_BESIDE + phase_size(work)


@leaf
def keep_slips(work, phase):
    """Copy the slips and bonds of the start of the step, if there are any, to a phase."""
    copy(phase.slips, work.start.slips, phase_size(work) - RIGID_FIELDS * work.n)


@leaf
def begin_slips(model, work):
    """Note whether the phases in `work` have slips and bonds."""
    work.slips.count = model.n if can_slide(model) else 0.0
    work.slips.bonds = model.n if is_bonded(model) else 0.0


@kernel
def take_directions(work, phase):
    """Let the joints slide in the directions that a phase holds."""
    copy(work.joints.sliding, phase.sliding, int(work.slips.count))


@kernel
def note_directions(work, phase):
    """Store in a phase the directions in which the joints slide."""
    copy(phase.sliding, work.joints.sliding, int(work.slips.count))


@leaf
def something_slides(work):
    """Return True if any joint slides."""
    slides = False
    for i in range(int(work.slips.count)):
        slides = slides or work.joints.sliding[i] != 0.0
    return slides


@leaf
def shear_margin(joints, i):
    """Return the shear capacity of joint i less the force along it (N); negative where it slides."""
    return joints.shear_capacity[i] - magnitude(joints.tangential[i] - joints.pressure_shear[i])


@varied
def evaluate_after_jump(column, phase, motion):
    """Evaluate a phase where forces may have jumped: joints at rest stick or slide as their forces require.

    The moving joints are those of the phase, which is changed where one of them has come to rest. Joints that slide
    lose their bonds. Returns a code.
    """
    work = column.work
    take_bonds(work, phase)
    if not can_slide(column.model):
        return evaluate(column, phase, motion)
    stop_what_is_still(work.joints, phase, work.n)
    drop_bonds(work)
    evaluate(column, phase, motion)
    # each change of direction changes the forces: iterate
    for _ in range(2 * work.n + 2):
        if not change_directions(work.joints, phase, work.n):
            break
        drop_bonds(work)
        evaluate(column, phase, motion)
    note_directions(work, phase)
    keep_lost(column.model, work, phase)
    return OK


@leaf
def stop_what_is_still(joints, phase, n):
    """Let the joints slide in the directions of a phase, and stop those that no longer move that way."""
    for i in range(n):
        moves = phase.sliding[i] * phase.slip_rate[i] > 0.0
        joints.sliding[i] = where(moves, phase.sliding[i], 0.0)
        phase.slip_rate[i] = where(moves, phase.slip_rate[i], 0.0)


@leaf
def change_directions(joints, phase, n):
    """Let joints slide whose capacity is exceeded, stop those that would slide backwards; return True if any change."""
    changed = joints.sliding[0] != joints.sliding[0]  # false in every lane
    for i in range(n):
        way = joints.sliding[i]
        sticks = way == 0.0
        # joints that begin to slide, against the force along them, and those that stop
        goes = sticks & (shear_margin(joints, i) < 0.0)
        stops = (way != 0.0) & (phase.slip_rate[i] == 0.0) & (way * phase.slip_acceleration[i] < 0.0)
        to = where(joints.tangential[i] > joints.pressure_shear[i], -1.0, 1.0)
        joints.sliding[i] = where(goes, to, where(stops, 0.0, way))
        changed = changed | goes | stops
    return changed
