"""Operations on a column, from its parameters to its outputs: the one engine behind every caller.

`Stepper`, both FMUs and programs without Python call these functions, through arrays (entries.py) or through pointers
(pointers.py). A column is the bundle of the spaces in layout/spaces.py.
"""

import math

from ..column.assembly import derive, settle_joints
from ..column.normal_modes import normal_modes
from ..column.normal_modes import scratch_size as modes_scratch
from ..column.rest import find_rest
from ..column.solids import homogeneous
from ..formulations.base_motion import base_motion, enter, moving
from ..formulations.coupled_base import couple, driven_along
from ..formulations.dispatch import Column
from ..formulations.exact import Motion
from ..formulations.feedthrough import (
    base_direction,
    effective_mass,
    split_reaction,
    tangential_gains,
)
from ..formulations.outputs import observe
from ..formulations.slips import begin_slips, phase_size, size_of_snapshot
from ..integrators.interpolation import slips_of
from ..joint.law import joint_forces, law_of
from ..joint.sliding import RIGID
from ..layout.spaces import (
    ACCELERATION,
    BASE,
    COUNTS,
    ELASTIC,
    HORIZONTAL,
    LAW,
    MODAL_MOST,
    MODEL,
    MOST_STRIPS,
    OK,
    OTHER_LAW,
    RECORD_BESIDE,
    ROW,
    SNAPSHOT,
    SPLIT,
    STATE,
    WORK,
    modal_size,
)
from ..numba_ext.jit import in_both, kernel, leaf, varied, varied_leaf
from ..numba_ext.numbers import sine_cosine
from ..numba_ext.views import Record, clear, copy
from ..sections.faces import ENDLESS, FITS, RECTANGLE, Face, face_of, misfit
from ..sections.section import contact_of, full_stiffness, is_off_centre, lay_out
from ..stepping.advance import advance, take_phase

# description of a column: settings, then a record for each block; 0 for an optional value that is not given
GIVEN_SETTINGS = Record("g", "step", "tolerance", "without", "drive", "slope", "bodies")
GIVEN_BLOCK = ("height", "width", "depth", "mass", "centroid", "inertia", "tilt")
GIVEN_JOINT = (*LAW, "width", "depth", "friction", "dowel", "offset", "inclination")
# properties that no parameter of an FMU changes: of the block the code of the section, inner diameter m, sizes of the
# top face m; of the joint the code of the section, inner diameter m, number of strips and their depths m
GIVEN_SHAPE = (
    *("section", "bore", "top_width", "top_depth"),
    *("joint_section", "joint_bore", "strips", *(f"strip_{k}" for k in range(MOST_STRIPS))),
)
GIVEN = Record(*GIVEN_BLOCK, *(f"joint_{name}" for name in GIVEN_JOINT), *GIVEN_SHAPE)
# inputs of the base, set by a caller: accelerations, their slopes, rotation; behind them those of each body that drives
# it (formulations/coupled_base.py, BODY)
BASE_INPUTS = Record("ax", "az", "jx", "jz", "theta", "omega", "alpha")

# codes of `assemble`, beside those of layout/spaces.py
TOO_LARGE = -10  # the moment of inertia of a block, whose number is left in the detail, is beyond float64
NO_REST = -11  # a column that is off its axis, or has joints of another law, does not stand under its own weight
NOT_LINEAR = -12  # a column that may slide or is off its axis has a joint of another law than the linear one
MISFIT = -13  # a contact face does not suit the faces that meet: the detail holds the joint and why (faces.py, Misfit)
DETAILS = 5  # numbers of the detail

CARRIED = 1e-9  # of the weight: how exactly a joint carries it at rest
PROBE_TURN = 1e-9  # rad, and
PROBE_SPIN = 1e-6  # rad/s, by which the rotation of the base is varied
RATE_PART = 1e-4  # of the first step: half the time over which outputs are differenced

_counts, _base = COUNTS.over, BASE.over
_DEPTHS_GIVEN = GIVEN.fields.index("strip_0")
_LAW_GIVEN, _LAW_FIELDS, _LINEAR_FIELDS = GIVEN.fields.index(f"joint_{LAW[0]}"), len(LAW), len(LAW) - len(OTHER_LAW)
_row, _split, _snapshot = ROW.over, SPLIT.over, SNAPSHOT.over
_given_settings, _given_block, _base_inputs = GIVEN_SETTINGS.over, GIVEN.over, BASE_INPUTS.over
_SETTINGS_FIELDS, _BLOCK_FIELDS = GIVEN_SETTINGS.beside, GIVEN.beside
_ROW_FIELDS, _ROW_BESIDE = ROW.per_n, ROW.beside
_MODEL_PER_N, _MODEL_BESIDE = MODEL.per_n, MODEL.beside
_COUNTS, _BASE, _SPLIT, _INPUTS = COUNTS.beside, BASE.beside, SPLIT.beside, BASE_INPUTS.beside


@in_both
def model_room(n: int) -> int:
    """Length of the largest packed model of n blocks."""
    return _MODEL_PER_N * n + _MODEL_BESIDE + (modal_size(n) if n <= MODAL_MOST else 0)


def scratch_room(n: int) -> int:
    """Length of the scratch of `assemble`."""
    return modes_scratch(n) if n <= MODAL_MOST else 1


def column_in(model_space, state_space, work_space):
    """A leaf: the column of n blocks over its rows, in these spaces."""
    _model, _state, _work = model_space.over, state_space.over, work_space.over

    @leaf
    def column_over(n, model, state, counts, base, samples, work):
        column = Column(_model(model, n), _state(state, n), _counts(counts, 0), _base(base, 0), samples, _work(work, n))
        begin_slips(column.model, column.work)
        return column

    return column_over


column_over = column_in(MODEL, STATE, WORK)


# --- from parameters to a model


@kernel
def assemble(column, given, from_rest, scratch, detail):
    """The packed model of the column that `given` describes; a column at rest with `from_rest`. Returns a code.

    Without `from_rest` the motion goes on from the present coordinates and rates. After an error the model may not be
    used, and the rest is unchanged; but NO_REST leaves no motion either. given, scratch, detail: rows.
    """
    model, state, counts, work = column.model, column.state, column.counts, column.work
    n, settings = model.n, model.settings
    code = describe(column, given, detail)
    if code != OK:
        return code
    if settings.slides != 0.0 and not _is_linear(given, n):
        return NOT_LINEAR
    begin_slips(model, work)
    rest = work.between
    stands = _rest_of(model, rest, work.room)
    if int(settings.without) & ELASTIC == 0 and n <= MODAL_MOST and stands:
        settings.has_modes = 1.0 if normal_modes(model, rest, scratch) else 0.0
    if from_rest != 0:
        reset(column)
        if not stands:
            return NO_REST
        copy(state.phase.row, rest.row, phase_size(work))
    elif counts.overturned == 0:
        state.control.base_ax = math.nan  # belongs to no input: the accelerations will be recomputed
    return OK


@kernel
def describe(column, given, detail):
    """Fill in a model but for its rest and modes, and clear `work`. Returns a code."""
    model = column.model
    settings, described = model.settings, _given_settings(given, 0)
    settings.n = model.n
    settings.gravity = described.g
    settings.step = described.step
    settings.tolerance = described.tolerance
    settings.without = described.without
    settings.drive, settings.slope, settings.bodies = described.drive, described.slope, described.bodies
    settings.has_modes = 0.0
    settings.slides = 0.0
    settings.off_axis = 0.0
    for i in range(model.n):
        code = _describe_block(model, given, i, detail)
        if code != OK:
            return code
    settings.slides = max(settings.slides, settings.off_axis)
    describe_more(model, given)
    derive(model)
    clear(column.work.row, column.work.total)  # responses of the modes of another model
    return OK


@varied
def describe_more(model, given):
    """Fill in what a model has beside from what stands behind the blocks in `given`: nothing."""
    return


@kernel
def _describe_block(model, given, i, detail):
    """Take block i and the joint under it from what is given, and the contact from the faces. Returns a code."""
    n, settings, blocks = model.n, model.settings, model.blocks
    row = given[_SETTINGS_FIELDS + _BLOCK_FIELDS * i :]
    block = _given_block(row, 0)
    blocks.height[i] = block.height
    blocks.mass[i] = block.mass
    wide, deep, over = block.width, block.depth, (block.top_width, block.top_depth, block.bore)
    centroid, inertia = homogeneous(block.mass, block.section, block.height, wide, deep, *over)
    blocks.centroid[i] = centroid if block.centroid == 0.0 else block.centroid
    blocks.inertia[i] = inertia if block.inertia == 0.0 else block.inertia
    for k in range(_LAW_FIELDS):
        blocks.law[k * n + i] = row[_LAW_GIVEN + k]
    below = Face(float(RECTANGLE), ENDLESS, ENDLESS, 0.0)
    if i + 1 < n:
        below = _top_face(given[_SETTINGS_FIELDS + _BLOCK_FIELDS * (i + 1) :])
    width = wide if block.joint_width == 0.0 else block.joint_width
    depth = deep if block.joint_depth == 0.0 else block.joint_depth
    bottom = face_of(block.section, wide, deep, block.bore)
    own, depths = face_of(block.joint_section, width, depth, block.joint_bore), row[_DEPTHS_GIVEN:]
    has_width, has_depth = block.joint_width != 0.0, block.joint_depth != 0.0
    fault = misfit(own, bottom, below, has_width, has_depth, int(block.strips), depths)
    if fault.kind != FITS:
        detail[0], detail[1], detail[2] = i + 1.0, fault.kind, fault.strip
        detail[3], detail[4] = fault.value, fault.bound
        return MISFIT
    lay_out(blocks, i, own, block.strips, depths, below)
    blocks.friction[i] = block.joint_friction
    blocks.dowel[i] = block.joint_dowel if block.joint_friction > 0.0 else RIGID
    settings.slides = 1.0 if block.joint_friction > 0.0 else settings.slides
    blocks.offset[i], blocks.lean[i] = block.joint_offset, block.joint_inclination
    blocks.tilt[i] = block.joint_inclination + block.tilt
    if block.joint_offset != 0.0 or blocks.lean[i] != 0.0 or blocks.tilt[i] != 0.0:
        settings.off_axis = 1.0
    if is_off_centre(block.strips, depths):
        settings.off_axis = 1.0
    if not math.isfinite(blocks.inertia[i]):
        detail[0] = i + 1.0
        return TOO_LARGE
    return OK


@leaf
def _is_linear(given, n):
    """Whether all joints have the linear law."""
    for i in range(n):
        row = given[_SETTINGS_FIELDS + _BLOCK_FIELDS * i :]
        for k in range(_LINEAR_FIELDS, _LAW_FIELDS):
            if row[_LAW_GIVEN + k] != 0.0:
                return False
    return True


@kernel
def _rest_of(model, rest, room):
    """Turn a phase of zeros into the rest of a column whose joints have not slid. Returns whether a stable one exists.

    A column on its axis, of any law, is checked for joints that carry the weight there.
    """
    blocks, settings = model.blocks, model.settings
    settle_joints(model, rest)
    begin_memory(model, rest)
    if settings.off_axis == 0.0:
        return carries(model)
    copy(rest.slip, blocks.offset, model.n)
    stands = not settings.gravity > 0.0 or find_rest(model, rest, room)
    for i in range(model.n):
        blocks.rest_turn[i] = rest.theta[i] if stands else math.inf  # nowhere
        blocks.rest_opening[i] = rest.opening[i]
    return stands


@varied
def begin_memory(model, rest):
    """Store in a phase what the joints of a column as built remember: nothing."""
    return


@kernel
def carries(model):
    """Whether all joints carry the weight on them once they settle as far as their stiffness lets them."""
    blocks, weight = model.blocks, 0.0
    for i in range(model.n):
        weight += model.settings.gravity * blocks.mass[i]
        opening = -weight / full_stiffness(blocks, i)
        normal, _, _ = joint_forces(contact_of(blocks, i), law_of(blocks, i), opening, 0.0, 0.0, 0.0)
        if not abs(normal - weight) <= CARRIED * weight:
            return False
    return True


@leaf
def _top_face(row):
    """The top face of the block that a row describes."""
    block = _given_block(row, 0)
    width = block.width if block.top_width == 0.0 else block.top_width
    return face_of(block.section, width, block.depth if block.top_depth == 0.0 else block.top_depth, block.bore)


@kernel
def reset(column):
    """State, counts and base of a column that has not moved yet; the state is all zeros."""
    base = column.base
    clear(column.state.row, column.state.total)
    clear(column.counts.row, _COUNTS)
    clear(base.row, _BASE)
    base.anchor = -math.inf  # nowhere
    base.segment = -1.0
    base.piece_end = math.inf


# --- the base


@kernel
def drive(base, inputs, elapsed, t):
    """Set the inputs that the base follows from time t on; they were set `elapsed` s before."""
    given = _base_inputs(inputs, 0)
    base.ax = given.ax + given.jx * elapsed
    base.jx = given.jx
    base.az = given.az + given.jz * elapsed
    base.jz = given.jz
    base.theta = given.theta + elapsed * (given.omega + 0.5 * elapsed * given.alpha)
    base.omega = given.omega + elapsed * given.alpha
    base.alpha = given.alpha
    base.jalpha = 0.0
    base.t0 = t


@varied_leaf
def beside_inputs(samples):
    """How many inputs stand between those of the base and those of bodies: those of ports."""
    return 0


@varied_leaf
def load(base, samples, inputs, elapsed, t):
    """Set the inputs of the ports, which were set `elapsed` s before time t: there are none.

    They follow straight lines from the time `base.t0` on.
    """
    return


@kernel
def exchange(column, inputs, elapsed, t, row, split):
    """Let the base go on from time t as bodies drive it, by inputs of that instant. Returns a code.

    elapsed: s, since loads on ports were set. row, split: filled with the outputs at t as the base has moved so far.
    """
    if column.samples.size > 0:
        return RECORD_BESIDE
    load(column.base, column.samples, inputs, elapsed, t)
    code = see(column, base_of(column, t), row, split)
    first = _INPUTS + beside_inputs(column.samples)
    return join(column.base, column.model.settings, inputs, first, t, split) if code == OK else code


@kernel
def join(base, settings, inputs, first, t, split):
    """`exchange` where the split of the column at t is known; first: place of the bodies' inputs. Returns a code."""
    return couple(base, settings, _base_inputs(inputs, 0), inputs, first, t, split)


@varied_leaf
def motion_held(samples, control):
    """The motion of the base that the state belongs to; no load acts on what has fallen."""
    return Motion(control.base_ax, control.base_az, control.base_theta, control.base_omega, control.base_alpha)


@varied_leaf
def motion_of_snapshot(column, snapshot, k):
    """The motion of the base that snapshot k belongs to, which does not rotate."""
    return Motion(snapshot.base.ax, snapshot.base.az, 0.0, 0.0, 0.0)


@varied_leaf
def beside_row(column):
    """How many numbers stand behind an output row: none."""
    return 0


@kernel
def base_of(column, t):
    """Motion of the base at time t; once the column has overturned, its motion at that moment."""
    control = column.state.control
    if column.counts.overturned > 0:
        return motion_held(column.samples, control)
    return base_motion(column.base, column.samples, t)


# --- motion and what is seen of it


@kernel
def follow(column, inputs, start, h, watch, row, split):
    """Take the column from `start` to start + h, s, under inputs that begin there, and the record. Returns a code.

    row, split: room.
    """
    if column.model.settings.drive == ACCELERATION:
        drive(column.base, inputs, 0.0, start)
    else:
        code = exchange(column, inputs, 0.0, start, row, split)
        if code != OK:
            return code
    load(column.base, column.samples, inputs, 0.0, start)
    return advance(column, start, h, watch)


@kernel
def see(column, motion, row, split):
    """Fill an output row and the split reaction with the outputs of the state on such a base. Returns a code.

    The phase is left in work.between.
    """
    between = column.work.between
    take_phase(column, motion, between)
    code = observe(column, between, motion, row)
    return split_reaction(column, between, motion, row, split) if code == OK else code


@kernel
def observe_all(column, snapshots, rows, count):
    """Fill every row with the outputs of the snapshot of that number. Returns (code, number of the last)."""
    n, between, size, length = column.model.n, column.work.between, size_of_snapshot(column.work), _length(column)
    for k in range(count):
        snapshot = _snapshot(snapshots[size * k :], n)
        copy(between.row, snapshot.phase.row, phase_size(column.work))
        motion = motion_of_snapshot(column, snapshot, k)
        code = observe(column, between, motion, _row(rows[k * length :], n))
        if code != OK:
            return code, k
    return OK, count


@kernel
def look(column, inputs, new_inputs, upright, elapsed, t, row, split):
    """Fill an output row and the split reaction with the outputs at time t. Returns a code.

    With `new_inputs` the inputs are those set `elapsed` s before; else those that the last step has left. With
    `upright` the column stands on the base as it is turned and turning, instead of upright in space.
    """
    base, control = column.base, column.state.control
    if new_inputs != 0:
        if column.model.settings.drive == ACCELERATION:
            drive(base, inputs, elapsed, t)
        else:  # before there is a mass at the base it does not move
            exchange(column, inputs, elapsed, t, row, split)
        load(base, column.samples, inputs, elapsed, t)
    enter(base, column.samples, t)
    if upright != 0:
        control.base_theta = base.theta
        control.base_omega = base.omega
    return see(column, base_of(column, t), row, split)


@leaf
def _length(column):
    """Numbers of an output row, those of ports among them."""
    return _ROW_FIELDS * column.model.n + _ROW_BESIDE + beside_row(column)


@leaf
def _clear_output(row, split, length):
    clear(row.row, length)
    clear(split.row, _SPLIT)


@kernel
def _add(row, split, other, other_split, factor, length):
    for i in range(length):
        row.row[i] += factor * other.row[i]
    for i in range(_SPLIT):
        split.row[i] += factor * other_split.row[i]


@kernel
def rates(column, t, row, split, other, other_split):
    """Fill row and split with the rate of every output at time t, 1/s; `look` has been called then. Returns a code.

    Central differences over a fraction of the period of the fastest mode, for which the first step is made too, on the
    parabola given by coordinates, rates and accelerations. other, other_split: room for another row and split.
    """
    model, work = column.model, column.work
    n, length = model.n, _length(column)
    _clear_output(row, split, length)
    if column.counts.overturned > 0:
        return OK
    see(column, base_motion(column.base, column.samples, t), other, other_split)
    between, saved = work.between, work.end
    copy(saved.row, between.row, phase_size(work))
    past = RATE_PART * model.settings.first_step
    for _ in range(2):
        for i in range(2 * n):
            _go_on(saved, between, i, past)
        first, behind = slips_of(work)
        for i in range(behind - first):
            _go_on(saved, between, first + i, past)
            between.sliding[i] = saved.sliding[i]
        then = base_motion(column.base, column.samples, t + past)
        observe(column, work.between, then, other)
        split_reaction(column, work.between, then, other, other_split)
        _add(row, split, other, other_split, 0.5 / past, length)
        past = -past
    return OK


@leaf
def _go_on(saved, to, i, past):
    """Coordinate i of a phase `past` s later, its rate and acceleration."""
    q, v, a = saved.coordinates[i], saved.rates[i], saved.accelerations[i]
    to.coordinates[i] = q + past * (v + 0.5 * past * a)
    to.rates[i] = v + past * a
    to.accelerations[i] = a


@kernel
def feedthrough(column, inputs, seeds, elapsed, t, row, split, other, other_split):
    """Fill row and split with the derivative of every output by the inputs, in the direction `seeds`.

    seeds: one for each of the inputs, which were set `elapsed` s before; at time t under the inputs that `look` has
    left. Outputs that depend on accelerations of the base and loads at once are linear in them (`at_once`). Dependence
    on the rotation of the base and its rate is differenced. Returns a code.
    """
    base, samples, settings, length = column.base, column.samples, column.model.settings, _length(column)
    _clear_output(row, split, length)
    if column.counts.overturned > 0:
        return OK
    seed = _base_inputs(seeds, 0)
    along_x = seed.ax + elapsed * seed.jx
    along_z = seed.az + elapsed * seed.jz
    alpha = seed.alpha
    spin = seed.omega + elapsed * alpha
    turn = seed.theta + elapsed * (seed.omega + 0.5 * elapsed * alpha)
    motion = base_motion(base, samples, t)
    see(column, motion, other, other_split)
    met_by_loads(column, motion, seeds, elapsed, row, split, other_split)
    if settings.drive != ACCELERATION:
        first = _INPUTS + beside_inputs(samples)
        along_x, along_z, alpha = driven_along(
            settings, inputs, seeds, first, other_split, split, motion, along_z, alpha
        )
        if settings.drive != HORIZONTAL:
            turn = spin = 0.0  # they belong to the state
    at_once(column, motion, seeds, elapsed, along_x, along_z, alpha, row, other, other_split)
    way = 1.0
    for _ in range(2):
        if turn != 0.0:
            theta = motion.theta + way * PROBE_TURN
            then = moving(base, samples, t, motion.ax, motion.az, theta, motion.omega, motion.alpha)
            see(column, then, other, other_split)
            _add(row, split, other, other_split, 0.5 * turn / (way * PROBE_TURN), length)
        if spin != 0.0:
            omega = motion.omega + way * PROBE_SPIN
            then = moving(base, samples, t, motion.ax, motion.az, motion.theta, omega, motion.alpha)
            see(column, then, other, other_split)
            _add(row, split, other, other_split, 0.5 * spin / (way * PROBE_SPIN), length)
        way = -1.0
    return OK


@varied
def met_by_loads(column, motion, seeds, elapsed, row, split, other_split):
    """Fill split with what R0 changes by as loads do by their seeds; other_split: as they are. There are no loads.

    row: room.
    """
    return


@varied
def at_once(column, motion, seeds, elapsed, along_x, along_z, alpha, row, other, other_split):
    """Fill an output row with what changes at once as the base accelerates by so much more, m/s2 and rad/s2.

    Forces along the joints and reaction (formulations/feedthrough.py). The column was just seen on this motion, as
    `other` says; other_split: room.
    """
    model, work = column.model, column.work
    n, phase = model.n, work.between
    g_x, g_z, g_m = base_direction(model, phase, motion.theta)
    met = g_x * along_x + g_z * along_z + g_m * alpha
    force = effective_mass(model, work) * met
    gains = work.tops.start_ux
    tangential_gains(model, work, gains)
    turn_below = 0.0
    for i in range(n - 1, -1, -1):
        _, cosine = sine_cosine(0.5 * (phase.theta[i] + turn_below) + motion.theta + model.blocks.lean[i])
        row.joints.T[i] = -gains[i] * met
        row.joints.S[i] = -cosine * gains[i] * met
        turn_below = phase.theta[i]
    row.base.Fx = -g_x * force
    row.base.Fz = -g_z * force
    row.base.My = -g_m * force
