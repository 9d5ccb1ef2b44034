"""The response inside a step, whatever integrator made it.

Coordinates, rates and accelerations at both ends define one quintic Hermite polynomial per coordinate; its error is of
order six in the step, and the accelerations are continuous inside a step because the inputs are.
"""

from .jit import kernel


@kernel
def interpolate_phase(work, start, end, between, size, h, fraction):
    """Coordinates and rates at `fraction` of the step h (s) between two phases; guesses of the accelerations too.

    start, end, between: offsets of phases in work; size: coordinates per phase.
    """
    s = fraction
    r = 1.0 - s
    for i in range(size):
        q0 = work[start + i]
        v0 = work[start + size + i]
        a0 = work[start + 2 * size + i]
        v1 = work[end + size + i]
        a1 = work[end + 2 * size + i]
        # what a parabola from the start misses at the end, in displacement, velocity and acceleration
        miss_q = (work[end + i] - q0) - h * (v0 + 0.5 * h * a0)
        miss_v = h * (v1 - v0 - h * a0)
        miss_a = h * h * (a1 - a0)
        c3 = 10.0 * miss_q - 4.0 * miss_v + 0.5 * miss_a
        c4 = -15.0 * miss_q + 7.0 * miss_v - miss_a
        c5 = 6.0 * miss_q - 3.0 * miss_v + 0.5 * miss_a
        work[between + i] = q0 + s * (h * (v0 + 0.5 * s * h * a0) + s * s * (c3 + s * (c4 + s * c5)))
        work[between + size + i] = v0 + s * (h * a0 + s * (3.0 * c3 + s * (4.0 * c4 + s * 5.0 * c5)) / h)
        work[between + 2 * size + i] = r * a0 + s * a1


@kernel
def turning_point(d0, v0, d1, v1, h):
    """Fraction of the step where the cubic through two displacements and velocities turns; v0 * v1 < 0."""
    # velocity of the cubic: v0 + 2 b s + 3 c s^2 over a step of unit length
    rise = (d1 - d0) / h
    b = 3.0 * rise - 2.0 * v0 - v1
    c = v0 + v1 - 2.0 * rise
    root = max(0.0, b * b - 3.0 * c * v0) ** 0.5
    # the root inside is the one whose denominator does not cancel
    below = -(b + root) if b > 0.0 else -(b - root)
    first = v0 / below if below != 0.0 else 0.5
    if 0.0 <= first <= 1.0:
        return first
    second = below / (3.0 * c) if c != 0.0 else 0.5
    return min(1.0, max(0.0, second))
