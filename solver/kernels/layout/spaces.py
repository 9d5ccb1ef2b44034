"""The layout of the flat arrays that the kernels share, by name (views.py lays the names over them).

    model   space MODEL     what describes the column and its settings; modal data at the end
    state   space STATE     coordinates, rates, accelerations; what the step control remembers; peaks
    counts  record COUNTS   int64; belongs to the state
    base    record BASE     motion of the base within a call
    work    space WORK      scratch: nothing in it outlives a call but responses of modes

Block 1 is the top block, joint i lies under block i. A *phase* is coordinates, rates, accelerations: the coordinates
are the rotations theta relative to the base and the joint openings, or in their places the displacements v and the
settlements w of the paper (kernels/paper/). Where joints may slide, a second part of the phase follows, with the
slips as coordinates, and where they may be bonded by mortar a third, with the bonds; otherwise these are unused.
"""

from typing import Any

from ..numba_ext.jit import in_both
from ..numba_ext.views import FieldTable, Numbers, Record, Space

# --- short cuts, as stored in the settings
ELASTIC = 1  # modes instead of joints while all of these are in full contact
REST = 2  # no steps while the column rests on a base that does not accelerate
DASHPOTS = 4  # no dashpot in a joint without damping
RESULTANTS = 8  # output rows only where they are asked for
IMPLICIT = 16  # the implicit method where it goes further than the explicit one
EXTREMES = 32  # no short cut: peaks of more than u_x

# --- drive of the base: by its inputs, or by bodies at it (formulations/coupled_base.py), in the plane or along x alone
ACCELERATION, BODY, HORIZONTAL = 0.0, 1.0, 2.0
DRIVES = {"acceleration": ACCELERATION, "body": BODY, "horizontal": HORIZONTAL}
SLOPE_PARABOLA, SLOPE_LINE, SLOPE_HELD = 0.0, 1.0, 2.0
SLOPES = {"parabola": SLOPE_PARABOLA, "line": SLOPE_LINE, "held": SLOPE_HELD}

# --- model
SETTINGS = Record(
    "n",  # number of blocks
    "gravity",  # m/s2
    "step",  # s, of the paper's fixed steps
    "tolerance",  # of a step, relative to the peak
    "first_step",  # s, first trial
    "rotation_floor",  # rad, least rotation that errors are measured against
    "rate_floor",  # rad/s, least rate that errors are measured against
    "without",  # sum of the short cuts that are not to be taken
    "has_modes",  # 1 where there are modal data, which are not made where that short cut is left out
    "explicit_order",  # 5 or 8, of the explicit method of `auto`
    "slides",  # 1 where some joint may slide, or the column is off its axis: slips are coordinates
    "off_axis",  # 1 where the rest is not the straight column
    "per_slip",  # 1/m, rotation of the column that moves its top as far as a slip
    "drive",  # how the base moves: a code of DRIVES
    "slope",  # how its acceleration goes on where a body drives it: a code of SLOPES
    "bodies",  # number of bodies that drive it
    "ports",  # number of ports, which are stored behind the model (`model_room`)
    "bonded",  # 1 where joints may be bonded by mortar: phases hold their bonds
)
MOST_STRIPS = 32  # of a section made of strips
STRIP_NUMBERS = 2 + MOST_STRIPS  # how many strips, their width in m, their depths in m
# the law of the joint under the block (joint/law.py)
LAW = (
    "stiffness",  # N/m3
    "damping",  # s
)
OTHER_LAW: tuple[str, ...] = LAW[2:]  # if one of these is not 0, the law is not the linear one
BLOCKS = FieldTable(
    "height",  # m
    "centroid",  # m above the bottom face
    "upper",  # m, from the centroid to the top face
    "mass",  # kg
    "inertia",  # kg m2, about the centroid
    "per_mass",  # 1/kg
    "per_inertia",  # 1/(kg m2)
    "per_masses",  # 1/kg, sum of this for the block and for the one below it, if any
    *LAW,
    "section",  # of the contact: a code, and what goes with it (sections/section.py)
    "left",  # m from the middle of the block: ends of the contact
    "right",
    "width",  # m, from end to end
    "depth",  # m
    "rigidity",  # N/m2, stiffness times depth
    "bore",  # m
    "friction",  # of the joint; 0: it never slides
    "dowel",  # N, shear capacity of the joint without friction
    "reach",  # m, opening at which mortar breaks in tension; negative for a dry joint
    "cohesion",  # Pa, shear capacity of the bonded part of the joint
    "offset",  # m, of the block over what is under it, as built: where its slip begins
    "lean",  # rad, of the joint against the horizontal, as built, clockwise
    "tilt",  # rad, of the block against the vertical, as built, clockwise
    "built_x",  # m, middle of the top face, as built
    "rest_turn",  # rad and
    "rest_opening",  # m, of a column that is off its axis, under its weight
    "own_left",  # m from the middle of the block: ends of its contact face, of which the face below may bear a part,
    "own_right",
    "own_depth",  # m
    "own_bore",  # m
    "rim_left",  # m from the middle of what is under the joint: ends of its face
    "rim_right",
    "bore_below",  # m, inner diameter of that face
    "slipped",  # section once there is a slip
    "overhangs",  # 1 where the contact face reaches beyond the face below as built
    "rim",  # m, width of the band along the edges of the faces in which they touch; 0: all over
    "open_size",  # m, opening with the elastic energy of a joint rotation of 1 rad: radius of gyration of the contact
    "per_open_size",
    "fall_angle",  # rad, rotation of the block or its joint beyond which it cannot come back
    "pivot",  # 1/kg, inverse pivot and
    "coupling",  # multiplier of the factorized horizontal mass matrix of the paper
    strips=STRIP_NUMBERS,
    together={"law": LAW},
)
MODEL = Space(settings=SETTINGS, blocks=BLOCKS, modal=Numbers())

# --- modal data: header, then the 2 n modes, then room for two matrices of 2 n x 2 n: the shapes Phi by rows, and their
# inverses Phi' M. On the axis each is two matrices of n x n, of the rotations and of the openings, each with n modes.
MODAL_LIMITS = Record(
    "parts",  # 2, or 1 where rotations and openings act on each other
    "third",  # third over second difference of the nonlinear remainder, at most
    "longest",  # s, longest step
    "sweeps",  # over each step
)
MODE = Record(
    "square",  # 1/s2, omega^2
    "damping",  # 1/s, 2 zeta omega
    "push",  # modal force for 1 m/s2 of base ax
    "lift",  # and of g + base az; in space without g, coordinates count from the rest
    "across",  # and of base ay, in space
    "size",  # largest coordinate of the shape in parts of its size
)
MODAL_MOST = 64  # blocks; measured 3 to 7 times faster than without at 64, but the matrices grow as n^2
INTERPOLATION_BOUND = 46080.0  # the quintic between two steps h misses a motion of frequency w by (w h)^6 over this
INTERPOLATION_PART = 5.0  # tolerances of a step that it may miss: these errors do not add up

# --- state
# In either part of a phase a rate stands 2 n numbers behind its coordinate, so that the same sums serve both parts:
# `coordinates[i]`, `rates[i]` and `accelerations[i]` belong to the coordinate at place i, for a slip one from 6 n on.
PHASE = FieldTable(
    *("theta", "opening", "theta_rate", "opening_rate", "theta_acceleration", "opening_acceleration"),
    "slip",  # m, of the upper face of the joint along its tangent
    "friction_work",  # J, that friction has taken out
    "slip_rate",
    "friction_power",
    "slip_acceleration",
    "sliding",  # 1 or -1: slides that way, 0: sticks
    "bond_left",  # m from the middle of the block: ends of the bonded part of the joint
    "bond_right",
    "bond_lost",  # broken share of the bond
    together={
        "coordinates": ("theta", "opening"),
        "rates": ("theta_rate", "opening_rate"),
        "accelerations": ("theta_acceleration", "opening_acceleration"),
        "slips": ("slip", "friction_work", "slip_rate", "friction_power", "slip_acceleration", "sliding"),
        "bonds": ("bond_left", "bond_right", "bond_lost"),
    },
    reach={"coordinates": 8, "rates": 10, "accelerations": 8, "slips": 9},  # slips are copied with the bonds
)
RIGID_FIELDS = 6  # of the first part
PHASE_FIELDS = 12  # of the first two: those of a column without mortar
# all outputs of a column at one instant (ROW below), and T / N
OUTPUTS = FieldTable("ux", "uz", "theta", "N", "M", "S", "contact", "sigma_max", "T", "slip")
REACTION = Record("Fx", "Fz", "My")  # of the base: N, N, N m; behind them outputs of the whole
# largest absolute values so far; in the place of the contact the largest part of the width that was out of it, and
# |T| / N where N is more than COUNTS_FROM of the weight that the joint carries at rest
PEAKS = Space(joints=OUTPUTS, base=REACTION, friction=Numbers(per_n=1))
COUNTS_FROM = 0.05
CONTROL = Record(
    "next_step",  # s, what the error control proposes
    "rotation_scale",  # rad, largest rotation so far
    "rate_scale",  # rad/s, largest rate so far
    "base_ax",  # m/s2, base motion that the accelerations of the phase belong to
    "base_az",
    "base_theta",  # rad, rotation of the base that the rotations of the phase are relative to
    "base_omega",  # rad/s, its rate
    "base_alpha",  # rad/s2, its acceleration
    "overturn_time",  # s
    "previous_error",  # of the last step accepted, in parts of the tolerance
    "explicit_step",  # s, the last step of the explicit method of `auto`
    "elastic_step",  # s, proposed for the modal method
    "time_full",  # s spent with every joint in full contact
    "time_rocking",  # s with some joint partly open, none fully
    "time_flight",  # s with some joint fully open
    "time_at_rest",  # s that were skipped
    "reached",  # s, the instant at which the last call ended
)
STATE = Space(control=CONTROL, phase=PHASE, peaks=Numbers(PEAKS.per_n, PEAKS.beside))
COUNTS = Record(
    "steps",
    "rejected",
    "evaluations",
    "sweeps",
    "overturned",  # number of the joint that overturned, 0 while the column stands
    "started",  # 0 until the accelerations of the phase have been computed once
    "next_row",  # first output time not yet served
    "implicit",  # 1 while `auto` steps by its implicit method
    "implicit_steps",  # of steps
    "since_probe",  # explicit steps since the implicit method was last tried
    "events",  # steps cut off where the regime of a joint changes
    "unheld",  # 1 when the next step is made without holding the regimes
    "elastic_steps",  # of steps
    "elastic_wait",  # steps to be made by other methods before the modal one is tried again
    "in_flight",  # 1 while a joint is fully open
    "resting",  # 1 while it rests on a base that is still
    "looks",  # evaluations for what is watched; the steps do not depend on them
    "until_opening",  # 1 where `advance` is to end once the modal method does not go on
)

# --- base: a_x = ax + jx (t - t0) + wave_amplitude sin(wave_omega t + wave_phase); the base turns by
# theta + omega (t - t0) + alpha (t - t0)^2 / 2 + jalpha (t - t0)^3 / 6, clockwise
BASE = Record(
    "t0",  # s
    "ax",  # m/s2
    "jx",  # m/s3
    "az",
    "jz",
    "wave_amplitude",  # m/s2
    "wave_omega",  # rad/s
    "wave_phase",  # rad
    "theta",  # rad
    "omega",  # rad/s
    "alpha",  # rad/s2
    "anchor",  # s, instant at which the sine and the cosine of the harmonic part stand here
    "anchor_sine",
    "anchor_cosine",
    "segment",  # number of the sample of the record that the step began at or after; -1 before the first
    "piece_begin",  # s, the straight line of the record on that segment, worked out once
    "piece_end",
    "piece_ax",  # m/s2
    "piece_jx",  # m/s3
    "piece_az",
    "piece_jz",
    "jalpha",  # rad/s3, slope of alpha
    "coupled",  # 1 once a body has driven the base
    "steps",  # exchanges before this one that are kept, at most 2
    "last_step",  # s, from the last one to this one; m/s2 and rad/s2, what it was driven by then
    "last_ax",
    "last_az",
    "last_alpha",
    "before_step",  # and the one before
    "before_ax",
    "before_az",
    "before_alpha",
    *("x", "z", "vx", "vz"),  # m, m/s, at time t0: how far the base has moved since bodies drive it
    *("mass_x", "mass_z", "mass_turn"),  # kg, kg, kg m2: of all that moves with the base, at the last exchange
    *("checked_step", "checked_mass"),  # s, longest step so far; least sum of these masses so far
    "allowed_step",  # s, the longest stable step, once a step was longer; 0 while none was
)

# --- one snapshot: the base acceleration, then the phase that belongs to it, slips where there are any
SNAPSHOT = Space(base=Record("ax", "az"), phase=PHASE)


def snapshot_size(n: int, slips: bool, bonds: bool = False) -> int:
    """Return the length of a snapshot of n blocks."""
    return SNAPSHOT.beside + (PHASE.per_n if bonds else PHASE_FIELDS if slips else RIGID_FIELDS) * n


def phases_in(snapshots: Any) -> Any:
    """Return the phases of snapshots, shape (snapshots, phase length)."""
    return snapshots[:, SNAPSHOT.beside :]


# --- one output row: fields of n numbers each, then the base reaction
ROW = Space(joints=OUTPUTS, base=REACTION)

# --- the base reaction split: R = R0 - M a with R = (Fx, Fz, My), a = (a_x, a_z, alpha) of the base
SPLIT = Record("R0x", "R0z", "R0m", "mxx", "mxz", "mxt", "mzz", "mzt", "mtt")  # N, N m, kg, kg m, kg m2
# behind it where bodies may drive the base: its motion, m, rad, m/s, rad/s, m/s2, rad/s2
DRIVEN = Record("x", "z", "theta", "vx", "vz", "omega", "ax", "az", "alpha")

# --- ports: points of blocks at which loads act (formulations/loads.py), and whose motion is seen
PORTS = FieldTable("body", "x", "z")  # number of the block; m, from its centroid along its axes as built
LOAD = ("fx", "fz", "my")  # N, N, N m
SPOTS = FieldTable("x", "z", "vx", "vz", "ax", "az")  # m, m/s, m/s2: their outputs, behind an output row
PUSHES = FieldTable(*LOAD)  # the loads at an instant, behind the work of a column


def work_size(n: int, ports: int) -> int:
    """Return the length of the work of n blocks with ports."""
    return WORK.size(n) + PUSHES.size(ports) + SPOTS.size(ports)


# --- work
JOINTS = FieldTable(
    "normal",  # N
    "moment",  # N m
    "length",  # m in contact
    "tangential",  # N, along the joint, on the block above in the direction of its tangent
    "pressure_shear",  # N, the part of it that is no friction: the pressure acts along the normal of a face
    "shear_capacity",  # N, by friction and dowel; the joint slides beyond
    "sliding",  # 1 or -1: the joint slides that way, 0: it sticks; an input of an evaluation
    "overcome",  # 1 once an evaluation found a joint that sticks beyond what it bears
    "bond_left",  # m from the middle of the block: the bond at the start of the step, an input of an evaluation
    "bond_right",
    "bonded_left",  # m: the part of it that is left in the evaluation
    "bonded_right",
)
# scratch of one evaluation, which names the rows
ROOM = FieldTable("a", "b", "c", "d", "e", "f", "g", "h", "i", "j", "k", "l", "m", "n", "o", "p")
HOLD = FieldTable(
    "held",  # regime that the joint is held in; 0: any
    "regime",  # that it was last held in
    "outside",  # 1 if an evaluation found the joint outside it
    whole=True,
)
TOPS = FieldTable("start_ux", "start_rate", "end_ux", "end_rate", "between_ux", "between_rate")  # of the top faces
PIECES = 4  # of a step that is searched for peaks
TANGENT_FIELDS = 28  # of the implicit solution
STAGES = 12  # the start of a step and the inner stages of a Runge-Kutta step
INTERPOLATION = Record(
    "wants_bump",  # whether `refine` shall improve on the quintic
    "has_bump",  # whether it has
    "knows_middle",  # whether the method has evaluated the middle of the step: `stage` 1 and `joints_halfway`
)
RESPONSE_FIELDS = 22  # of a mode over a step, 2 n modes
RESPONSE_HEADER = 5
RESPONSES = 2  # steps whose responses are kept
TREND = Record("known", "margin")  # N, against sliding in the middle of the step
# of the present call, set at its begin
LOADING = Record(
    "ports",  # number of ports
    "general",  # not 0 where there are ports or bonds
)
SLIPS = Record(
    "count",  # slip coordinates: n where joints may slide, else 0
    "change",  # 1 where forces jump at the end of the step: a joint begins or ceases to slide, or a bond breaks
    "bonds",  # number of joints with bonds: n where joints may be bonded, else 0
)

WORK = Space(
    start=PHASE,
    stages=Numbers(per_n=PHASE.per_n * (STAGES - 1)),
    end=PHASE,
    between=PHASE,
    bump=Numbers(per_n=3, beside=8),  # packs of eight may extend beyond `between`
    interpolation=INTERPOLATION,
    joints=JOINTS,
    joints_halfway=JOINTS,
    hold=HOLD,
    slips=SLIPS,
    loading=LOADING,
    room=ROOM,
    tops=TOPS,
    counts_from=Numbers(per_n=1),  # N, from which on T / N counts
    allowed=Numbers(PEAKS.per_n, PEAKS.beside),  # excess over its peak up to which a quantity is not searched
    seen=Numbers(
        PEAKS.per_n * (PIECES + 3), PEAKS.beside * (PIECES + 3)
    ),  # outputs at the ends of the pieces and of a trial; marks
    tangent=Numbers(per_n=TANGENT_FIELDS),
    trend=TREND,
    slopes=Numbers(per_n=2),
    curvatures=Numbers(per_n=2),
    latest=Record("response"),
    responses=Numbers(per_n=RESPONSES * RESPONSE_FIELDS * 2, beside=RESPONSES * RESPONSE_HEADER),
)

SLACK = 1e-9  # of a step: times closer than this are the same

# --- codes returned by the kernels
OK = 0
HAS_OVERTURNED = 1  # the state is held; not an error
STEP_TOO_SMALL = -1
NOT_CONVERGED = -2
NOT_FINITE = -3
ROTATES = -4  # the base rotates, which the paper's model lacks
TOO_MUCH_WORK = -5  # more evaluations than any column takes
INPUT_TOO_LARGE = -6
CALL_TOO_LONG = -7  # shorter ones can be made
BODY_LACKING = -8  # forces act at the base, which has no mass
RECORD_BESIDE = -9  # a record is followed on a base that a body drives
UNKNOWN_METHOD = -15  # integrators/traits.py lacks the method of a step; -10 to -14: codes of `assemble`
MOST_INPUT = 1e6  # of each input of the base, in its unit


@in_both
def model_room(n: int) -> int:
    """Return the length of the largest packed model of n blocks; its ports are stored behind it."""
    return _MODEL_PER_N * n + _MODEL_BESIDE + (modal_size(n) if n <= MODAL_MOST else 0)


@in_both
def modal_size(n: int) -> int:
    """Return the length of the modal data of n blocks."""
    return _MODAL_BESIDE + 2 * n * _MODE_FIELDS + 8 * n * n


_MODAL_BESIDE, _MODE_FIELDS = MODAL_LIMITS.beside, MODE.beside
_MODEL_PER_N, _MODEL_BESIDE = MODEL.per_n, MODEL.beside
