"""Round faces that have slipped: parts of the lens against quadrature, forces against energy, motion."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.probe import Array, G

from solver import Block, Column, InitialState, Joint, Motion, Settings, simulate
from solver.column.packing import pack_model
from solver.dynamics.kinematics import Chain
from solver.dynamics.stepper import Stepper
from solver.kernels.joint.law import joint_forces, joint_potential, law_of
from solver.kernels.joint.sliding import rim_force
from solver.kernels.layout import spaces as at
from solver.kernels.numba_ext.jit import from_python
from solver.kernels.numba_ext.views import row_of
from solver.kernels.sections.lens import ends_of_rings, lens_part
from solver.kernels.sections.section import contact_of
from solver.runs.single_run import phase_of

examples = settings(deadline=None, max_examples=300, derandomize=True)
_model = at.MODEL.over
_part, _ends = from_python(lens_part), from_python(ends_of_rings)
K = 1e9  # N/m3


@dataclass(frozen=True)
class Faces:
    """Radii of the face above, which stands at 0, of its bore, and of those below, which stand at -slip; m."""

    own: float
    bore: float
    below: float
    bore_below: float
    slip: float

    def width(self, x: Array) -> Array:
        """Of the contact, from the chords of the four circles."""

        def half(radius: float, place: Array) -> Array:
            return np.sqrt(np.maximum(0.0, (radius - place) * (radius + place)))

        outer = np.minimum(half(self.own, x), half(self.below, x + self.slip))
        inner = np.maximum(half(self.bore, x), half(self.bore_below, x + self.slip))
        return 2.0 * np.maximum(0.0, outer - inner)

    def kinks(self) -> list[float]:
        """Rims, and where two of the circles cross."""
        circles = [(self.own, 0.0), (self.bore, 0.0), (self.below, -self.slip), (self.bore_below, -self.slip)]
        places = [centre + sign * radius for radius, centre in circles for sign in (-1.0, 1.0)]
        for one, _ in circles[:2]:
            for other, _ in circles[2:]:
                if self.slip != 0.0:
                    places.append((other * other - one * one - self.slip**2) / (2.0 * self.slip))
        return places

    def moments(self, lo: float, hi: float, about: float) -> Array:
        """Area, first and second moment about a place, by Gauss's rule; ends are drawn apart, as roots ask for."""
        x, w = np.polynomial.legendre.leggauss(60)
        edges = sorted({lo, hi, *(place for place in self.kinks() if lo < place < hi)})
        found = np.zeros(3)
        for begin, end in itertools.pairwise(edges):
            angle = 0.5 * math.pi * x
            places = 0.5 * (begin + end) + 0.5 * (end - begin) * np.sin(angle)
            weights = 0.5 * (end - begin) * np.cos(angle) * 0.5 * math.pi * w * self.width(places)
            found += [np.sum(weights * (places - about) ** k) for k in range(3)]
        return found

    def ends(self) -> tuple[float, float]:
        left, right = max(-self.own, -self.below - self.slip), min(self.own, self.below - self.slip)
        if self.bore > 0.0 and self.slip != 0.0:
            left, right = _ends(self.own, self.bore, self.below, self.bore_below, self.slip, left, right)
        return left, right


@st.composite
def faces(draw: st.DrawFn) -> Faces:
    own = 0.8
    below = own * draw(st.sampled_from([1.0, 1.0 + 1e-9, 1.01, 1.3]))
    bore = own * draw(st.sampled_from([0.0, 0.3, 0.9]))
    bore_below = bore * draw(st.sampled_from([0.0, 0.5, 1.0]))
    slip = draw(st.sampled_from([-1.0, 1.0])) * own * draw(st.sampled_from([1e-9, 1e-3, 0.05, 0.3, 0.8, 1.4]))
    return Faces(own, bore, below, bore_below, slip)


# of the contact; next to its ends quadrature is not exact, for roots begin there
PLACES = st.one_of(st.sampled_from([0.0, 1.0]), st.floats(0.01, 0.99))


@given(found=faces(), low=PLACES, high=PLACES)
@examples
def test_parts_are_those_of_quadrature(found: Faces, low: float, high: float) -> None:
    left, right = found.ends()
    lo, hi = sorted(left + (right - left) * part for part in (low, high))
    middle, area, first, second = _part(found.own, found.bore, found.below, found.bore_below, found.slip, lo, hi)
    expected = found.moments(lo, hi, middle)
    whole = math.pi * found.own**2
    sizes = whole * np.array([1.0, found.own, found.own**2])
    assert np.max(np.abs(np.array([area, first, second]) - expected) / sizes) < 1e-12  # measured 3e-14


@given(found=faces())
@examples
def test_beyond_the_ends_nothing_touches(found: Faces) -> None:
    left, right = found.ends()
    x = np.linspace(-2.0, 2.0, 4001)
    touching = x[found.width(x) > 1e-9]
    assert not touching.size or (touching[0] > left - 1e-9 and touching[-1] < right + 1e-9)
    whole = found.moments(-2.0, 2.0, 0.0)
    assert whole == pytest.approx(found.moments(left, right, 0.0) if left < right else np.zeros(3), abs=1e-10)


# --- forces


def pair(section: str, top_below: float | None = None, friction: float = 0.2, **settings: float) -> Column:
    """A flat drum on a heavy one, which tapers if its top diameter is given."""
    bore = 0.5 if section == "annulus" else None
    eta = settings.pop("eta", 0.0)
    top = Block(0.3, 1.0, 1.0, 800.0, Joint(2e9, eta, friction=friction), section=section, bore=bore)
    low = Block(0.4, 1.2, 1.2, 100000.0, Joint(2e11, eta), section=section, bore=bore, top_width=top_below or 1.0)
    return Column("pair", (top, low), Settings(**settings))  # type: ignore[arg-type]


@from_python
def _ask(model: Array, opening: float, slope: float, slip: float, out: Array) -> None:
    """Elastic energy of joint 1, N, M and what its rim pushes by."""
    blocks = _model(row_of(model), 2).blocks
    contact, law = contact_of(blocks, 0, slip), law_of(blocks, 0)
    out[0] = joint_potential(contact, law, opening, slope)
    out[1], out[2], _ = joint_forces(contact, law, opening, slope, 0.0, 0.0)
    out[3] = rim_force(blocks, 0, opening, slope, slip)


def ask(column: Column, opening: float, slope: float, slip: float) -> Array:
    out = np.zeros(4)
    _ask(pack_model(column), opening, slope, slip, out)
    return out


@pytest.mark.parametrize("top_below", [1.0, 1.1])
@pytest.mark.parametrize("section", ["circle", "annulus"])
def test_forces_are_the_derivatives_of_the_energy(section: str, top_below: float) -> None:
    """By the opening, by the slope, and by the slip: what the rim pushes by."""
    column, rng, steps = pair(section, top_below), np.random.default_rng(1), (1e-8, 1e-8, 1e-5)
    pushed = 0
    for _ in range(300):
        slope = rng.uniform(-1e-3, 1e-3)
        slip = float(rng.choice([-1.0, 1.0])) * 10.0 ** rng.uniform(-3.0, -0.3)
        opening = rng.uniform(-1.0, 1.0) * 0.5 * abs(slope) - rng.uniform(0.0, 2e-4)
        state = np.array([opening, slope, slip])
        _, normal, moment, push = ask(column, *state)
        wanted = []
        for k, step in enumerate(steps):
            ahead, back = state.copy(), state.copy()
            ahead[k] += step
            back[k] -= step
            wanted.append((ask(column, *ahead)[0] - ask(column, *back)[0]) / (2.0 * step))
        scale = max(abs(normal), 10.0)
        assert [-normal, moment] == pytest.approx(wanted[:2], abs=3e-6 * scale)
        assert push == pytest.approx(-wanted[2], abs=1e-6 * scale * (abs(opening) + abs(slope)) / 1e-4)
        pushed += abs(push) > 0.0
    assert pushed >= 80


@pytest.mark.parametrize("section", ["circle", "annulus"])
def test_a_hair_of_slip_changes_nothing_and_mirror_images_are_mirrored(section: str) -> None:
    column = pair(section)
    for slope, opening in ((1e-3, 1e-4), (-3e-4, -1e-4), (0.0, -1e-4)):
        whole, hair = ask(column, opening, slope, 0.0), ask(column, opening, slope, 1e-9)
        assert hair[:3] == pytest.approx(whole[:3], rel=1e-8, abs=1e-9 * whole[1])
        one, other = ask(column, opening, slope, 0.3), ask(column, opening, -slope, -0.3)
        assert np.array_equal(one, other * [1.0, 1.0, -1.0, -1.0])


def test_a_drum_upon_a_wider_one_is_not_cut_off_until_it_reaches_its_rim() -> None:
    """Of 1.0 m on 1.2 m: whole up to a slip of 0.1 m."""
    column = pair("circle", 1.2)
    whole = ask(column, -1e-4, 3e-4, 0.0)
    assert ask(column, -1e-4, 3e-4, 0.09) == pytest.approx(whole, rel=1e-13)
    assert ask(column, -1e-4, 3e-4, 0.12)[0] < whole[0]


# --- motion


@pytest.mark.parametrize("section", ["circle", "annulus"])
def test_a_drum_pushed_off_slides_as_on_an_endless_face_until_it_tips(section: str) -> None:
    """Friction is that of the weight, however small the contact and whatever its shape."""
    mu, reach = 0.2, 0.25
    speed = math.sqrt(2.0 * mu * G * reach)
    column = pair(section, friction=mu, eta=1e-3, tolerance=1e-8)
    motion = Motion.from_samples(0.01, np.zeros(201))
    found = simulate(column, motion, initial=InitialState(slip_rate=[speed, 0.0]), settle=0.0)
    assert found.slip[-1, 0] == pytest.approx(reach, rel=2e-3)
    back = simulate(column, motion, initial=InitialState(slip_rate=[-speed, 0.0]), settle=0.0)
    assert np.array_equal(back.slip[:, 0], -found.slip[:, 0])


@pytest.mark.parametrize("section", ["circle", "annulus"])
def test_on_a_lens_energy_falls_by_the_work_of_friction_alone(section: str) -> None:
    column = pair(section, tolerance=1e-11)
    chain = Chain(column)
    stepper = Stepper(column, InitialState(slip_rate=[1.1, 0.0], rotation=[0.01, 0.0]))
    first = chain.energy(phase_of(stepper))
    stepper.rest_until(0.0, 0.4)
    work = float(np.sum(stepper.state.phase.friction_work))
    assert stepper.state.phase.slip[0] > 0.15
    assert work > 0.1 * first
    assert chain.energy(phase_of(stepper)) + work == pytest.approx(first, abs=1e-9 * work)
