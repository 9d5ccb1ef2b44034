"""A column as a chain of rigid bodies in NumPy: positions of its blocks, and their energy (theory.md section 4).

A phase has the coordinates and rates of the stepper, (4 n,) or (rows, 4 n). A column whose joints may slide adds slips
and their rates, (6 n,) or (rows, 6 n); one that has brittle joints also the ends of the bonds, 8 n numbers in all.

Vectors in the plane are complex numbers: up is the real part, +x the imaginary one, so that exp(i theta) is a unit
vector that points up, rotated clockwise by theta.
"""

from __future__ import annotations

from copy import copy
from functools import cached_property, lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...kernels.column.api.entries import joint_energies, joint_potentials, rings_beyond
from ...kernels.column.sections.faces import RECTANGLE
from ...kernels.layout import spaces as at
from .model import Column
from .packing import FloatArray, IntArray, arrays_of, pack_model, settlements

PARALLEL = 1e-30  # rad: faces are parallel if the slope is smaller


_OF_BLOCKS = (  # fields of the packed model; the last four describe the column as built, 0 on the axis
    *("height", "centroid", "mass", "inertia", "width", "stiffness", "bore", "fall_angle"),
    *("lean", "tilt", "offset", "built_x"),
)
# ends of the contacts as built, those of the faces above and below
_ENDS = ("left", "right", "own_left", "own_right", "rim_left", "rim_right")


class ColumnPhase(NamedTuple):
    """The rotations (rad) of blocks, openings and slips (m) of the joints under them, and their rates, (..., n).

    bond_left and bond_right are the ends of the bonds (m from the middle of the block); a bond with left >= right is
    broken.
    """

    theta: FloatArray
    opening: FloatArray
    spin: FloatArray
    opening_rate: FloatArray
    slip: FloatArray | float = 0.0
    slip_rate: FloatArray | float = 0.0
    bond_left: FloatArray | float = 0.0
    bond_right: FloatArray | float = 0.0


class Joints(NamedTuple):
    """The joints in the plane, (..., n) each."""

    half_turn: FloatArray  # rad, half the rotation of the block relative to the body below
    normal: NDArray[np.complex128]  # unit normals
    step: NDArray[np.complex128]  # m, from the lower face to the upper


class Chain:
    """The data of a column as arrays of n numbers, the top block first."""

    safe = 0.97  # of a barrier: the largest energy of a column that stands for certain (verdict.py)
    rectangles: NDArray[np.bool_]
    rest: FloatArray | None = None  # phase at rest; its energy is subtracted
    reach: FloatArray | None = None  # m, stretch at which a brittle joint breaks

    def __init__(self, column: Column) -> None:
        self._read(pack_model(column), column.n)
        self.rectangles = self.rectangles & (not column.other_law)
        self.settled = settlements(column)
        if column.is_brittle:
            self.reach = np.array([law.tensile_strength / law.stiffness for law in column.laws])
        self.off_axis = column.off_axis
        if self.off_axis or column.other_law:
            rest, zeros = at.STATE.see(arrays_of(column).state, column.n).phase, np.zeros(self.n)
            bonds = (rest.bond_left, rest.bond_right) if column.is_brittle else ()
            self.rest = np.concatenate([rest.theta, rest.opening, zeros, zeros, rest.slip, zeros, *bonds])

    @classmethod
    def of_many(cls, models: FloatArray, n: int) -> Chain:
        """Return the data of many columns of n blocks, none with slips, as arrays (columns, n).

        `models` are packed (packing.py), a row for each column; no joint is made of strips.
        """
        chain = cls.__new__(cls)
        chain._read(models, n)
        chain.settled = chain.weight / chain.spring
        chain.off_axis = False
        return chain

    def _read(self, models: FloatArray, n: int) -> None:
        seen = at.MODEL.see(models.T, n)
        settings, blocks = seen.settings, seen.blocks
        self.model, self.n = models, n
        self.g: FloatArray = np.array(settings.gravity)[..., None]  # m/s2
        rows: list[FloatArray] = [getattr(blocks, name).T.copy() for name in _OF_BLOCKS]
        self.height, self.centroid, self.mass, self.inertia, self.width, self.stiffness, self.bore, *others = rows
        self.fall_angle, self.lean, self.tilt, self.offset, self.built_x = others
        self.ends = np.stack([getattr(blocks, name).T for name in _ENDS], axis=-2)  # m, (..., 6, n)
        # with the linear law the energy of these has the closed form below
        self.rectangles = blocks.section.T == RECTANGLE
        self.rigidity = self.stiffness * blocks.depth.T  # N/m2: per metre of the joint's width, if it is a rectangle
        ring = 0.25 * np.pi * (self.width**2 - self.bore**2)
        # N/m, in full contact
        self.spring = np.where(self.rectangles, self.rigidity * self.width, self.stiffness * ring)
        self.carried = np.cumsum(self.mass, axis=-1)  # kg, on the joint under each block
        self.weight = self.g * self.carried  # N

    def some(self, which: IntArray) -> Chain:
        """Return the data of the columns with the indices `which`."""
        chain = copy(self)
        chain.__dict__.pop("toppling", None)
        for name, values in vars(chain).items():
            if isinstance(values, np.ndarray):
                setattr(chain, name, values[which])
        return chain

    def places(self, phase: FloatArray) -> ColumnPhase:
        """Split a phase into rotations, openings, slips and their rates."""
        n = self.n
        return ColumnPhase(*(phase[..., k : k + n] for k in range(0, phase.shape[-1], n)))

    @staticmethod
    def coordinates(height: FloatArray, theta: FloatArray, opening: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the coordinates of a phase, or their rates, from rotations and openings, or their rates."""
        return theta, opening

    def top_displacements(self, phase: FloatArray) -> FloatArray:
        """Return the horizontal displacements of the top faces relative to the base and from as built, m (..., n)."""
        theta, opening, _, _, slip, *_ = self.places(phase)
        mean = theta - 0.5 * over_below(theta) + self.lean
        steps = opening * np.sin(mean) + slip * np.cos(mean) + self.height * np.sin(theta + self.tilt)
        return from_base(steps) - self.built_x

    def centroid_displacements(self, phase: FloatArray) -> FloatArray:
        """Return the horizontal displacements of the centroids relative to the base and from as built, m (..., n)."""
        turned = np.sin(self.places(phase).theta + self.tilt) - np.sin(self.tilt)
        return self.top_displacements(phase) - (self.height - self.centroid) * turned

    def top_velocities(self, phase: FloatArray) -> FloatArray:
        """Return the rates of `top_displacements`, m/s (..., n)."""
        places = self.places(phase)
        return self._tops(places, self.joints(places)).imag

    def gaps(self, phase: FloatArray) -> FloatArray:
        """Return the largest gap of each joint, at an edge of its contact, m (..., n); 0 in full contact."""
        places = self.places(phase)
        slope, slip = 2.0 * np.sin(self.joints(places).half_turn), places.slip
        # the ends of the contact from the middle of the block: after a slip the face below cuts it off elsewhere
        left, right, own_left, own_right, below_left, below_right = np.moveaxis(self.ends, -2, 0)
        left = np.where(slip == 0.0, left, np.maximum(own_left, below_left - slip))
        right = np.where(slip == 0.0, right, np.minimum(own_right, below_right - slip))
        deepest = np.minimum((left + 0.5 * slip) * slope, (right + 0.5 * slip) * slope)
        return np.maximum(places.opening - deepest, 0.0)

    def energy(self, phase: FloatArray) -> float:
        """Return kinetic, elastic and gravitational energy of one phase above that of the rest under gravity (J)."""
        return float(self.energies(phase))

    def energies(self, phase: FloatArray) -> FloatArray:
        """Return the `energy` of several phases, one in each row."""
        found = self._energies(phase)
        return found if self.rest is None else found - self._energies(self.rest)

    def _energies(self, phase: FloatArray) -> FloatArray:
        """Return energies above the straight column under its weight; of other columns above a fixed reference."""
        places = self.places(phase)
        theta, opening, spin, _, slip, *_ = places
        joints = self.joints(places)
        velocity = self.velocities(places, joints)
        moving = self.mass * (velocity.real**2 + velocity.imag**2) + self.inertia * spin**2
        slope = 2.0 * np.sin(joints.half_turn)
        strained = self.elastic(opening - 0.5 * slip * slope, slope, slip)
        if self.reach is not None:
            strained = strained + self._pulled(opening - 0.5 * slip * slope, slope, places)
        lifted = joints.step.real + 0.5 * self.settled  # rise; the half accounts for the joints' energy at rest
        half = 0.5 * theta
        dip = -2.0 * np.sin(self.tilt + half) * np.sin(half)  # cosine of the rotation less that as built
        energy = 0.5 * moving + strained + self.weight * lifted + self.toppling * dip
        return energy.sum(axis=-1)

    def _pulled(self, opening: FloatArray, slope: FloatArray, places: ColumnPhase) -> FloatArray:
        """Return the elastic energy of bonds in tension (J) beside that in compression; of rectangles."""
        reach = np.zeros(self.n) if self.reach is None else self.reach
        steep, rises = np.maximum(np.abs(slope), PARALLEL), slope >= 0.0
        left, right = np.asarray(places.bond_left), np.asarray(places.bond_right)
        # the stretch falls from one end of the bond, where it breaks at the reach, to the other
        near = np.maximum(np.where(rises, left, -right), (opening - reach) / steep)
        far = np.minimum(np.where(rises, right, -left), opening / steep)
        first, last = opening - steep * near, opening - steep * far
        found: FloatArray = self.rigidity * (far - near) * (first * first + first * last + last * last) / 6.0
        return np.where((far > near) & (left < right), found, 0.0)

    def joints(self, places: ColumnPhase) -> Joints:
        """Compute the joints in the plane."""
        half_turn = 0.5 * over_below(places.theta)
        normal = np.exp(1j * (places.theta - half_turn + self.lean))
        return Joints(half_turn, normal, (places.opening + 1j * places.slip) * normal)

    def velocities(self, places: ColumnPhase, joints: Joints) -> NDArray[np.complex128]:
        """Return the velocities of the centroids, m/s (..., n)."""
        return self._tops(places, joints) - (self.height - self.centroid) * self._turning(places)

    def _tops(self, places: ColumnPhase, joints: Joints) -> NDArray[np.complex128]:
        """Return the velocities of the centres of the top faces, m/s (..., n)."""
        spin, rates = places.spin, places.opening_rate + 1j * places.slip_rate
        mean_spin = spin - 0.5 * over_below(spin)
        steps = rates * joints.normal + 1j * mean_spin * joints.step + self.height * self._turning(places)
        return from_base(steps)

    def _turning(self, places: ColumnPhase) -> NDArray[np.complex128]:
        """Return the rate of the end of a unit length along each block, 1/s (..., n)."""
        return 1j * places.spin * np.exp(1j * (places.theta + self.tilt))

    def elastic(self, opening: FloatArray, slope: FloatArray, slip: FloatArray | float = 0.0) -> FloatArray:
        """Return the elastic energy of each joint (J), (..., n).

        It follows from the opening in the middle (m), the slope between the faces (rad) and the slip (m).
        """
        steep = np.abs(slope)
        deepest = 0.5 * self.width * steep - opening
        length = np.minimum(self.width, np.maximum(deepest, 0.0) / np.maximum(steep, PARALLEL))  # length in contact
        bent = steep * length
        # half the square of the penetration, integrated over the length
        found: FloatArray = 0.5 * self.rigidity * length * (deepest * (deepest - bent) + bent**2 / 3.0)
        # other sections and slipped joints
        simple = self.rectangles & (slip == 0.0)
        if not simple.all():
            others = np.zeros((opening.size // self.n, self.n))
            slipped = slip + np.zeros(opening.shape)
            rows = (np.ascontiguousarray(values).reshape(-1, self.n) for values in (opening, slope, slipped))
            models = self.model if self.model.ndim > 1 else [self.model] * len(others)
            for model, each_opening, each_slope, each_slip, row in zip(models, *rows, others, strict=True):
                joint_potentials(self.n, model, each_opening, each_slope, each_slip, row)
            found = np.where(simple, found, others.reshape(opening.shape))
        return found

    def joint_energy(self, i: int, turn: FloatArray, turn_below: FloatArray) -> FloatArray:
        """Return the least energy above rest (J) of joint i and the weight it carries at given rotations.

        It includes the rise of that weight by the opening; the opening minimizes the energy. `turn` and `turn_below`
        are the rotations (rad) of the two bodies: grids of two axes, or one value for each of many columns.
        """
        return self.bent_energy(i, 2.0 * np.abs(np.sin(0.5 * (turn - turn_below))), np.cos(0.5 * (turn + turn_below)))

    def bent_energy(self, i: int, slope: FloatArray, cosine: FloatArray) -> FloatArray:
        """Return `joint_energy` from the slope of the joint (>= 0) and the cosine of the mean of both rotations."""
        full_weight, width, rigidity = (
            values[..., i, None, None] for values in (self.weight, self.width, self.rigidity)
        )
        weight = full_weight * cosine
        simple = self.rectangles[..., i, None, None]
        if not np.all(simple):
            at_rest = self._other_energy(i, np.zeros_like(full_weight), full_weight)
            others = self._other_energy(i, slope, weight) - at_rest
            if not np.any(simple):
                return others
        length = np.sqrt(2.0 * weight / (rigidity * np.maximum(slope, PARALLEL)))  # length in contact
        partly = weight * slope * (0.5 * width - 2.0 / 3.0 * length)
        full = rigidity * width**3 * slope**2 / 24.0 - weight**2 / (2.0 * rigidity * width)
        rest = -(full_weight**2) / (2.0 * rigidity * width)
        found: FloatArray = np.where(length < width, partly, full) - rest
        return found if np.all(simple) else np.where(simple, found, others)

    def built_energy(self, i: int, turn: FloatArray, turn_below: FloatArray) -> FloatArray:
        """Return `joint_energy` of a column off its axis, with the weight acting at its offset; not relative to rest.

        Rotations of either sign count from the column as built.
        """
        mean, offset = 0.5 * (turn + turn_below) + self.lean[i], float(self.offset[i])
        slope, full_weight = 2.0 * np.sin(0.5 * (turn - turn_below)), self.weight[i]
        weight = full_weight * np.cos(mean)
        moved: FloatArray = offset * (0.5 * slope * weight - full_weight * np.sin(mean))
        return moved + self._other_energy(i, slope, weight, offset)

    def _other_energy(self, i: int, slope: FloatArray, weight: FloatArray, slip: float = 0.0) -> FloatArray:
        """Return `joint_energy` of any joint from its signed slope (rad) and weight (N), not relative to rest."""
        models = np.atleast_2d(self.model)
        found = np.zeros((len(models), slope.size // len(models)))
        slopes, weights = (np.array(values, np.float64, order="C").reshape(found.shape) for values in (slope, weight))
        for row in zip(models, slopes, weights, found, strict=True):
            model, *others = row
            joint_energies(self.n, model, i, slip, *others)
        return found.reshape(slope.shape)

    def grazed(self, part: float) -> tuple[FloatArray, FloatArray]:
        """Return the tangent of the energy of joints in contact over the fraction `part` of their width, (columns, n).

        First the distance of the resultant from the middle (m); then the excess of the elastic energy over its tangent
        there, divided by the square of the resultant, 1/(N/m) (verdict.py, `least_energies`).
        """
        lever, gives = self.width * (0.5 - part / 3.0), (2.0 / (3.0 * part) - 0.5) / (self.rigidity * self.width)
        if np.all(self.rectangles):
            return lever, gives
        half = 0.5 * self.width
        edge = half * (1.0 - 2.0 * part)
        first, second = np.zeros(edge.shape), np.zeros(edge.shape)  # moments about the edge
        rings_beyond(*(each.reshape(-1) for each in (half, 0.5 * self.bore, edge, first, second)))
        off = second / first
        others = 0.5 * off / (self.stiffness * first) - 0.5 / self.spring
        return np.where(self.rectangles, lever, edge + off), np.where(self.rectangles, gives, others)

    @cached_property
    def toppling(self) -> FloatArray:
        """The decrease of gravitational energy as each block rotates by theta, divided by 1 - cos(theta), J (n,)."""
        above = self.carried - self.mass
        lever: FloatArray = self.mass * self.centroid + above * self.height
        return self.g * lever


@lru_cache(maxsize=64)
def chain_of(column: Column) -> Chain:
    """Return the chain of a column, cached; do not modify it."""
    return column.kind.chain(column)


def over_below(values: FloatArray) -> FloatArray:
    """Return the differences between each block and the block below; the base is zero."""
    result: FloatArray = values.copy()
    result[..., :-1] -= values[..., 1:]
    return result


def from_base(steps: NDArray[Any]) -> NDArray[Any]:
    """Return the cumulative sums from the base up to each block."""
    return steps[..., ::-1].cumsum(axis=-1)[..., ::-1]
