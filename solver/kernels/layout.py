"""What lies where in the flat arrays that the kernels share.

A *phase* is three consecutive segments of 2n numbers: coordinates, rates, accelerations. In each segment the first n
numbers are the rotations theta relative to the base (formulation exact) or the displacements v (paper), the last n the
joint openings delta (exact) or the settlements w (paper); block 1 is the top block.
"""

# --- formulations and integrators, as stored in the model header
EXACT = 0
PAPER = 1
AUTO = 0
CENTRAL_DIFFERENCE = 1

# --- model (float64): header, then one row per block
N_BLOCKS = 0  # n
GRAVITY = 1  # m/s2
FORMULATION = 2
INTEGRATOR = 3
STEP = 4  # s, fixed-step integrators
TOLERANCE = 5  # relative to the peak, error-controlled integrators
FIRST_STEP = 6  # s, first trial of error-controlled integrators
ROTATION_FLOOR = 7  # rad, least rotation that errors are measured against
RATE_FLOOR = 8  # rad/s, least rate that errors are measured against
WITHOUT = 9  # sum of the short cuts that are not to be taken
MODAL = 10  # where the modal data begin, 0 where there are none
EXPLICIT_ORDER = 11  # 5 or 8, of the explicit method of `auto`
MODEL_HEADER = 12

# short cuts, as stored in WITHOUT
ELASTIC = 1  # modes instead of joints while all of these are in full contact
REST = 2  # no steps while the column rests on a base that does not accelerate
DASHPOTS = 4  # no dashpot in a joint without damping
RESULTANTS = 8  # output rows only where they are asked for
IMPLICIT_METHOD = 16  # the implicit method where it goes further than the explicit one

HEIGHT = 0  # m
CENTROID = 1  # m above the bottom face
MASS = 2  # kg
INERTIA = 3  # kg m2, about the centroid
STIFFNESS = 4  # N/m3, of the joint under the block
JOINT_WIDTH = 5  # m
JOINT_DEPTH = 6  # m
DAMPING = 7  # s
TURN_SIZE = 8  # first coordinate of the block when the column turns by 1 rad: 1 (exact), height of its top face (paper)
OPEN_SIZE = 9  # m, opening with the elastic energy of a joint rotation of 1 rad: width / sqrt(12)
PIVOT = 10  # 1/kg, inverse pivot and
COUPLING = 11  # multiplier of the factorized horizontal mass matrix (formulation paper)
FALL_ANGLE = 12  # rad, rotation of the block or its joint from which nothing comes back
BLOCK_FIELDS = 13

# --- modal data, at the end of the model: header, one row per mode (n of rotations, n of openings), then n x n matrices
# by rows: shapes Phi of the rotations and of the openings, and likewise their inverses Phi' M
MODAL_THIRD = 0  # third over second difference of the nonlinear remainder, at most
MODAL_LONGEST = 1  # s, longest step
MODAL_SWEEPS = 2  # over each step
MODAL_HEADER = 3
MODE_SQUARE = 0  # 1/s2, omega^2
MODE_DAMPING = 1  # 1/s, 2 zeta omega
MODE_PUSH = 2  # modal force for 1 m/s2 of the base (rotations: base_ax; openings: g + base_az)
MODE_SIZE = 3  # largest coordinate of the shape in parts of its size
MODE_FIELDS = 4
MODAL_MOST = 64  # blocks; measured 3 to 7 times faster than without at 64, but the matrices grow as n^2
INTERPOLATION_BOUND = 46080.0  # the quintic between two steps h misses a motion of frequency w by (w h)^6 over this
INTERPOLATION_PART = 5.0  # tolerances of a step that it may miss: these errors do not add up

# --- state (float64): header, one phase, peaks
NEXT_STEP = 0  # s, what the error control proposes
ROTATION_SCALE = 1  # rad, largest rotation so far
RATE_SCALE = 2  # rad/s, largest rate so far
BASE_AX = 3  # m/s2, base acceleration that the accelerations of the phase belong to
BASE_AZ = 4
OVERTURN_TIME = 5  # s
LAST_ERROR = 9  # of the last step accepted, in parts of the tolerance
EXPLICIT_STEP = 10  # s, what the explicit method of `auto` has been stepping by
TIME_FULL = 6  # s spent with every joint in full contact
TIME_ROCKING = 7  # s with some joint partly open, none fully
TIME_FLIGHT = 8  # s with some joint fully open
ELASTIC_STEP = 11  # s, proposed for the modal method
TIME_AT_REST = 12  # s that were skipped
BASE_THETA = 13  # rad, rotation of the base that the rotations of the phase are relative to
BASE_OMEGA = 14  # rad/s, and their rates
BASE_ALPHA = 15  # rad/s2, and their accelerations
STATE_HEADER = 16

# --- counters (int64)
STEPS = 0
REJECTED = 1
EVALUATIONS = 2
SWEEPS = 3
OVERTURNED = 4  # number of the joint that let go, 0 while the column stands
STARTED = 5  # 0 until the accelerations of the phase have been computed once
NEXT_ROW = 6  # first output time not yet served
IMPLICIT = 7  # 1 while `auto` steps by its implicit method
IMPLICIT_STEPS = 8  # of STEPS
SINCE_PROBE = 9  # explicit steps since the implicit method was last tried
EVENTS = 10  # steps cut off where the regime of a joint changes
UNHELD = 11  # 1 when the next step is made without holding the regimes
ELASTIC_STEPS = 12  # of STEPS
ELASTIC_WAIT = 13  # steps to be made by other methods before the modal one is tried again
IN_FLIGHT = 14  # 1 while a joint is fully open
COUNTERS = 15

# --- inputs (float64): base acceleration at t, a_x = AX + JX (t - T0) + AMPLITUDE sin(OMEGA t + PHASE); the base turns
# by THETA + OMEGA (t - T0) + ALPHA (t - T0)^2 / 2, clockwise
INPUT_AX = 0  # m/s2
INPUT_JX = 1  # m/s3
INPUT_AZ = 2
INPUT_JZ = 3
INPUT_T0 = 4  # s
INPUT_AMPLITUDE = 5  # m/s2
INPUT_OMEGA = 6  # rad/s
INPUT_PHASE = 7  # rad
INPUT_BASE_THETA = 8  # rad
INPUT_BASE_OMEGA = 9  # rad/s
INPUT_BASE_ALPHA = 10  # rad/s2
INPUTS = 11

# --- one snapshot (float64): a phase, then the base acceleration that belongs to it; these count from 6 n
SNAPSHOT_AX = 0  # m/s2
SNAPSHOT_AZ = 1
SNAPSHOT_TAIL = 2

# --- one output row (float64): fields of n numbers each, then the base reaction
ROW_UX = 0
ROW_UZ = 1
ROW_THETA = 2
ROW_N = 3
ROW_M = 4
ROW_S = 5
ROW_CONTACT = 6
ROW_SIGMA = 7
ROW_FIELDS = 8
ROW_FX = 0  # N, these three count from 8 n
ROW_FZ = 1  # N
ROW_MY = 2  # N m
ROW_TAIL = 3

# --- the base reaction split (float64): R = R0 - M a with R = (Fx, Fz, My), a = (a_x, a_z, alpha) of the base
SPLIT_R0X = 0  # N
SPLIT_R0Z = 1  # N
SPLIT_R0M = 2  # N m
SPLIT_MXX = 3  # kg
SPLIT_MXZ = 4  # kg
SPLIT_MXT = 5  # kg m
SPLIT_MZZ = 6  # kg
SPLIT_MZT = 7  # kg m
SPLIT_MTT = 8  # kg m2
SPLIT = 9

# --- work (float64): phases, then fields of n numbers each
PHASE_START = 0  # the phase a step starts from; 1 to 11 are the inner stages of a Runge-Kutta step
PHASE_END = 12  # the phase it arrives at
PHASE_BETWEEN = 13  # interpolated inside the step
PHASE_BUMP = 14  # 2 n numbers that the interpolation adds for the acceleration half-way; whether they are wanted
N_PHASES = 15
SCRATCH_FIELDS = 17  # of the acceleration kernels
TOP_START = 17  # displacement and velocity of the top faces at the start of a step
TOP_END = 19  # and at its end
TOP_BETWEEN = 21
WORK_FIELDS = 23
TANGENT_FIELDS = 22  # of the implicit solution
RESPONSE_FIELDS = 21  # of a mode over a step, 2 n modes
RESPONSE_HEADER = 2
RESPONSES = 2  # steps whose responses are kept

# fields of the scratch that every formulation leaves behind: resultants of the joints
JOINT_NORMAL = 14  # N
JOINT_MOMENT = 15  # N m
JOINT_LENGTH = 16  # m in contact

SLACK = 1e-9  # of a step: times closer than this are the same

# --- codes returned by the kernels
OK = 0
HAS_OVERTURNED = 1  # the state is held; not an error
STEP_TOO_SMALL = -1
NOT_CONVERGED = -2
NOT_FINITE = -3
ROTATES = -4  # the base, which the formulation does not know


def state_size(n: int) -> int:
    """Length of the state array of n blocks."""
    return STATE_HEADER + 7 * n


def snapshot_size(n: int) -> int:
    """Length of one snapshot of n blocks."""
    return 6 * n + SNAPSHOT_TAIL


def row_size(n: int) -> int:
    """Length of one output row of n blocks."""
    return ROW_FIELDS * n + ROW_TAIL


def modal_size(n: int) -> int:
    """Length of the modal data of n blocks."""
    return MODAL_HEADER + 2 * n * MODE_FIELDS + 4 * n * n


def work_size(n: int) -> int:
    """Length of the scratch array of n blocks."""
    trend = 1 + 4 * n
    responses = 1 + RESPONSES * (RESPONSE_HEADER + RESPONSE_FIELDS * 2 * n)
    return (6 * N_PHASES + WORK_FIELDS + TANGENT_FIELDS) * n + trend + responses
