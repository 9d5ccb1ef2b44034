"""A rigid slab on isolators under a column: linear, lead-rubber or friction pendulum; ground acceleration in.

Force of the isolators on the slab, x being its displacement relative to the ground:

    linear             -(k x + c x')
    lead-rubber        -(k x + c x' + Q z)
    friction-pendulum  -(N / R x + c x' + mu N z),  N what the slab weighs with the column on it

z is the hysteretic variable of Bouc and Wen with exponent 1 (Wen, J. Eng. Mech. Div. ASCE 102 (1976) 249-263),
z' = (x' - (|x'| z + x' |z|) / 2) / yield, which is a function of the path x alone: exact for any step.

motion = [x, x', z, velocity of the ground, N at the last exchange and at the one before].
"""

import math

from .law import (
    NOT_NEGATIVE,
    PARABOLA,
    POSITIVE,
    choice,
    given_of,
    parameter,
    port_input,
    port_output,
    slope_parameter,
    travel,
)

TITLE = "isolator"
ABOUT = "Rigid slab on isolators that carries a column"
MOTION = 6
LINEAR, LEAD_RUBBER, PENDULUM = range(3)
KINDS = ("linear", "lead-rubber", "friction-pendulum")
ALL = ("column.R0x", "column.R0z", "column.mxx", "column.mxz", "ground.ax", "ground.az")
PORTS = (
    port_input("ground.ax", "m/s2", "Ground acceleration, horizontal"),
    port_input("ground.az", "m/s2", "Ground acceleration, vertical, handed on to the column"),
    port_input("ground.jx", "m/s3", "Slope of ground.ax within a step"),
    port_input("ground.jz", "m/s3", "Slope of ground.az within a step"),
    port_input("column.R0x", "N", "R0x of the column; its plain Fx where column.mxx is left at 0"),
    port_input("column.R0z", "N", "R0z of the column: the weight that the isolators carry, negative"),
    port_input("column.mxx", "kg", "Effective mass of the column"),
    port_input("column.mxz", "kg", "Effective mass of the column, coupling with the vertical"),
    port_input("given.ax", "m/s3", "Slope of base.ax within the step where slope = given"),
    port_output("base.ax", "m/s2", "Acceleration of the slab, for the column", ALL),
    port_output("base.az", "m/s2", "Vertical acceleration of the slab, for the column", ("ground.az",)),
    port_output("base.jx", "m/s3", "Slope of base.ax within the next step", (*ALL, "given.ax")),
    port_output("base.jz", "m/s3", "Slope of base.az within the next step", ("ground.jz",)),
    port_output("x", "m", "Displacement of the slab relative to the ground"),
    port_output("v", "m/s", "Its rate"),
    port_output("z", "", "Hysteretic variable, -1 to 1"),
    port_output("force", "N", "Force of the isolators on the slab"),
    port_output("base.vx", "m/s", "Velocity of the slab in space"),
    port_output("body.F0x", "N", "Force on the slab, as its state determines it, for a column that it drives"),
    port_output("body.Mxx", "kg", "Mass of the slab, for that column"),
    port_output("work", "J", "Energy given to the column so far"),
    parameter("mass", "kg", "Mass of the slab", 40e3, POSITIVE),
    choice("kind", "What the slab stands on", KINDS, LINEAR),
    parameter("stiffness", "N/m", "k, after yielding", 1.2e6, NOT_NEGATIVE),
    parameter("damping", "N.s/m", "c", 0.0),
    parameter("strength", "N", "Q of the lead core", 6e4, NOT_NEGATIVE),
    parameter("yield", "m", "Displacement that the hysteretic force needs to build up", 5e-3, POSITIVE),
    parameter("radius", "m", "R of the pendulum", 2.0, POSITIVE),
    parameter("friction", "", "mu of the pendulum", 0.05, NOT_NEGATIVE),
    parameter("g", "m/s2", "Acceleration of gravity", 9.80665, NOT_NEGATIVE),
    slope_parameter(PARABOLA),
)
Given = given_of(PORTS)


def isolator_force(value, motion):
    """Return the force on the slab, N."""
    x, v, z = motion[0], motion[1], motion[2]
    if value.kind == LINEAR:
        return -(value.stiffness * x + value.damping * v)
    if value.kind == LEAD_RUBBER:
        return -(value.stiffness * x + value.damping * v + value.strength * z)
    normal = weight_at(motion)
    return -(normal / value.radius * x + value.damping * v + value.friction * normal * z)


def weight_at(motion):
    """Return the present weight of slab and column, N, by the line through the last two exchanges: so it belongs to the
    state.
    """
    return motion[4] if motion[5] == 0.0 else 2.0 * motion[4] - motion[5]


def accelerations(value, motion):
    """Return the accelerations of the slab, along x alone: vertically it goes with the ground."""
    met = value.column_R0x - value.column_mxz * value.ground_az
    return (isolator_force(value, motion) + met) / (value.mass + value.column_mxx), 0.0, 0.0


def given_slopes(value):
    return value.given_ax, 0.0, 0.0


def needs(value, motion, a):
    """Return the force that the slab needs of the column to accelerate by a: what its equation lacks."""
    return value.mass * a[0] - isolator_force(value, motion), 0.0, 0.0


def velocities(motion):
    """Return the velocities of the slab in space."""
    return motion[1] + motion[3], 0.0, 0.0


def move(value, motion, a, slope, h):
    """Take `motion` over h s under accelerations a + slope s."""
    x, v = motion[0], motion[1]
    acceleration = a[0] - value.ground_ax
    jerk = slope[0] - value.ground_jx
    if value.kind != LINEAR:
        first, second = turns(v, acceleration, jerk, h)
        here = x
        for s in (first, second, h):
            there, _ = travel(x, v, acceleration, jerk, s)
            motion[2] = hysteresis(motion[2], (there - here) / value.yield_)
            here = there
    motion[0], motion[1] = travel(x, v, acceleration, jerk, h)
    motion[3] += h * (value.ground_ax + 0.5 * h * value.ground_jx)
    motion[5], motion[4] = motion[4], value.mass * (value.g + value.ground_az) - value.column_R0z


def outputs(value, motion, a, slope):
    """Return the outputs in the order of the table, but for the work."""
    x, v, z, ground, force = motion[0], motion[1], motion[2], motion[3], isolator_force(value, motion)
    return a[0], value.ground_az, slope[0], value.ground_jz, x, v, z, force, v + ground, force, value.mass


def hysteresis(z, path):
    """Return z after a path in one direction, in yield displacements."""
    sign = 1.0
    if path < 0.0:
        sign, z, path = -1.0, -z, -path
    if z < 0.0:  # elastic until z passes through zero
        elastic = min(path, -z)
        z, path = z + elastic, path - elastic
    return sign * (1.0 - (1.0 - z) * math.exp(-path))


def turns(v, a, j, h):
    """Return the two instants, in order, where v + a s + j s^2 / 2 changes its sign; h in place of one that is not
    within.
    """
    first = second = h
    if j == 0.0:
        if a != 0.0:
            first = -v / a
    else:
        square = a * a - 2.0 * j * v
        if square > 0.0:
            far = -(a + math.copysign(math.sqrt(square), a))
            first = far / j
            if far != 0.0:
                second = 2.0 * v / far
    first = first if 0.0 < first < h else h
    second = second if 0.0 < second < h else h
    return min(first, second), max(first, second)
