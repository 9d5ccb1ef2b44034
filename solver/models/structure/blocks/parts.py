"""The parts of a structure in space: blocks, joints between two faces, ties. All lengths and positions are as built."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from ....common.errors import InputError
from .faces import Face, FloatArray
from .polyhedra import Polyhedron

TOLERANCE = 1e-5  # default
# what can be left out: peaks other than those of displacements, steps by modes, stabilized steps
SKIPS = ("peaks", "elastic", "stabilized")
LEVEL = 1e-6  # sine of the angle below which a face is level, or upright
BASE = "base"  # name of the body that everything stands on
OF_COLUMN = "column"  # key of the mapping of a column's file, of a structure that is a stack of a column
BESIDE_COLUMN = ("port", "neighbours")  # the other keys that such a structure may have


@dataclass(frozen=True, eq=False)
class Solid:
    """A rigid block as built, along the axes of the base."""

    name: str
    mass: float  # kg
    centroid: FloatArray  # (3,) m
    inertia: FloatArray  # (3, 3) kg m2 about the centroid
    faces: tuple[Face, ...]  # plane ones, by which it may touch others
    axes: FloatArray = field(default_factory=lambda: np.eye(3))  # (3, 3), its own axes by columns
    volume: float = math.nan  # m3
    surface: FloatArray = field(default_factory=lambda: np.empty((0, 3, 3)))  # m, triangles to draw it by; else faces
    parts: tuple[tuple[Face, ...], ...] = ()  # of one that is not convex: all faces of its convex parts, also of cuts
    hull: tuple[Face, ...] = ()  # all faces of the hull of a block whose feet do not cover its underside

    @property
    def size(self) -> float:
        """The radius of gyration (m): it converts rotations to displacements."""
        return math.sqrt(float(np.trace(self.inertia)) / (2.0 * self.mass))

    @property
    def corners(self) -> FloatArray:
        """The corners of all faces, (points, 3) m."""
        return np.concatenate([face.points() for face in self.faces])

    @cached_property
    def reach(self) -> float:
        """The distance of the farthest corner from the centroid (m)."""
        return float(np.max(np.linalg.norm(self.corners - self.centroid, axis=1)))

    @property
    def drop(self) -> float:
        """The half of the least extent along its own axes and normal to its faces (m).

        A block that is lower than built by this has fallen.
        """
        along = np.column_stack([self.axes, *(face.normal for face in self.faces)])
        return 0.5 * float(np.min(np.ptp(self.corners @ along, axis=0)))


@dataclass(frozen=True)
class JointLaw:
    """The law of a joint: no tension across, elastic along itself up to Coulomb's limit (theory.md section 13)."""

    stiffness: float  # N/m3, Winkler modulus
    damping: float  # s
    shear_ratio: float = 0.4  # of the modulus along the joint
    shear_damping: float | None = None  # s; None: as damping
    friction: float | None = None  # Coulomb's coefficient; None: the joint never slides
    dowel: float = 0.0  # N, borne in addition to friction
    strength: float | None = None  # Pa, compressive strength of the faces; used by checks only, not by the motion
    tensile_strength: float = 0.0  # Pa, tension that it bears until it breaks (theory.md section 18)
    cohesion: float = 0.0  # Pa, borne in addition to friction by the unbroken area
    rim: float | None = None  # m, width of the band along the edges in which faces touch; None: all over

    @property
    def is_bonded(self) -> bool:
        """True if the joint bears tension or cohesion until it breaks."""
        return self.tensile_strength > 0.0 or self.cohesion > 0.0


@dataclass(frozen=True)
class Bearing:
    """The law of a bearing by its displacement u, added to that of a joint at a point (theory.md section 13).

    The horizontal force is the sum of N u `pendulum`, `spring` u, `dashpot` u' and the force of the ring. The bed of
    the joint adds the rest: `stiffness` times the area across, and `shear_ratio` of it along until friction or the
    dowel yields.
    """

    kind: str
    pendulum: float = 0.0  # 1/m, over the radius of curvature
    spring: float = 0.0  # N/m
    dashpot: float = 0.0  # N s/m
    ring: float = math.inf  # m, displacement at which a stiff ring begins to push back
    ring_stiffness: float = 0.0  # N/m
    ring_damping: float = 0.0  # s
    capacity: float = math.inf  # m, displacement beyond which the block above has come off
    holds: bool = False  # bears tension


@dataclass(frozen=True, eq=False)
class SpatialJoint:
    """A contact between two blocks, or a block and the base; the face's normal points from `lower` to `upper`."""

    upper: int  # number of the block, from 0
    lower: int  # the base is the number after the last block's
    face: Face  # centred at its centroid
    bed: JointLaw
    key: str = ""  # of the table it is from, for messages
    above: Face | None = None  # faces of `upper` and `lower`, which bound the contact after a slip; None: `face`
    below: Face | None = None
    bearing: Bearing | None = None  # acts at the centre of `face`, which has the size of the bearing
    inside: Face | None = None  # area of `face` that a rim leaves open, about the same centre

    def is_listed_downwards(self, base: int) -> bool:
        """Return True if `lower` is a block that stands on `upper`: a file may name the two in either order."""
        return bool(self.face.normal[2] < -LEVEL) and self.lower != base

    def carried(self, base: int) -> int:
        """Return the number of the block above; base: that of the base."""
        return self.lower if self.is_listed_downwards(base) else self.upper

    def carrier(self, base: int) -> int:
        """Return the number of the body below."""
        return self.upper if self.is_listed_downwards(base) else self.lower

    @cached_property
    def moments(self) -> tuple[float, float, float, float]:
        """The bearing area (m2), and its integrals of x^2, y^2 and x y about the centre (m4)."""
        found = self.face.moments
        if self.inside is None:
            return found
        a, b = found, self.inside.moments
        return a[0] - b[0], a[1] - b[1], a[2] - b[2], a[3] - b[3]

    @property
    def arm(self) -> float:
        """The mean distance of the bearing area from the centre (m): the arm of friction against twisting."""
        if self.inside is None or not self.inside.moments[0]:
            return self.face.arm
        inside = self.inside.arm * self.inside.moments[0]
        return (self.face.arm * self.face.moments[0] - inside) / self.moments[0]


@dataclass(frozen=True, eq=False)
class Side:
    """The cylindrical side of a drum."""

    middle: FloatArray  # (3,) m, of its axis
    axis: FloatArray  # (3,) unit vector
    half: float  # m, half of its length
    radius: float  # m


@dataclass(frozen=True, eq=False)
class Pair:
    """Two convex bodies without a joint, and the law of their contact (theory.md section 17)."""

    one: int  # number of the block, from 0
    other: int  # of another one, or of the base
    bodies: tuple[Polyhedron, Polyhedron]
    gap: float  # m, between both as built
    size: float  # m of sides, or m2, over which they face each other as built, or the mean area of the smaller one
    side: Side | None = None  # of the first block, a drum
    beside: Side | Face | None = None  # what that side is before; the face of a wall
    faces: bool = True  # sides of both face each other as built
    presses: bool = True  # False: only the side does, the bodies press on each other in another pair
    farther: float = 0.0  # m, added to the distance of a drum
    shift: float = 0.0  # m, by which the first body is moved to its gap, if that is not the one as built
    stiffness: float = 0.0  # N/m2 of sides, else N/m3
    body_stiffness: float = 0.0  # N/m3
    damping: float = 0.0  # s
    friction: float = 0.0
    shear: float = 0.0  # N/m, stiffness along the contact
    wall: int = 0  # number of the wall, from 1, where the other one is the base
    joined: bool = False  # they meet only after a fall, once all joints between both have ended

    @property
    def beyond(self) -> float:
        """The length by which its contact may reach beyond the blocks, m, where a gap is declared."""
        return self.shift + max(0.0, -self.farther)


@dataclass(frozen=True, eq=False)
class Tie:
    """A rod, clamp, tendon or damper between points of two blocks, or of a block and the base."""

    one: int
    other: int
    from_: FloatArray  # (3,) m, along the axes of the base, from the centroid of its block; of the base from its origin
    to: FloatArray
    stiffness: float  # N/m
    damping: float = 0.0  # N s/m
    slack: float = 0.0  # m, by which it may lengthen before it pulls; none of a tie that also pushes
    pretension: float = 0.0  # N, as built
    tension_only: bool = True
    yield_: float | None = None  # N; None: it does not yield

    def check(self, key: str) -> None:
        """Raise InputError for values that exclude each other."""
        if self.slack > 0.0 and self.pretension > 0.0:
            raise InputError(f"{key}.slack = {self.slack}: must be 0 beside a pretension")
        if self.slack > 0.0 and not self.tension_only:
            raise InputError(
                f"{key}.slack = {self.slack}: must be 0 beside tension_only = false, a tie that also pushes"
            )
        if self.yield_ is not None and self.pretension > self.yield_:
            raise InputError(f"{key}.pretension = {self.pretension}: must not exceed yield = {self.yield_} N")


def trees_of(n: int, links: Sequence[tuple[int, int]]) -> list[dict[int, int]]:
    """Return spanning trees of n blocks and the base, breadth first, the first one from the base.

    Each has the link by which it reaches each of its bodies; -1 of its root.
    """
    at_body: list[list[int]] = [[] for _ in range(n + 1)]
    for number, (one, other) in enumerate(links):
        at_body[one].append(number)
        at_body[other].append(number)
    found: list[dict[int, int]] = []
    for root in range(n, -1, -1):
        if any(root in tree for tree in found):
            continue
        by, reached = {root: -1}, [root]
        for body in reached:
            for number in at_body[body]:
                for end in links[number]:
                    if end not in by:
                        by[end] = number
                        reached.append(end)
        found.append(by)
    return found
