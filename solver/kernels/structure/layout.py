"""The layout of the flat arrays of a structure in space, by name (numba_ext/views.py).

A structure has n blocks, m joints, k ties, ports and pairs of neighbours. The base is body n: it has a row in the
tables of bodies and does not move relative to itself. Rotations count from the structure as built, when the axes of
each body are those of the base.

As of a column there are five arrays: MODEL, STATE, COUNTS, BASE, and WORK, which may be discarded between calls. The
head of the model holds the sizes.
"""

import math
from typing import Any, NamedTuple

from ..engine.control import LIGHTLY_DAMPED
from ..numba_ext.jit import in_both, leaf
from ..numba_ext.lanes import LANES
from ..numba_ext.views import FieldTable, Numbers, Record, Space


class Sizes(NamedTuple):
    """The sizes of the tables in the arrays of a structure."""

    n: int  # blocks
    m: int  # joints
    k: int  # ties
    b: int  # of the joints, the last ones: bearings
    corners: int  # numbers of the corners of all sections
    ports: int
    pairs: int  # of neighbours
    bonds: int  # joints that bear tension or cohesion until they break
    cells: int  # numbers that the contact of bodies needs, 0 without pairs
    modal: int  # numbers of the modal data (modal_layout.py), 0 without modes
    modal_room: int  # numbers that steps by modes need
    state: int  # numbers of a state: the phase, what joints and ties remember, and what is left of bonds
    stride: int  # numbers from one state to the next in a step: whole packs
    visible: int  # numbers of an output row


HEAD = Record(*Sizes._fields, "is_plane")  # 1: the structure is its own mirror image in the plane x, z
SETTINGS = Record(
    "gravity",  # m/s2
    "tolerance",  # relative to the largest motion
    "step_tolerance",  # of a step
    "order",  # of the method, 5 or 8
    "first_step",  # s
    "extent",  # m, by which displacements become rotations of the whole
    "motion_floor",  # rad, least motion that errors are measured against
    "rate_floor",  # rad/s
    "in_plane",  # 1: the motion stays in the plane x, z by symmetry
    "watches",  # 1: peaks and errors of forces too, not of displacements alone
    "gives_way",  # 1: joints may slide or ties yield, what they give way by is integrated
    "has_modes",  # 1: steps by modes while all joints are in full contact
    "stabilizes",  # 1: stabilized steps where joints are stiff and heavily damped
    "relaxation",  # s: least damping along a joint that may slide; what a tie yields by follows its stretch so fast
    *("drive", "slope", "bodies"),  # as of a column (layout/spaces.py)
    "turns",  # 1: inputs and bodies may turn the base too
    "after_fall",  # s: the run goes on so long after the first fall, and joints that have come apart end
)
BODIES = FieldTable(
    *("mass", "per_mass"),  # kg, 1/kg
    *("jxx", "jyy", "jzz", "jxy", "jxz", "jyz"),  # kg m2, inertia about the centroid, along the axes as built
    *("ixx", "iyy", "izz", "ixy", "ixz", "iyz"),  # 1/(kg m2), its inverse
    *("x", "y", "z"),  # m, centroid as built
    "size",  # m, by which rotations become displacements
    "drop",  # m: a block this far below its place as built has fallen
    "reach",  # m, of the farthest corner from the centroid
)
POLYGON, ROUND, POINT = 0.0, 1.0, 2.0  # kinds of sections; a bearing is a point
JOINTS = FieldTable(
    *("upper", "lower"),  # numbers of the bodies A and B
    *("ax", "ay", "az", "bx", "by", "bz"),  # m, the centre of the joint from the centroids of A and B, as built
    *("e1x", "e1y", "e1z", "e2x", "e2y", "e2z", "e3x", "e3y", "e3z"),  # axes as built; e3 points from B to A
    *("stiffness", "damping"),  # N/m3, s
    *("shear", "twist", "shear_damping"),  # N/m, N m/rad, s
    *("friction", "dowel"),  # coefficient, infinite where nothing slides; N
    "section",  # POLYGON, ROUND or POINT
    *("area", "ixx", "iyy", "ixy"),  # m2; m4, integrals of x^2, y^2, x y about the centre, the centroid of what bears
    "reach",  # m, elastic slip that friction and dowel bear under the weight of one block; infinite without
    "arm",  # m, mean distance of the section from the centre
    *("outer", "inner"),  # m, radii of a round section
    *("first", "corners"),  # place and number of the corners of a polygon
    *("above", "below"),  # places of the faces of A and B among the corners, where it may slide
    *("rim_a", "rim_b"),  # m, distance of the nearest edge of either face from the centre; infinite if it never slides
    # of a bearing, whose displacement u, m, has two components along the joint
    "pendulum",  # 1/m: the force N u/R, by which it rises
    *("spring", "dashpot"),  # N/m, N s/m
    *("ring", "ring_stiffness", "ring_damping"),  # m, infinite without; N/m, s: a stiff ring from this |u| on
    "capacity",  # m: beyond this |u| what it bears has come off
    "holds",  # 1: it bears tension too
    "bond",  # number of its bond from 1, 0 without
    "inside",  # place among the corners, from 1, of what a rim leaves open (INSIDE), 0 where the whole section bears
    "pair",  # number from 1 of the pair that takes its place where it has ended, 0 without
)
# a face among the corners of all sections, followed by its own corners: their number, 0 if round; its centre from
# that of the joint, m; its radius, infinite if unbounded, and that of its bore, m
FACE = Record("corners", "x", "y", "outer", "inner")  # outer: of a polygon the radius of a circle about it
MOST_CORNERS = 100  # most corners of a face
# the inside of a section that bears in a rim only, about the centre of the joint: POLYGON or ROUND, number of corners,
# integrals of 1, x, y, x^2, y^2, x y, radii, indices of the insides of both faces; followed by its corners
INSIDE = Record("section", "corners", "area", "x", "y", "ixx", "iyy", "ixy", "outer", "inner", "above", "below")
# the intersection of two polygons, from half-way between their centres: number of corners, the slips and the twist at
# which it was computed, its integrals of 1, x, y, x^2, y^2, x y; then its corners, the last one repeated, the owner of
# the edge that ends at each, and for each edge of the lower and of the upper face the plane that is positive inside
SHARED = Record("corners", "p1", "p2", "p3", "area", "x", "y", "xx", "yy", "xy")
PER_CORNER = 4  # length of a row of SHARED over that of its two faces; its index is that multiple of theirs
assert SHARED.beside <= PER_CORNER * 2 * FACE.beside
OF_UPPER, OF_BOTH, OF_LOWER = -1.0, 0.0, 1.0  # owners of an edge; both if edges of two faces coincide
TIES = FieldTable(
    *("one", "other"),  # numbers of the bodies
    *("ax", "ay", "az", "bx", "by", "bz"),  # m, the ends from the centroids, as built
    *("stiffness", "damping"),  # N/m, N s/m
    "length",  # m, at which it begins to pull
    "tension_only",
    "yields_at",  # N, infinite where it does not
)
PORTS = FieldTable(
    "body",  # number of the block
    *("x", "y", "z"),  # m, the point from the centroid, as built
)
# a convex body among the corners of all sections: numbers of its planes and corners, half length, radius and axis of a
# drum whose core it is, its mean area, m2; the corners, m from the centroid; for each plane its normal, its distance,
# the first axis of its face, the place of the outline in this row and the number of its corners; the outlines,
# anticlockwise
SOLID = Record("planes", "corners", "half", "radius", "ux", "uy", "uz", "size")
SOLID_CORNERS, SOLID_PLANE, SOLID_PLANES = SOLID.beside, 9, 128  # place, numbers of a plane, most planes
CELL_CORNERS, PER_ROOF = 2 * (2 * MOST_CORNERS + 8), 4  # numbers of a polygon, and of a plane above it
CELLS = 4 * SOLID_PLANES + CELL_CORNERS + PER_ROOF * 2 * SOLID_PLANES  # room for a contact of two bodies (cells.py)
DRUMS, PLANE, CONVEX = 0.0, 1.0, 2.0  # kinds of pairs: sides of two drums, a drum and a plane face, neither
PAIRS = FieldTable(
    *("one", "other"),  # numbers of the bodies
    "kind",  # DRUMS, PLANE or CONVEX
    *("ax", "ay", "az"),  # m, middle of the axis of the first drum from its centroid, as built
    *("bx", "by", "bz"),  # m, that of the other drum, or the centre of the face
    *("ux", "uy", "uz"),  # axis of the first drum as built
    *("vx", "vy", "vz"),  # that of the other one, or the normal of the face
    *("e1x", "e1y", "e1z"),  # first axis of the face
    *("radius_a", "radius_b"),  # m; less what the sides are taken to be farther apart by
    *("half_a", "half_b"),  # m, half of the lengths of the drums
    *("first", "corners"),  # place and number of the corners of the face
    *("body_a", "body_b"),  # places of both bodies among the corners (SOLID)
    "farther",  # m, added to the distance of the bodies
    "joined",  # 1: the bodies have joints, and are a pair only after these have ended
    *("stiffness", "body_stiffness", "damping"),  # N/m2 of sides; N/m3 of each body, 0 where only sides press; s
    *("friction", "shear", "shear_damping"),  # coefficient, N/m, s
    "decay",  # s, in which its damping stops the lighter of two blocks
    "reach",  # m, of the spheres about both blocks together
)
BONDS = FieldTable(
    "joint",  # number of the joint, a polygon
    *("strength", "cohesion"),  # Pa: tension, and force along it beside friction, at which it breaks
)
PHASE = FieldTable(
    *("ux", "uy", "uz"),  # m, displacement of the centroid
    *("q0", "q1", "q2", "q3"),  # rotation from the place as built, a unit quaternion
    *("vx", "vy", "vz"),  # m/s
    *("wx", "wy", "wz"),  # rad/s, angular velocity in the axes of the body
    together={"displacement": ("ux", "uy", "uz"), "velocity": ("vx", "vy", "vz")},
)
# a state is a phase and a memory: slips and twist of the sliders of joints, m, m, rad; then the plastic stretch of
# each tie, m; then the stretches of pairs
MEMORY = FieldTable("p1", "p2", "p3")
# of each pair: elastic stretch of its friction, m, along the axes of the base; how it touches
STRETCH = FieldTable("z1", "z2", "z3", "touches")
# how a pair touches: not while joints join it; by the sides of drums too; by the bodies alone
JOINED, APART, BY_SIDES, BY_BODIES = -1.0, 0.0, 1.0, 2.0
JOINED_GAP = 1e6  # m, output while joints connect a pair
# the polygon of a bond, convex, followed by its corners. It shrinks between steps, and has no rate
BONDED = Record("corners")
MOST_BONDED = 128  # most corners of the polygon of a bond
MOST_CUT = 24  # most corners of a section with a bond: each end of a step may add a corner to this
CONTROL = Record(
    "next_step",  # s
    "previous_error",  # tolerances
    "largest",  # rad, motion so far
    "largest_rate",  # rad/s
    *("largest_normal", "largest_shear"),  # N, across and along joints, so far
    "decay",  # 1/s, at which the most damped motion of the joints dies out; 0 before the first explicit step
    "fall_time",  # s
    "released",  # J, change of the energy where joints have ended
    "reached",  # s
    "elastic_step",  # s, proposed for steps by modes
    "stabilized_step",  # s, proposed for stabilized steps (stabilized.py); 0 while steps of order 5 are made
)
COUNTS = Record(
    *("steps", "rejected", "evaluations", "looks", "fallen", "started", "next_row", "resting"),
    "left",  # number from 1 of the bearing that the fallen block had left when it fell; 0 if it was on none
    "elastic_steps",  # of steps
    "elastic_wait",  # steps to be made by other methods before modes are tried again
    "in_a_row",  # steps by modes since others were last tried
    "probing",  # 1 while others are tried
    "stabilized_steps",  # of steps
    "stabilized_wait",  # steps of order 5 that their stability bounds, to be made before stabilized ones are tried
    "stabilized_pause",  # such steps, from the first of them on
)
BASE = Record(
    *("amplitude_x", "amplitude_y"),  # m/s2, of the harmonic part
    *("omega", "phase"),  # rad/s, rad
    *("ax", "ay", "az"),  # m/s2, at time t0: inputs beside the samples
    *("jx", "jy", "jz"),  # m/s3, their slopes
    "t0",  # s
    *("coupled", "steps"),  # as of a column, of exchanges before this one
    *("last_step", "last_ax", "last_ay", "last_az"),
    *("before_step", "before_ax", "before_ay", "before_az"),
    *("theta_x", "theta_y", "omega_x", "omega_y"),  # rad, rad/s, rotation at time t0
    *("alpha_x", "alpha_y", "jalpha_x", "jalpha_y"),  # rad/s2, rad/s3
    *("last_alpha_x", "last_alpha_y", "before_alpha_x", "before_alpha_y"),
    *("x", "y", "z", "vx", "vy", "vz"),  # m, m/s, at time t0: how far the base has moved since bodies drive it
    *("mass", "checked_step", "checked_mass", "allowed_step"),  # kg, s, kg, s: as of a column
)
# motion of a base that bodies may drive: m, m/s, m/s2; then, if it may rotate: rad, rad/s, rad/s2
DRIVEN = Record("x", "y", "z", "vx", "vy", "vz", "ax", "ay", "az")
DRIVEN_TURN = Record("theta_x", "theta_y", "omega_x", "omega_y", "alpha_x", "alpha_y")
LOAD = ("fx", "fy", "fz", "mx", "my", "mz")  # N, N m, along the axes of the base, at a port
# follows BASE: inputs at the ports at time t0, and their slopes, N/s, N m/s
INPUT_LOADS = FieldTable(*LOAD, *(f"d{name}" for name in LOAD))
# tables of an evaluation
PUSHES = FieldTable(*LOAD)  # zero outside of runs and outputs, unless a caller sets them
SPOTS = FieldTable(*("x", "y", "z", "vx", "vy", "vz", "ax", "ay", "az"))  # m, m/s, m/s2, of ports relative to the base
# rotation of the base: 1 if there is one; its quaternion, whose last number is 0; along its axes angular velocity,
# rad/s, angular acceleration, rad/s2, and the change of base acceleration and gravity by the rotation, m/s2
TURN = Record("turned", "q0", "q1", "q2", "wx", "wy", "wz", "bx", "by", "bz", "gx", "gy", "gz")
POSES = FieldTable(  # of n + 1 bodies
    *("r11", "r12", "r13", "r21", "r22", "r23", "r31", "r32", "r33"),  # rotation less the identity
    *("wx", "wy", "wz"),  # rad/s, along the axes of the base
    *("fx", "fy", "fz", "mx", "my", "mz"),  # N, N m about the centroid, along the axes of the base
    "way",  # m, more than any point has moved, if there are pairs
    "farthest",  # m, peak of the horizontal displacement of a run that is not in lanes
)
RESULTANTS = FieldTable(  # of m joints, along the axes of the joint
    *("normal", "g1", "g2", "g3"),  # N, N m: derivatives of the energy by the relative rotation
    *("t1", "t2"),  # N, on the upper block
    *("area", "pressure"),  # m2 loaded, Pa largest
    *("s1", "s2", "s3"),  # m, m, rad: slips and twist
    *("z1", "z2", "z3"),  # their elastic parts
)
SOUND = FieldTable(  # of bonds
    *("area", "margin"),  # of an evaluation: m2; the part of what it bears along the joint that is left
    "held",  # 1 while it is as it was at the start of a step
    *("begins", "ends"),  # how far it is from breaking at both ends of a step (cracking.py)
)
# of pairs: force, N; energy, J; 1 while friction slides, and 1 if it did at the start of the step; FIRST; how the pair
# touches while it has forces; height of the highest cell between the bodies, m; the last gap and the ways of both
# bodies until then, m; the direction of their last distance. FIRST: 1 once the pair has begun to touch in a run; when,
# s; the rate of its gap then, m/s
FIRST = ("met", "first", "closing")
HITS = FieldTable("force", "energy", "slides", "slid", *FIRST, "bears", "highest", "clear", "nx", "ny", "nz")
PULLS = FieldTable("force", "stretch", "elastic")  # of k ties: N, m; the elastic part of the stretch
STAGES = 13  # of a step of order 8, with its start and its end

# --- an output row
OF_BLOCK = ("ux", "uy", "uz", "rx", "ry", "rz")
OF_JOINT = ("N", "Mx", "My", "Tx", "Ty", "Mz", "contact", "sigma_max", "slip")
OF_BEARING = ("dx", "dy", "d")
OF_BOND = ("bond",)
OF_PAIR = ("gap", "hit")
OF_PORT = SPOTS.fields
OF_BASE = ("Fx", "Fy", "Fz", "Mx", "My", "Mz")  # N, N m; behind them outputs of the whole

# codes
OK, STEP_TOO_SMALL = 0, -1
KEEP, PRESUME = 1, 2  # what an observation does with the memory (entries.observe_structure)
PAUSED = 1  # the allowed number of steps has been made; not an error
PACK = 8  # numbers in a pack, the unit of sums


# Errors decay with the motion of the joints. In undamped joints they add up: a step may add this fraction of the
# tolerance, which changes the energy by less than 1e-2 of the tolerance per second (docs/notes/structures.md)
RINGING_PART = 1e-6
LEAST_TOLERANCE = 1e-15  # of a step; below it errors are those of rounding
RINGING_ORDER = 8.0  # order of the method for undamped joints
FIRST_STEP = 0.1  # of 1 / omega of the fastest joint


@in_both
def order_of(damping: float, first_step: float) -> float:
    """Return the order of the method for the most damped joint (s) and a first step (s)."""
    return RINGING_ORDER if 0.5 * damping * FIRST_STEP / first_step < LIGHTLY_DAMPED else 5.0


@in_both
def shear_damping_of(damping: float, friction: float, relaxation: float) -> float:
    """Return the shear damping of a joint (s): at least `relaxation` if it may slide, with a finite friction."""
    return max(damping, relaxation) if friction != math.inf else damping


@in_both
def step_tolerance(order: float, tolerance: float) -> float:
    """Return the tolerance of a step of the method of this order."""
    return max(LEAST_TOLERANCE, RINGING_PART * tolerance) if order == RINGING_ORDER else tolerance


PROMISE = 0.1  # of the tolerance: a smaller predicted rise of a peak, of its size, is not looked for
LEAST_STABILIZED = 2e-5  # least tolerance of stabilized steps: below it accuracy bounds steps of order 2


@in_both
def stabilizes(order: float, tolerance: float) -> float:
    """Return 1 if stabilized steps may be faster than this method at this tolerance, else 0."""
    return 1.0 if order != RINGING_ORDER and tolerance >= LEAST_STABILIZED else 0.0


# --- the arrays
# coordinates of a polygon and of the result of a cut: for two faces and a square, cut by two pressures
ROOM = 2 * 2 * (2 * MOST_CORNERS + 4)
NO_ROOM = ROOM  # index of the number of cuts that needed more corners than there is room for
SEEN = 5  # output rows of a step: start, middle, end, a trial; allowed rises of peaks
EACH, OF_POLYGON = Numbers(1), Numbers(BONDED.beside + 2 * MOST_BONDED)
_SIZES = Sizes._fields
REMEMBERED = Space(*_SIZES, slips=(MEMORY, "m"), plastic=(EACH, "k"), stretches=(STRETCH, "pairs"))
MODEL = Space(
    *_SIZES,
    head=HEAD,
    settings=SETTINGS,
    bodies=(BODIES, "n", 1),
    joints=(JOINTS, "m"),
    ties=(TIES, "k"),
    corners=(EACH, "corners"),
    ports=(PORTS, "ports"),
    pairs=(PAIRS, "pairs"),
    bonds=(BONDS, "bonds"),
    modal=(EACH, "modal"),
)
STATE = Space(
    *_SIZES,
    control=CONTROL,
    phase=(PHASE, "n"),
    remembered=REMEMBERED,
    bonded=(OF_POLYGON, "bonds"),
    peaks=(EACH, "visible"),
)
INPUT_MOTION = Space(*_SIZES, motion=BASE, loads=(INPUT_LOADS, "ports"))  # the array BASE
WORK = Space(
    *_SIZES,
    states=(Numbers(STAGES + 5), "stride"),  # and rates of a step
    outputs=(Numbers(SEEN), "visible"),
    poses=(POSES, "n", 1),
    resultants=(RESULTANTS, "m"),
    pulls=(PULLS, "k"),
    pushes=(PUSHES, "ports"),
    spots=(SPOTS, "ports"),
    hits=(HITS, "pairs"),
    sound=(SOUND, "bonds"),
    turn=TURN,
    memory=REMEMBERED,
    giving=REMEMBERED,
    room=Numbers(beside=ROOM + 1),
    cells=(EACH, "cells"),
    shared=(Numbers(PER_CORNER), "corners"),
    modal_room=(EACH, "modal_room"),
)


def sizes_of(
    n: int,
    m: int,
    k: int,
    b: int,
    corners: int,
    ports: int = 0,
    pairs: int = 0,
    bonds: int = 0,
    modal: int = 0,
    modal_room: int = 0,
) -> Sizes:
    """Return the sizes of the arrays of a structure.

    Parameters
    ----------
    n, m, k : int
        Numbers of blocks, joints and ties.
    b : int
        Number of bearings, which are the last joints.
    corners : int
        Numbers that the corners of all sections need.
    ports, pairs, bonds : int
        Numbers of ports, of pairs of neighbours and of bonds.
    modal, modal_room : int
        Lengths of the modal data and of the room for steps by modes.
    """
    # phase, memory and bonds
    state = PHASE.size(n) + MEMORY.size(m) + k + STRETCH.size(pairs) + OF_POLYGON.size(bonds)
    # an output row
    row = len(OF_BLOCK) * n + len(OF_JOINT) * m + k + len(OF_BASE)
    row += len(OF_BEARING) * b + len(OF_BOND) * bonds + len(OF_PAIR) * pairs + len(OF_PORT) * ports
    # whole packs
    stride = (state + PACK - 1) // PACK * PACK
    return Sizes(n, m, k, b, corners, ports, pairs, bonds, CELLS if pairs else 0, modal, modal_room, state, stride, row)


_PER_BODY, _BONDED = PHASE.per_n, OF_POLYGON.size(1)


@in_both
def place_of_bonds(sizes: Any) -> int:
    """Return the offset of the bond polygons in a state."""
    found: int = sizes.state - _BONDED * sizes.bonds
    return found


@in_both
def remembered(sizes: Any) -> int:
    """Return the length of the memory of joints, ties and pairs, between phase and bonds of a state."""
    found: int = place_of_bonds(sizes) - _PER_BODY * sizes.n
    return found


class Extras(NamedTuple):
    """The tables of features that only some structures have (extras.py)."""

    b: int  # bearings, the last joints
    spotted: int  # ports
    ports: object
    pushes: object  # on ports
    spots: object  # motion of ports
    met: int  # pairs of neighbours
    pairs: object
    hits: object  # what they bear
    stretches: object  # what they remember, of the state that is evaluated
    giving_stretches: object  # the rates of it
    glued: int  # bonds
    bonds: object
    bonded: object  # row, what is left of them
    sound: object  # of the evaluation
    turn: object  # of the base
    inputs: object  # row, INPUT_LOADS at time t0 of `base`


class KernelScene(NamedTuple):
    """A structure as the kernels see it: sizes, parameters, and room for an evaluation."""

    n: int
    m: int
    k: int
    stride: int  # numbers from one state of a step to the next
    visible: int  # numbers of an output row
    settings: object
    bodies: object
    joints: object
    ties: object
    corners: object
    modal: object  # row (modal_layout.py), empty without modes
    control: object
    counts: object
    peaks: object
    poses: object
    resultants: object
    pulls: object
    remembered: int  # numbers that joints, ties and pairs remember
    memory: object  # those of the state that is evaluated
    slips: object  # of it the part of the joints
    plastic: object  # and of the ties
    giving: object  # the rate of the memory
    giving_slips: object
    giving_plastic: object
    room: object  # of polygons
    cells: object  # of the contact of bodies (cells.py)
    shared: object  # by faces of joints that have slid
    states: object  # and rates of a step
    outputs: object  # output rows of a step
    modal_room: object  # row, for modes; not there in lanes
    base: object  # BASE
    samples: object  # of the record (engine/samples.py)
    extras: object  # Extras


def acts_alone(scene: Any, *_: Any) -> bool:
    """Return True if the scene is of one structure, not of lanes: selects the version of a varied kernel.

    In lanes nothing but the base acceleration acts.
    """
    acts: bool = scene.types[scene.fields.index("memory")].kind is not LANES
    return acts


_head, _model, _state, _counts = HEAD.over, MODEL.over, STATE.over, COUNTS.over
_input, _work = INPUT_MOTION.over, WORK.over


@leaf
def sizes_in(model):
    """Return the sizes at the head of a model."""
    head = _head(model, 0)
    shape = int(head.n), int(head.m), int(head.k), int(head.b), int(head.corners)
    beside = int(head.ports), int(head.pairs), int(head.bonds), int(head.cells), int(head.modal), int(head.modal_room)
    return Sizes(*shape, *beside, int(head.state), int(head.stride), int(head.visible))


@leaf
def scene_of(model, state, counts, base, samples, work):
    """Return the scene of the structure with these arrays, under the samples of a record."""
    sizes = sizes_in(model)
    lasting, counted, seen = _state(state, sizes), _counts(counts, 0), _work(work, sizes)
    moves, of_state = _input(base, sizes), (lasting.control, counted, lasting.peaks, lasting.bonded)
    return scene_over(sizes, _model(model, sizes), *of_state, moves.motion, moves.loads.row, samples, seen)


@leaf
def scene_over(sizes, model, control, counts, peaks, bonded, base, inputs, samples, work):
    """Return the scene of MODEL and WORK, of control, counts, peaks, the row of bond polygons, and the base motion."""
    # tables of extras
    extras = Extras(
        sizes.b,
        sizes.ports,
        model.ports,
        work.pushes,
        work.spots,
        sizes.pairs,
        model.pairs,
        work.hits,
        work.memory.stretches,
        work.giving.stretches,
        sizes.bonds,
        model.bonds,
        bonded,
        work.sound,
        work.turn,
        inputs,
    )
    # parameters, memory and room
    return KernelScene(
        sizes.n,
        sizes.m,
        sizes.k,
        sizes.stride,
        sizes.visible,
        model.settings,
        model.bodies,
        model.joints,
        model.ties,
        model.corners,
        model.modal,
        control,
        counts,
        peaks,
        work.poses,
        work.resultants,
        work.pulls,
        remembered(sizes),
        work.memory.row,
        work.memory.slips,
        work.memory.plastic,
        work.giving.row,
        work.giving.slips,
        work.giving.plastic,
        work.room,
        work.cells,
        work.shared,
        work.states,
        work.outputs,
        work.modal_room,
        base,
        samples,
        extras,
    )
