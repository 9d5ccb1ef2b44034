"""One step of a structure by Dormand and Prince's explicit methods of orders 5 and 8, and the estimate of its error.

The coefficients are those of the plane columns (engine/dormand_prince.py, order_8.py). Quaternions are normalized
at the end of a step.
"""

from typing import Any

from ..engine import dormand_prince as dp
from ..engine import order_8
from ..engine.control import worse
from ..numba_ext.jit import kernel, leaf
from ..numba_ext.lanes import any_of, greater, index_of, lesser, magnitude, square_root, where, zero_like
from ..numba_ext.views import packs, packs_of
from .contact import error_of_pairs
from .evaluate import evaluate_state, moving
from .extras import taken_at
from .force_errors import error_of_forces
from .layout import MEMORY, OF_BLOCK, OF_JOINT, PHASE, STAGES
from .watch import BETWEEN, END, RATES, STAGE, START, row, seen

_phase, _memory = PHASE.over, MEMORY.over
_PER_BODY, _PER_JOINT = PHASE.per_n, MEMORY.per_n
_TX = OF_JOINT.index("Tx")
RESOLVED = 0.01  # largest error of an elastic slip, relative to the slip at the friction limit
KINK = 0.3  # error of a step in which a rate starts, stops or reverses, over its change times the step


@leaf
def rate(scene, k):
    """Return the row of rates at stage k of a step; the last row has the rates at its end."""
    return row(scene, RATES + k)


@kernel
def evaluate_at(scene, segment, y, f, t):
    """Fill `f` with the rates of the state `y` at time t (s) and count the evaluation."""
    scene.counts.evaluations += 1
    ax, ay, az = taken_at(scene, segment, t)
    evaluate_state(scene, y, f, ax, ay, az)


@kernel
def scale_quaternions(n, phase):
    """Normalize the quaternions of n bodies in `phase`."""
    for i in range(n):
        # one over the norm
        q0, q1, q2, q3 = phase.q0[i], phase.q1[i], phase.q2[i], phase.q3[i]
        per = 1.0 / square_root(q0 * q0 + q1 * q1 + q2 * q2 + q3 * q3)
        phase.q0[i], phase.q1[i], phase.q2[i], phase.q3[i] = per * q0, per * q1, per * q2, per * q3


@kernel
def attempt_5(scene, segment, t, h):
    """Make one step of order 5 over h seconds from row START to row END; return its error in tolerances.

    The stages use the rows of rates and the row STAGE; the row BETWEEN is filled with the embedded errors of the state.
    """
    begin, middle, ending = row(scene, START), row(scene, STAGE), row(scene, END)
    count = packs(begin, moving(scene))
    y, stage, end = packs_of(begin), packs_of(middle), packs_of(ending)
    f0, f1, f2 = packs_of(rate(scene, 0)), packs_of(rate(scene, 1)), packs_of(rate(scene, 2))
    f3, f4, f5 = packs_of(rate(scene, 3)), packs_of(rate(scene, 4)), packs_of(rate(scene, 5))
    last, error = packs_of(rate(scene, STAGES - 1)), packs_of(row(scene, BETWEEN))
    # stage 1
    for i in range(count):
        stage[i] = y[i] + h * (dp.A1_0 * f0[i])
    evaluate_at(scene, segment, middle, rate(scene, 1), t + dp.C1 * h)
    # stage 2
    for i in range(count):
        stage[i] = y[i] + h * (dp.A2_0 * f0[i] + dp.A2_1 * f1[i])
    evaluate_at(scene, segment, middle, rate(scene, 2), t + dp.C2 * h)
    # stage 3
    for i in range(count):
        stage[i] = y[i] + h * (dp.A3_0 * f0[i] + dp.A3_1 * f1[i] + dp.A3_2 * f2[i])
    evaluate_at(scene, segment, middle, rate(scene, 3), t + dp.C3 * h)
    # stage 4
    for i in range(count):
        stage[i] = y[i] + h * (dp.A4_0 * f0[i] + dp.A4_1 * f1[i] + dp.A4_2 * f2[i] + dp.A4_3 * f3[i])
    evaluate_at(scene, segment, middle, rate(scene, 4), t + dp.C4 * h)
    # stage 5
    for i in range(count):
        early = dp.A5_0 * f0[i] + dp.A5_1 * f1[i] + dp.A5_2 * f2[i]
        stage[i] = y[i] + h * (early + dp.A5_3 * f3[i] + dp.A5_4 * f4[i])
    evaluate_at(scene, segment, middle, rate(scene, 5), t + dp.C5 * h)
    # the state of order 5 at the end, and its rates
    for i in range(count):
        end[i] = y[i] + h * (dp.B_0 * f0[i] + dp.B_2 * f2[i] + dp.B_3 * f3[i] + dp.B_4 * f4[i] + dp.B_5 * f5[i])
    scale_quaternions(scene.n, _phase(ending, scene.n))
    evaluate_at(scene, segment, ending, rate(scene, STAGES - 1), t + h)
    # the difference to the embedded method of order 4
    for i in range(count):
        early = dp.ERROR_0 * f0[i] + dp.ERROR_2 * f2[i] + dp.ERROR_3 * f3[i]
        error[i] = h * (early + dp.ERROR_4 * f4[i] + dp.ERROR_5 * f5[i] + dp.ERROR_LAST * last[i])
    # relative to the allowed error
    return _error_in_tolerances(scene, row(scene, BETWEEN), h)


def _step_to(table_row: int) -> Any:
    """Create the leaf that evaluates the stages of a step of order 8 up to `table_row`, or up to its end."""
    before = _step_to(table_row - 1) if table_row > 1 else _no_stage
    sum_of, node = order_8.sum_by(table_row, rate), order_8.NODES[min(table_row, order_8.STAGES)]
    ends = table_row == order_8.END
    to, slope = (END, STAGES - 1) if ends else (STAGE, table_row)

    @leaf
    def step_to(scene, segment, t, h):
        before(scene, segment, t, h)
        y, reached = packs_of(row(scene, START)), row(scene, to)
        found = packs_of(reached)
        # the state of this stage, and its rates
        for i in range(packs(reached, moving(scene))):
            found[i] = y[i] + h * sum_of(scene, i)
        if ends:
            scale_quaternions(scene.n, _phase(reached, scene.n))
        evaluate_at(scene, segment, reached, rate(scene, slope), t + node * h)

    return step_to


@leaf
def _no_stage(scene, segment, t, h):
    return


def _error_by(table_row: int) -> Any:
    """Create the kernel that fills row BETWEEN with errors by a row of the table and returns them in tolerances."""
    sum_of = order_8.sum_by(table_row, rate)

    @kernel
    def error_by(scene, h):
        errors = row(scene, BETWEEN)
        found = packs_of(errors)
        # the embedded error of the state
        for i in range(packs(errors, moving(scene))):
            found[i] = h * sum_of(scene, i)
        return _error_in_tolerances(scene, errors, h)

    return error_by


@leaf
def square_of(x, y, z):
    """Return the squared norm of a vector."""
    return x * x + y * y + z * z


@leaf
def size_of(x, y, z):
    """Return the norm of a vector."""
    return square_root(square_of(x, y, z))


@leaf
def _with_kink(error, changed, turns, h):
    """Return the error of a remembered quantity, raised where its rate has a kink within the step (mask `turns`).

    changed: the change of its rate over the step. The stages see little of a kink that lies between them.
    """
    return where(turns, greater(error, KINK * h * changed), error)


@leaf
def _slides_anew(was, goes, j):
    """Return the mask of where joint j starts or stops sliding or reverses, by its slip rates `was` and `goes`."""
    zero = zero_like(was.p1[j])
    slides = size_of(was.p1[j], was.p2[j], zero) + size_of(goes.p1[j], goes.p2[j], zero) > 0.0
    return slides & (was.p1[j] * goes.p1[j] + was.p2[j] * goes.p2[j] <= 0.0)


@leaf
def _twists_anew(was, goes, j):
    return (magnitude(was.p3[j]) + magnitude(goes.p3[j]) > 0.0) & (was.p3[j] * goes.p3[j] <= 0.0)


@kernel
def _error_of_memory(scene, errors, allowed, h):
    """Return the largest error of the slips, plastic stretches and pair stretches over the allowed one.

    allowed: rad; slips are scaled by the arm of the joint, plastic stretches by the extent of the structure. The
    direction of friction depends on the elastic slips, so their error is bounded by a fixed fraction of them at any
    tolerance.
    """
    # errors of the memory, and its rates at both ends of the step
    slips, plastic = _memory(errors, scene.m), errors[_PER_JOINT * scene.m :]
    before, after = rate(scene, 0)[_PER_BODY * scene.n :], rate(scene, STAGES - 1)[_PER_BODY * scene.n :]
    was, goes, zero = _memory(before, scene.m), _memory(after, scene.m), zero_like(allowed)
    largest = zero
    # slips and twist of each joint
    for j in range(scene.m):
        arm = scene.joints.arm[j]
        changed = size_of(goes.p1[j] - was.p1[j], goes.p2[j] - was.p2[j], zero)
        error = _with_kink(size_of(slips.p1[j], slips.p2[j], zero), changed, _slides_anew(was, goes, j), h)
        changed = magnitude(goes.p3[j] - was.p3[j])
        error += arm * _with_kink(magnitude(slips.p3[j]), changed, _twists_anew(was, goes, j), h)
        largest = worse(largest, error / lesser(RESOLVED * scene.joints.reach[j], arm * allowed))
    # the plastic stretch of each tie
    for e in range(scene.k):
        begins, ends = before[_PER_JOINT * scene.m + e], after[_PER_JOINT * scene.m + e]
        turns = (magnitude(begins) + magnitude(ends) > 0.0) & (begins * ends <= 0.0)
        error = _with_kink(magnitude(plastic[e]), magnitude(ends - begins), turns, h)
        reach = scene.ties.yields_at[e] / scene.ties.stiffness[e]
        largest = worse(largest, error / lesser(RESOLVED * reach, scene.settings.extent * allowed))
    return worse(largest, error_of_pairs(scene, errors) / (scene.settings.extent * allowed))


@kernel
def _per_force(scene, one, other):
    """Return the largest acceleration of one of two bodies per force between them, over its size, 1/(kg m)."""
    bodies, most = scene.bodies, zero_like(scene.settings.gravity)
    # of the moving bodies of both
    for body in (index_of(one), index_of(other)):
        if body < scene.n:
            most = greater(most, bodies.per_mass[body] / bodies.size[body])
    return most


@kernel
def _error_by_kinks(scene, h):
    """Return the largest error of a rate, rad/s, by a kink in a force within the step just made.

    Kinks: a tie becomes taut or slack; a joint starts or stops sliding.
    """
    largest, ties = zero_like(h), seen(scene, 0)[len(OF_BLOCK) * scene.n + len(OF_JOINT) * scene.m :]
    # ties that became taut or slack
    for e in range(scene.k):
        was, goes = ties[e], scene.pulls.force[e]
        turns = ((was == 0.0) | (goes == 0.0)) & (was != goes)
        if any_of(turns):
            error = KINK * h * magnitude(goes - was) * _per_force(scene, scene.ties.one[e], scene.ties.other[e])
            largest = where(turns, worse(largest, error), largest)
    # joints that started or stopped sliding, by the change of their shear force
    if any_of(scene.settings.gives_way != 0.0):
        first = len(OF_BLOCK) * scene.n + _TX * scene.m
        along, across, found = seen(scene, 0)[first:], seen(scene, 0)[first + scene.m :], scene.resultants
        was, goes = _memory(rate(scene, 0)[_PER_BODY * scene.n :], scene.m), scene.giving_slips
        for j in range(scene.m):
            turns = _slides_anew(was, goes, j)
            if any_of(turns):
                changed = size_of(found.t1[j] + along[j], found.t2[j] + across[j], zero_like(h))
                error = KINK * h * changed * _per_force(scene, scene.joints.upper[j], scene.joints.lower[j])
                largest = where(turns, worse(largest, error), largest)
    return largest


@kernel
def _error_in_tolerances(scene, errors, h):
    """Return the largest error of the state over the allowed one: the tolerance times the largest motion so far.

    Errors are compared in rad and rad/s; displacements of a body are divided by its size.
    """
    error, zero = _phase(errors, scene.n), zero_like(scene.settings.tolerance)
    place, rate = zero, zero  # squares
    # squares of the largest errors of a displacement or rotation, and of a velocity
    for i in range(scene.n):
        per = 1.0 / (scene.bodies.size[i] * scene.bodies.size[i])
        place = worse(place, per * square_of(error.ux[i], error.uy[i], error.uz[i]))
        place = worse(place, 4.0 * (error.q0[i] * error.q0[i] + square_of(error.q1[i], error.q2[i], error.q3[i])))
        rate = worse(rate, per * square_of(error.vx[i], error.vy[i], error.vz[i]))
        rate = worse(rate, square_of(error.wx[i], error.wy[i], error.wz[i]))
    # relative to the largest motion and the largest rate so far
    place, rate = square_root(place), square_root(rate)
    rate = worse(_error_by_kinks(scene, h), rate)
    control, tolerance = scene.control, scene.settings.step_tolerance
    place = worse(rate / (tolerance * control.largest_rate), place / (tolerance * control.largest))
    # slips and plastic stretches
    if any_of(scene.settings.gives_way != 0.0):
        allowed = tolerance * control.largest
        place = worse(_error_of_memory(scene, errors[_PER_BODY * scene.n :], allowed, h), place)
    return place


_step, _error_5, _error_3 = _step_to(order_8.END), _error_by(order_8.ERROR_5), _error_by(order_8.ERROR_3)


@kernel
def attempt(scene, segment, t, h):
    """Make one explicit step over h seconds from row START to row END; return its error in tolerances."""
    # order 8 combines two embedded errors; order 5 may be bounded by force errors too
    if scene.settings.order == order_8.ORDER:
        _step(scene, segment, t, h)
        return order_8.error_of(_error_5(scene, h), _error_3(scene, h))
    return _with_forces(scene, attempt_5(scene, segment, t, h))


@leaf
def _with_forces(scene, error):
    """Return the error of a step in tolerances, including that of the joint forces where their peaks are recorded."""
    if scene.settings.watches != 0.0 and error <= 1.0:
        error = worse(error_of_forces(scene, row(scene, BETWEEN)), error)
    return error


@kernel
def error_of_step(scene, h):
    """Return the error, in tolerances, of a step of h seconds whose state errors are in row BETWEEN."""
    return _with_forces(scene, _error_in_tolerances(scene, row(scene, BETWEEN), h))
