"""Contacts of faces of any two sizes and shapes: what both share, against quadrature, closed forms and energy."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np
import pytest
from support.batches import run_batch
from support.probe import Array, G

from solver import Block, Column, InitialState, InputError, Joint, Motion, Settings, simulate
from solver.kernels.column.joint.law import joint_forces, joint_potential, law_of
from solver.kernels.column.joint.sliding import rim_force
from solver.kernels.column.sections.section import contact_of
from solver.kernels.layout import spaces as at
from solver.kernels.numba_ext.jit import from_python
from solver.kernels.numba_ext.views import row_of
from solver.models.column.kinematics import Chain
from solver.models.column.lane_policy import reason_against_lanes
from solver.models.column.packing import pack_model
from solver.models.column.run import phase_of
from solver.models.column.stepper import Stepper
from solver.runs.many import simulate_many
from solver.statics.capacity import capacity_curve

K = 1e9  # N/m3
GAUSS = np.polynomial.legendre.leggauss(40)
_model = at.MODEL.over


@dataclass(frozen=True)
class Shape:
    """A face: a rectangle, a round one with a bore or without, or strips over a width; m."""

    width: float
    depth: float = 0.0  # 0: round
    bore: float = 0.0
    strips: tuple[float, ...] = ()

    def outer(self, x: Array) -> Array:
        """Return half the depth of the rim at abscissas from the middle."""
        half, inside = 0.5 * self.width, np.abs(x) < 0.5 * self.width
        if self.strips:
            number = np.clip(((x + half) / self.width * len(self.strips)).astype(int), 0, len(self.strips) - 1)
            return np.where(inside, 0.5 * np.array(self.strips)[number], 0.0)
        return np.where(inside, 0.5 * self.depth, 0.0) if self.depth else _half_chord(half, x)

    def inner(self, x: Array) -> Array:
        return _half_chord(0.5 * self.bore, x)

    def kinks(self, other: Shape) -> list[float]:
        """Return the ends, edges of strips, and where a rim is as deep as a straight part of the other face."""
        places = [0.5 * sign * size for size in (self.width, self.bore) for sign in (-1.0, 1.0)]
        places += [self.width * (k / len(self.strips) - 0.5) for k in range(len(self.strips))]
        for half in {0.5 * depth for depth in (other.depth, *other.strips)}:
            for radius in () if self.depth or self.strips else (0.5 * self.width, 0.5 * self.bore):
                places += [sign * math.sqrt(max(0.0, radius**2 - half**2)) for sign in (-1.0, 1.0)]
        return places

    def inset(self, rim: float) -> Shape:
        """Return the points of the face that are farther than the rim, m, from all of its edges."""
        depth, bore = self.depth - 2.0 * rim if self.depth else 0.0, self.bore + 2.0 * rim if self.bore else 0.0
        return Shape(self.width - 2.0 * rim, depth, bore)

    def block(self, joint: Joint, mass: float) -> Block:
        section = "rectangle" if self.depth or self.strips else "annulus" if self.bore else "circle"
        return Block(0.3, self.width, self.depth or self.width, mass, joint, section=section, bore=self.bore or None)


def _half_chord(radius: float, x: Array) -> Array:
    return np.sqrt(np.maximum(0.0, (radius - x) * (radius + x)))


@dataclass(frozen=True)
class Pair:
    own: Shape
    below: Shape
    rim: float = 0.0  # m, in which they touch; 0: all over

    def column(self, **settings: float) -> Column:
        section = {"section": "strips", "strips": self.own.strips} if self.own.strips else {}
        eta, rim = settings.pop("eta", 0.0), self.rim or None
        joint = Joint(2e9, eta, friction=0.2, rim=rim, **section)  # type: ignore[arg-type]
        low = self.below.block(Joint(2e11, joint.damping), 1e5)
        return Column("pair", (self.own.block(joint, 800.0), low), Settings(**settings))  # type: ignore[arg-type]

    @property
    def inside(self) -> Pair:
        """The part of either face that a rim leaves open."""
        return Pair(self.own.inset(self.rim), self.below.inset(self.rim))

    def depth(self, x: Array, slip: float) -> Array:
        """Return what both faces share, less what both insides share."""
        open_ = self.inside.depth(x, slip) if self.rim else 0.0
        return self.outline(x, slip) - open_

    def outline(self, x: Array, slip: float) -> Array:
        """Return the depth of what both faces share."""
        outer = np.minimum(self.own.outer(x), self.below.outer(x + slip))
        return 2.0 * np.maximum(0.0, outer - np.maximum(self.own.inner(x), self.below.inner(x + slip)))

    def kinks(self, slip: float) -> set[float]:
        """Return abscissas at which the depth of the outline, or that of the inside, may have a kink."""
        edges = {*self.own.kinks(self.below), *(place - slip for place in self.below.kinks(self.own))}
        for one, other in itertools.product((self.own.width, self.own.bore), (self.below.width, self.below.bore)):
            edges |= {(other**2 - one**2 - 4.0 * slip**2) / (8.0 * slip)} if slip else set()
        return edges | self.inside.kinks(slip) if self.rim else edges

    def integrals(self, slip: float, opening: float, slope: float) -> Array:
        """Return the energy J, N and M of the penetration slope * x - opening, by Gauss's rule between all kinks."""
        x, w = GAUSS
        edges = self.kinks(slip) | ({opening / slope} if slope else set())
        found = np.zeros(3)
        for begin, end in itertools.pairwise(sorted(edges)):
            angle = 0.5 * math.pi * x
            places = 0.5 * (begin + end) + 0.5 * (end - begin) * np.sin(angle)
            areas = 0.5 * (end - begin) * np.cos(angle) * 0.5 * math.pi * w * self.depth(places, slip)
            pressed = np.maximum(0.0, slope * places - opening)
            found += 2e9 * np.array([np.sum(areas * part) for part in (0.5 * pressed**2, pressed, pressed * places)])
        return found


SQUARE = Shape(1.0, 0.9)
PAIRS = {
    "wide on narrow": Pair(Shape(1.4, 0.8), Shape(0.9, 1.2)),
    "drum on ring": Pair(Shape(1.0), Shape(1.0, bore=0.7)),
    "drum on drum": Pair(Shape(1.0), Shape(1.0)),
    "drum on wider drum": Pair(Shape(1.0), Shape(1.1)),
    "ring on ring": Pair(Shape(1.0, bore=0.5), Shape(1.0, bore=0.5)),
    "ring on smaller ring": Pair(Shape(1.1, bore=0.3), Shape(0.9, bore=0.5)),
    "square on smaller drum": Pair(SQUARE, Shape(0.95)),
    "square on drum that holds it": Pair(Shape(0.6, 0.5), Shape(1.0)),
    "square that holds a ring": Pair(Shape(1.1, 1.2), Shape(1.0, bore=0.4)),
    "plank on ring": Pair(Shape(1.6, 0.3), Shape(1.0, bore=0.6)),
    "drum on plank": Pair(Shape(1.0), Shape(0.7, 0.6)),
    "ring on plank": Pair(Shape(1.0, bore=0.6), Shape(1.4, 0.4)),
    "drum on deep beam": Pair(Shape(1.0), Shape(0.6, 1.3)),
    "strips on drum": Pair(Shape(1.25, 1.0, strips=(0.3, 0.9, 0.5, 0.5, 0.9, 0.3)), Shape(1.1, bore=0.4)),
    "strips on narrow": Pair(Shape(1.2, 1.0, strips=(0.3, 0.5, 0.7, 0.5, 0.3)), Shape(0.9, 0.8)),
}
RIMS = {"drum on ring": 0.03, "ring on smaller ring": 0.04, "plank on ring": 0.07}  # m, of pairs with thin rings
PAIRS |= {
    f"{name}, rim": replace(pair, rim=RIMS.get(name, 0.11)) for name, pair in PAIRS.items() if not pair.own.strips
}
SLIPS = (0.0, 1e-9, 0.013, -0.11, 0.3, -0.52)


@from_python
def _ask(model: Array, opening: float, slope: float, slip: float, out: Array) -> None:
    """Return the elastic energy of joint 1, N, M, what its rims push by, and its ends."""
    blocks = _model(row_of(model), 2).blocks
    contact, law = contact_of(blocks, 0, slip), law_of(blocks, 0)
    out[0] = joint_potential(contact, law, opening, slope)
    out[1], out[2], _ = joint_forces(contact, law, opening, slope, 0.0, 0.0)
    out[3] = rim_force(blocks, 0, opening, slope, slip)
    out[4], out[5] = contact.left, contact.right


packed = lru_cache(maxsize=4)(pack_model)  # of a column that is asked many times


def ask(column: Column, opening: float, slope: float, slip: float) -> Array:
    out = np.zeros(6)
    _ask(packed(column), opening, slope, slip, out)
    return out


@pytest.mark.parametrize("name", PAIRS)
def test_forces_and_energy_are_those_of_quadrature(name: str) -> None:
    pair, rng = PAIRS[name], np.random.default_rng(2)
    column, touched = pair.column(), 0
    for slip in SLIPS:
        for _ in range(20):
            slope = float(rng.uniform(-1e-3, 1e-3))
            opening = float(rng.uniform(-1.0, 1.0)) * 0.5 * abs(slope) - float(rng.uniform(0.0, 1e-4))
            expected = pair.integrals(slip, opening, slope)
            scale = 2e9 * (abs(opening) + abs(slope))
            sizes = np.array([scale * (abs(opening) + abs(slope)), scale, scale])
            found = ask(column, opening, slope, slip)[:3]
            assert np.max(np.abs(found - expected) / sizes) < 1e-13  # measured 2e-15
            touched += expected[1] > 0.0
    assert touched > 60


@pytest.mark.parametrize("name", PAIRS)
def test_nothing_touches_beyond_the_ends_and_something_does_within(name: str) -> None:
    pair, x = PAIRS[name], np.linspace(-1.5, 1.5, 30001)
    for slip in SLIPS:
        touching = x[pair.depth(x, slip) > 0.0]
        left, right = ask(pair.column(), 0.0, 0.0, slip)[4:]
        assert [left, right] == pytest.approx([touching[0], touching[-1]], abs=2e-4)  # of the grid: 1e-4


@pytest.mark.parametrize("name", PAIRS)
def test_rims_push_by_what_a_slip_takes_off_the_energy(name: str) -> None:
    """Compare with central differences, at no slip as well, but for the crest of faces of equal width there."""
    column, rng, pushed = PAIRS[name].column(), np.random.default_rng(3), 0
    for slip in (0.0, 0.017, -0.11, 0.24, -0.33):
        if slip == 0.0 and PAIRS[name].own.width == PAIRS[name].below.width:
            continue
        for _ in range(20):
            slope = float(rng.uniform(-1e-3, 1e-3))
            opening = float(rng.uniform(-1.0, 1.0)) * 0.5 * abs(slope) - float(rng.uniform(0.0, 1e-4))
            push, step = ask(column, opening, slope, slip)[3], 1e-5
            ahead, back = (ask(column, opening, slope, slip + way * step)[0] for way in (1.0, -1.0))
            scale = 2e9 * (abs(opening) + abs(slope)) ** 2
            assert push == pytest.approx((back - ahead) / (2.0 * step), abs=2e-6 * scale)  # measured 1.3e-7
            pushed += abs(push) > 1e-4 * scale
    assert pushed > 20


@pytest.mark.parametrize("name", PAIRS)
def test_mirror_images_are_mirrored_to_the_last_bit(name: str) -> None:
    column = PAIRS[name].column()
    for slope, opening, slip in itertools.product((1e-3, -3e-4, 0.0), (1e-4, -1e-4), SLIPS):
        one, other = ask(column, opening, slope, slip), ask(column, opening, -slope, -slip)
        assert np.array_equal(one[:4], other[:4] * [1.0, 1.0, -1.0, -1.0])
        assert (one[4], one[5]) == (-other[5], -other[4])


@pytest.mark.parametrize("name", PAIRS)
def test_energy_falls_by_the_work_of_friction_alone(name: str) -> None:
    """Let it rock and slide at once, undamped, over a part of the contact."""
    column = PAIRS[name].column(tolerance=1e-10)
    chain = Chain(column)
    stepper = Stepper(column, InitialState(slip_rate=[0.7, 0.0], rotation=[2e-3, 0.0]))
    first = chain.energy(phase_of(stepper))
    stepper.rest_until(0.0, 0.2)
    work = float(np.sum(stepper.state.phase.friction_work))
    assert abs(stepper.state.phase.slip[0]) > 0.05
    assert chain.energy(phase_of(stepper)) + work == pytest.approx(first, abs=2e-8 * work)  # measured 4e-9


# --- columns


def slab(offset: float = 0.0, width: float = 2.0, height: float = 0.5, **joint: Any) -> Column:
    """Return a block on a heavy plinth of 1 m."""
    top = Block(height, width, 1.0, 5000.0, Joint(1e12, 1e-3, offset=offset or None, **joint))
    return Column("slab", (top, Block(0.5, 1.0, 1.0, 1e5, Joint(1e14, 1e-3))))


def at_rest(column: Column) -> Any:
    return at.ROW.see(Stepper(column).observe(0.0), column.n).joints


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_slab_off_its_plinth_presses_on_what_is_left(side: float) -> None:
    """Check that the resultant is 0.1 m from the rim, so that 0.3 m bear: 2 N / (0.3 m 1 m)."""
    seen = at_rest(slab(0.4 * side))
    assert seen.sigma_max[0] == pytest.approx(2.0 * 5000.0 * G / 0.3, rel=1e-4)  # 327 kPa; measured 3e-6
    assert seen.contact[0] == pytest.approx(0.3, rel=1e-4)


@pytest.mark.parametrize("offset", [0.5, 0.6, 0.7, -0.6])
def test_a_slab_whose_centroid_is_beyond_the_rim_does_not_stand(offset: float) -> None:
    with pytest.raises(InputError, match="slab cannot stand"):
        Stepper(slab(offset))


def test_a_block_wider_than_its_plinth_is_pushed_over_the_plinths_rim() -> None:
    """Check a block 4 m tall on 1 m: half the width over the height of the centroid of both, less what the joints give
    way by.
    """
    low = Block(0.2, 1.0, 1.0, 540.0, Joint(1e11, 1e-3))
    wide = Column("wide", (Block(4.0, 2.0, 1.0, 21600.0, Joint(1e11, 1e-3)), low))
    narrow = Column("narrow", (Block(4.0, 2.0, 1.0, 21600.0, Joint(1e11, 1e-3, width=1.0)), low))
    pushes = [float(np.max(capacity_curve(column).acceleration)) / G for column in (wide, narrow)]
    rigid = 0.5 * 22140.0 / (21600.0 * 2.2 + 540.0 * 0.1)  # 0.233
    assert pushes[0] == pushes[1]
    assert 0.95 * rigid < pushes[0] < rigid  # measured 0.2234


def test_a_drum_on_a_ring_bears_on_the_ring() -> None:
    low = Block(1.0, 1.0, 1.0, 1000.0, Joint(1e9, 1e-3), section="annulus", bore=0.7)
    column = Column("ring", (Block(1.0, 1.0, 1.0, 5000.0, Joint(1e9, 1e-3), section="circle"), low))
    area = 0.25 * math.pi * (1.0 - 0.7**2)
    assert at_rest(column).sigma_max[0] == pytest.approx(5000.0 * G / area, rel=1e-12)  # 122 kPa
    assert column.contacts[0].area == pytest.approx(area, rel=1e-14)


def test_a_wider_face_below_changes_nothing() -> None:
    """Check that bits of runs do not depend on how far the face below reaches beyond the contact."""
    top = Block(2.0, 1.0, 1.0, 5000.0, Joint(1e9, 1e-3))
    motion = Motion.harmonic(0.3 * G, 1.5, 3.0)
    found = [
        simulate(Column("two", (top, Block(1.0, width, 1.0, 5000.0, Joint(1e9, 1e-3, 1.0), inertia=1e3))), motion).ux
        for width in (1.0, 1.5)
    ]
    assert np.array_equal(found[0], found[1])


REFUSED: list[tuple[Pair, dict[str, Any], str]] = [
    (
        PAIRS["wide on narrow"],
        {"width": 1.0},
        "block[1].joint.width = 1.0: must not exceed that of the face below = 0.9",
    ),
    (
        Pair(SQUARE, Shape(1.2, 0.5)),
        {"depth": 0.6},
        "block[1].joint.depth = 0.6: must not exceed that",
    ),
    (Pair(Shape(1.0), Shape(1.2)), {"section": "rectangle"}, "block[1].joint.diagonal = 1.414"),
    (Pair(SQUARE, Shape(1.2)), {"width": 0.99, "depth": 0.89}, "block[1].joint.diagonal = 1.33"),
    (Pair(SQUARE, Shape(2.0)), {"section": "circle"}, "block[1].joint.width = 1.0: must not exceed the block's depth"),
    (
        Pair(Shape(1.0, bore=0.5), Shape(1.0)),
        {"section": "circle"},
        "block[1].joint.bore = 0.0: must be no",
    ),
    (
        Pair(Shape(1.0), Shape(1.0, bore=0.5)),
        {"section": "annulus", "bore": 0.4},
        "block[1].joint.bore = 0.4: must",
    ),
    (Pair(SQUARE, Shape(1.2)), {"section": "strips", "strips": (0.9, 0.9, 0.9, 0.9)}, ""),
    (
        Pair(SQUARE, Shape(1.0)),
        {"section": "strips", "strips": (0.9,) * 10},
        "block[1].joint.strips[0] = 0.9: must",
    ),
    (Pair(Shape(0.6), Shape(1.0, bore=0.7)), {}, "block[1].joint.reach = 0.6: nothing touches, must exceed the bore"),
    (Pair(Shape(1.0, bore=0.7), Shape(0.4, 0.4)), {}, "block[1].joint.bore = 0.7: nothing touches"),
]


@pytest.mark.parametrize(("pair", "joint", "message"), REFUSED)
def test_a_contact_larger_than_both_faces_share_is_refused(pair: Pair, joint: dict[str, Any], message: str) -> None:
    low = pair.below.block(Joint(K, 1e-3), 1000.0)
    blocks = (pair.own.block(Joint(K, 1e-3, **joint), 1000.0), low)
    if not message:
        Column("fits", blocks)
        return
    with pytest.raises(InputError) as raised:
        Column("refused", blocks)
    assert str(raised.value).startswith(message)


# --- many runs


def test_wide_blocks_slide_in_lanes_as_one_by_one() -> None:
    column = Column(
        "wide",
        (
            Block(1.2, 1.4, 1.0, 3000.0, Joint(1e9, 2e-3, friction=0.3)),
            Block(1.0, 0.9, 0.8, 1500.0, Joint(1e9, 2e-3, friction=0.35, offset=0.05)),
            Block(0.8, 1.1, 1.1, 2000.0, Joint(1e9, 2e-3)),
        ),
        Settings(tolerance=1e-5),
    )
    assert not reason_against_lanes(column)
    motions = [Motion.harmonic(a * G, 2.0, 2.0) for a in (0.1, 0.3, 0.45)]
    found = run_batch([column] * 3, motions)
    for motion, peaks in zip(motions, found.peak_top_ux, strict=True):
        alone = simulate(column, motion, settle=0.0)
        assert peaks == pytest.approx(alone.peak_top_ux, rel=1e-5)  # measured 4e-7


@pytest.mark.parametrize("name", ["square on smaller drum", "drum on plank"])
def test_round_faces_on_straight_ones_are_followed_one_by_one(name: str) -> None:
    column = PAIRS[name].column(eta=1e-3)
    assert reason_against_lanes(column) == "a round face on a straight one"
    motion = Motion.harmonic(0.3 * G, 2.0, 1.0)
    response = simulate(column, motion, ensemble=4)
    assert response.ensemble is not None
    assert np.max(response.ensemble.displacements) == pytest.approx(
        np.max(response.peak_top_ux), rel=0.03
    )  # measured 5.4e-3
    assert np.array_equal(
        simulate_many([column], [motion], keep=["peak_top_ux"])["peak_top_ux"][0], response.peak_top_ux
    )
