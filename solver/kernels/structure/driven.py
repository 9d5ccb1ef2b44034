"""A structure under inputs that the caller sets at each call: the engine behind its FMUs.

Its whole state is in the flat rows of layout.py. The joints are elastic in shear, so that all outputs follow from the
state, without dependence on the acceleration of the same instant; only accelerations of ports have feedthrough. Before
the first step all outputs follow the rotation of the base.
"""

import math

from ..engine.control import most_of_a_call, most_work
from ..engine.differences import point, points
from ..engine.samples import no_samples, segment_from
from ..layout.spaces import (
    ACCELERATION,
    CALL_TOO_LONG,
    INPUT_TOO_LARGE,
    MOST_INPUT,
    RECORD_BESIDE,
    TOO_MUCH_WORK,
)
from ..numba_ext.jit import kernel, leaf
from ..numba_ext.views import Record, clear, copy
from .coupled import INPUTS, arrive, examine_step, exchange, show_driven, start_at, turn, turned_by
from .evaluate import evaluate, evaluate_state, moving, recall, show
from .extras import let_go, taken_at
from .layout import (
    COUNTS,
    DRIVEN,
    DRIVEN_TURN,
    HEAD,
    INPUT_MOTION,
    LOAD,
    MODEL,
    OF_BASE,
    OK,
    PAUSED,
    PHASE,
    STAGES,
    STATE,
    order_of,
    scene_of,
    shear_damping_of,
    sizes_in,
    stabilizes,
    step_tolerance,
)
from .modal import prepare
from .stepping import advance, end_after_fall, fastest_decay
from .turning import MOST_TURN, is_turned_across, rotation_at, stop_turning, turn_base
from .watch import RATES, STAGE, START, SpatialWatch, clear_peaks, raise_peaks, row, seen

# description of a structure: choices of the caller, then the model, then its state at rest
GIVEN = Record("tolerance", "without", "damping_scale", "drive", "slope", "bodies", "turns")
WITHOUT_PEAKS, WITHOUT_ELASTIC, WITHOUT_STABILIZED = 1, 2, 4  # codes of `without` (models/structure/model.py, SKIPS)
HEAVIER = 4.0  # cost of the evaluation of a block or joint, over that of a block of a column
RATE_PART = 1e-4  # interval of the difference quotients of outputs, over the first step

_inputs, _head, _given, _input, _phase = INPUTS.over, HEAD.over, GIVEN.over, INPUT_MOTION.over, PHASE.over
_model, _state = MODEL.over, STATE.over
_INPUTS = INPUTS.beside
_GIVEN, _COUNTS, _REACTION, _LOAD = GIVEN.beside, COUNTS.beside, len(OF_BASE), len(LOAD)
_DRIVEN, _DRIVEN_TURN = DRIVEN.beside, DRIVEN_TURN.beside


@kernel
def assemble(model, state, counts, base, work, given, from_rest):
    """Fill `model` from its description and prepare the modes; initialize `state` and `base` if asked. Return OK.

    Parameters
    ----------
    model, state, counts, base, work : row
        The arrays of a structure (layout.py).
    given : row
        GIVEN, then MODEL, then a state at rest.
    from_rest : int
        1: set the state at rest and clear counts and base.
    """
    described, packed = _given(given, 0), given[_GIVEN:]
    sizes = sizes_in(packed)
    made = _model(model, sizes)
    copy(model, packed, made.total)
    settings, joints = made.settings, made.joints
    # settings
    settings.watches = 0.0 if int(described.without) & WITHOUT_PEAKS else 1.0
    if int(described.without) & WITHOUT_ELASTIC:
        settings.has_modes = 0.0
    settings.drive, settings.slope, settings.bodies = described.drive, described.slope, described.bodies
    settings.turns = described.turns
    # damping, scaled; a joint that may slide then has the least damping in shear
    damping = 0.0
    for j in range(sizes.m):
        joints.damping[j] *= described.damping_scale
        along = described.damping_scale * joints.shear_damping[j]
        joints.shear_damping[j] = shear_damping_of(along, joints.friction[j], settings.relaxation)
        joints.dashpot[j] *= described.damping_scale
        joints.ring_damping[j] *= described.damping_scale
        # of the most damped joint; across a bearing alone
        is_bearing = j >= sizes.m - sizes.b
        damping = max(damping, joints.damping[j] if is_bearing else min(joints.damping[j], along))
    # method, by this damping unless it is the file's, and tolerances
    if described.damping_scale != 1.0:
        settings.order = order_of(damping, settings.first_step)
    settings.tolerance = described.tolerance
    settings.step_tolerance = step_tolerance(settings.order, settings.tolerance)
    settings.stabilizes = stabilizes(settings.order, settings.tolerance)
    if int(described.without) & WITHOUT_STABILIZED:
        settings.stabilizes = 0.0
    for e in range(sizes.k):
        made.ties.damping[e] *= described.damping_scale
    for p in range(sizes.pairs):
        made.pairs.damping[p] *= described.damping_scale
        made.pairs.decay[p] /= described.damping_scale
    scene = scene_of(model, state, counts, base, no_samples(given), work)
    # initial state
    if from_rest != 0:
        lasting = _state(state, sizes)
        clear(state, lasting.total)
        copy(lasting.phase.buffer, packed[made.total :], sizes.state)
        clear(counts, _COUNTS)
        clear(base, _input(base, sizes).total)
    # modes, and the fastest decay, of the structure at rest
    let_go(scene)
    prepare(scene)
    copy(row(scene, START), packed[made.total :], moving(scene))
    scene.control.decay = fastest_decay(scene)
    return OK


@leaf
def _load(scene, inputs, elapsed, t):
    """Set the inputs at the ports, which the caller set `elapsed` s before time t, and their slopes."""
    count, given = _LOAD * scene.extras.spotted, inputs[_INPUTS:]
    # extrapolate to the time t0 of the inputs
    past = elapsed - (t - scene.base.t0)
    for i in range(count):
        slope = given[count + i]
        scene.extras.inputs[i], scene.extras.inputs[count + i] = given[i] + slope * past, slope


@kernel
def _drive(scene, inputs, elapsed, t):
    """Set the inputs that the base follows from time t on, which the caller set `elapsed` s before."""
    base, given = scene.base, _inputs(inputs, 0)
    # rotation
    start_at(base, t)
    if scene.settings.turns != 0.0:
        turned = turned_by(scene, inputs)
        base.alpha_x, base.alpha_y = turned.alpha_x, turned.alpha_y
    # translation
    base.ax = given.ax + given.jx * elapsed
    base.ay = given.ay + given.jy * elapsed
    base.az = given.az + given.jz * elapsed
    base.jx, base.jy, base.jz = given.jx, given.jy, given.jz


@kernel
def _see(scene, phase, t, visible):
    """Fill the output row `visible` from the state at time t, on a base without acceleration."""
    recall(scene, phase.buffer)
    # without acceleration of the base
    turn_base(scene, scene.base, t, 0.0, 0.0, 0.0)
    evaluate(scene, phase, _phase(row(scene, RATES), scene.n), 0.0, 0.0, 0.0)
    show(scene, phase, visible, True)
    stop_turning(scene)


@kernel
def _see_pushed(scene, phase, t, visible):
    """Fill the output row `visible` from the state, the base acceleration and the loads at time t.

    Accelerations of ports depend on all three.
    """
    pushed = taken_at(scene, segment_from(scene.samples, t), t)
    recall(scene, phase.buffer)
    evaluate(scene, phase, _phase(row(scene, RATES), scene.n), pushed[0], pushed[1], pushed[2])
    show(scene, phase, visible, True)
    let_go(scene)


@leaf
def _are_bounded(base, h):
    """Return True if all inputs stay within MOST_INPUT, m/s2, and the rotation within MOST_TURN, now and h s later."""
    bounded = abs(base.ax) <= MOST_INPUT and abs(base.ay) <= MOST_INPUT and abs(base.az) <= MOST_INPUT
    bounded = bounded and abs(base.ax + base.jx * h) <= MOST_INPUT and abs(base.ay + base.jy * h) <= MOST_INPUT
    bounded = bounded and abs(base.az + base.jz * h) <= MOST_INPUT
    bounded = bounded and abs(base.alpha_x) <= MOST_INPUT and abs(base.alpha_y) <= MOST_INPUT
    x, y, _, _ = rotation_at(base, base.t0 + h)
    return bounded and x * x + y * y <= MOST_TURN * MOST_TURN


@kernel
def _is_flat(scene, phase, t, stop):
    """Return True if neither the state nor base, record and ports until `stop` move anything across the plane x, z."""
    n, ports, samples = scene.n, scene.extras.spotted, scene.samples
    if scene.base.ay != 0.0 or scene.base.jy != 0.0:
        return False
    # loads at ports across the plane
    for way in (1, 3, 5):  # fy, mx, mz, and their slopes
        for p in range(way * ports, (way + 1) * ports):
            if scene.extras.inputs[p] != 0.0 or scene.extras.inputs[_LOAD * ports + p] != 0.0:
                return False
    # samples of the record
    for k in range(max(0, segment_from(samples, t)), samples.size):
        if samples.ay[k] != 0.0:
            return False
        if samples.times[k] >= stop:
            break
    return _lies_flat(scene.base, phase, n)


@leaf
def _lies_flat(base, phase, n):
    """Return True if neither the state nor the rotation of the base has a component across the plane x, z."""
    if is_turned_across(base):
        return False
    for i in range(n):
        # displacement, velocity and rotation across the plane
        across = phase.uy[i] != 0.0 or phase.vy[i] != 0.0 or phase.q1[i] != 0.0 or phase.q3[i] != 0.0
        if across or phase.wx[i] != 0.0 or phase.wz[i] != 0.0:
            return False
    return True


@kernel
def follow(model, state, counts, base, work, inputs, start, h, samples, visible):
    """Advance the structure from time `start` over h, s, under inputs that begin there, and the record; return a code.

    A structure that is its own mirror image in the plane x, z stays exactly in it while nothing moves it across.

    Parameters
    ----------
    model, state, counts, base, work : row
        The arrays of a structure (layout.py).
    inputs : row
        INPUTS, loads at ports, and where they apply rotation and bodies (coupled.py).
    start, h : float
        Time and length of the communication step, s.
    samples : Samples
        The record, without loads.
    visible : row
        Scratch space for an output row.

    Returns
    -------
    int
        OK or the code of an error (layout/spaces.py).
    """
    sizes, scene = sizes_in(model), scene_of(model, state, counts, base, samples, work)
    phase, stop = _state(state, sizes).phase, start + h
    is_plane = _head(model, 0).is_plane != 0.0
    # motion of the base: by inputs, or by the forces of bodies and structure
    if scene.settings.drive == ACCELERATION:
        _drive(scene, inputs, 0.0, start)
        if scene.settings.turns != 0.0:
            turn(scene, phase, scene.base, inputs)
    else:
        code = RECORD_BESIDE
        if samples.size == 0:
            arrive(scene, phase, scene.base, inputs, start)
            _see(scene, phase, start, visible)
            flat = is_plane and _lies_flat(scene.base, phase, scene.n)
            code = exchange(scene, scene.base, inputs, flat, visible[scene.visible - _REACTION :])
        if code != OK:
            return code
        examine_step(scene, scene.base, h)
    # loads
    _load(scene, inputs, 0.0, start)
    if not _are_bounded(scene.base, h):
        return INPUT_TOO_LARGE
    # plane motion, and the most steps of this call
    scene.counts.resting = 0
    flat = is_plane and _is_flat(scene, phase, start, stop)
    most, bounded = most_work(scene.settings, h), most_of_a_call(HEAVIER * (scene.n + scene.m))
    code_beyond = TOO_MUCH_WORK if most <= bounded else CALL_TOO_LONG
    # the plane motion, if it is one
    scene.settings.in_plane = 1.0 if flat else 0.0
    # steps
    state_row, nothing = phase.buffer, SpatialWatch(0, work, work, 0)
    code = advance(scene, nothing, state_row, start, stop, int(min(most, bounded)) // STAGES)
    scene.settings.in_plane = 0.0  # valid in this step only
    return code_beyond if code == PAUSED else code


@kernel
def look(model, state, counts, base, work, inputs, new_inputs, elapsed, t, samples, visible, driven):
    """Fill an output row from the state; before the first step the peaks become those of it. Return OK.

    Parameters
    ----------
    model, state, counts, base, work : row
        The arrays of a structure (layout.py).
    inputs, new_inputs, elapsed : row, int, float
        With `new_inputs` 1 base and ports follow these inputs from time t on; they were set `elapsed` s before.
    t : float
        Time, s.
    samples : Samples
        The record, without loads.
    visible : row
        The output row to fill.
    driven : row
        Filled with the motion of the base, where bodies may drive it, as the last step, or the inputs before, left it.
    """
    sizes, scene = sizes_in(model), scene_of(model, state, counts, base, samples, work)
    phase = _state(state, sizes).phase
    # motion of the base
    if new_inputs != 0:
        if scene.settings.drive == ACCELERATION:
            _drive(scene, inputs, elapsed, t)
        # if bodies drive it, the outputs depend on its rotation alone, before the first step
        if scene.settings.turns != 0.0 and scene.counts.started == 0:
            turned = turned_by(scene, inputs)
            if math.isfinite(turned.theta_x + turned.theta_y + turned.omega_x + turned.omega_y):
                start_at(scene.base, t)
                turn(scene, phase, scene.base, inputs)
    show_driven(scene.settings, scene.base, t, 0, driven)
    # without ports no output depends on inputs, nor where the state is kept
    if scene.extras.spotted == 0 or t >= end_after_fall(scene):
        _see(scene, phase, t, visible)
    else:  # accelerations of ports
        if new_inputs != 0:
            _load(scene, inputs, elapsed, t)
        _see_pushed(scene, phase, t, visible)
    # before the first step the peaks are those of the start
    if scene.counts.started == 0:
        clear_peaks(scene)
        raise_peaks(scene, visible)
    return OK


@kernel
def rates(model, state, counts, base, work, t, samples, visible, driven):
    """Fill an output row with the rates of all outputs at time t, 1/s. Return OK. `look` has been called at t.

    The rates are differences of the outputs along the rates of the state, over a fraction of the first step
    (engine/differences.py). The arguments are those of `look`; driven: filled with the rates of the motion of the base.
    """
    sizes, scene = sizes_in(model), scene_of(model, state, counts, base, samples, work)
    size, here, between = scene.visible, _state(state, sizes).phase.buffer, row(scene, STAGE)
    clear(visible, size)
    show_driven(scene.settings, scene.base, t, 1, driven)
    if t >= end_after_fall(scene):  # the state is kept
        return OK
    # rates of the state
    pace, segment = row(scene, RATES), segment_from(scene.samples, t)
    pushed = taken_at(scene, segment, t)
    recall(scene, here)
    evaluate_state(scene, here, pace, pushed[0], pushed[1], pushed[2])
    # weighted outputs at instants near time t
    is_brittle = scene.extras.glued > 0
    for k in range(points(is_brittle)):
        past, weight = point(is_brittle, k, RATE_PART * scene.settings.first_step)
        for i in range(moving(scene)):
            between[i] = here[i] + past * pace[i]
        pushed = taken_at(scene, segment, t + past)
        evaluate_state(scene, between, row(scene, RATES + 1), pushed[0], pushed[1], pushed[2])
        show(scene, _phase(between, scene.n), seen(scene, 0), True)
        for i in range(size):
            visible[i] += weight * seen(scene, 0)[i]
    let_go(scene)
    return OK


@leaf
def _driven_size(settings):
    """Return how many numbers `show_driven` fills."""
    if settings.bodies == 0.0:
        return 0
    return _DRIVEN + (_DRIVEN_TURN if settings.turns != 0.0 else 0)


@kernel
def feedthrough(model, state, counts, base, work, seeds, elapsed, t, visible, driven):
    """Fill an output row with the directional derivatives of the outputs at time t along input seeds. Return OK.

    Only accelerations of ports depend on inputs, linearly; the motion of the base (`driven`, cleared) does not. That
    all outputs follow the rotation of the base before the first step is left out.

    Parameters
    ----------
    model, state, counts, base, work : row
        The arrays of a structure (layout.py).
    seeds : row
        Directions of the inputs, laid out as these.
    elapsed : float
        Time since the inputs were set, s.
    t : float
        Time, s.
    visible, driven : row
        The rows to fill.
    """
    sizes, scene = sizes_in(model), scene_of(model, state, counts, base, no_samples(seeds), work)
    clear(visible, sizes.visible)
    clear(driven, _driven_size(scene.settings))
    if scene.extras.spotted == 0 or t >= end_after_fall(scene):
        return OK
    phase, pace, inputs = _state(state, sizes).phase, _phase(row(scene, RATES), scene.n), _inputs(seeds, 0)
    motion, loads = scene.base, seeds[_INPUTS:]
    # outputs without inputs
    recall(scene, phase.buffer)
    let_go(scene)
    turn_base(scene, motion, t, 0.0, 0.0, 0.0)
    evaluate(scene, phase, pace, 0.0, 0.0, 0.0)
    show(scene, phase, seen(scene, 0), True)
    # outputs with the seeds as loads and base acceleration
    count = _LOAD * scene.extras.spotted
    for i in range(count):
        scene.extras.pushes.row[i] = loads[i] + elapsed * loads[count + i]
    ax, ay, az = 0.0, 0.0, 0.0
    if scene.settings.drive == ACCELERATION:
        ax, ay, az = inputs.ax + elapsed * inputs.jx, inputs.ay + elapsed * inputs.jy, inputs.az + elapsed * inputs.jz
    turn_base(scene, motion, t, ax, ay, az)
    evaluate(scene, phase, pace, ax, ay, az)
    show(scene, phase, visible, True)
    let_go(scene)
    # the difference is the derivative, since outputs are linear in inputs
    for i in range(sizes.visible):
        visible[i] -= seen(scene, 0)[i]
    return OK
