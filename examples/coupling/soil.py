"""A rigid foundation on a half-space under a column: cone models of the soil, sway, rocking and vertical.

J. P. Wolf, Foundation Vibration Analysis Using Simple Physical Models (1994): a disk of radius r on a half-space of
shear modulus G = rho Vs^2 and Poisson's ratio up to 1/3. Sway: spring 8 G r / (2 - nu) and dashpot rho Vs A; vertical:
4 G r / (1 - nu) and rho Vp A; rocking: 8 G r^3 / (3 (1 - nu)), with a dashpot rho Vp I between the foundation and an
inner rotation of the inertia rho I z0 (lumped parameters of the rotational cone), z0 = 9 pi / 32 (1 - nu) (Vp/Vs)^2 r.

motion = [x, x', z, z', theta, theta', inner rate, ground velocity x, z]; x, z from rest in the free field.
"""

import math

from .law import LINE, NOT_NEGATIVE, POSITIVE, given_of, parameter, port_input, port_output, slope_parameter, travel

TITLE = "soil"
ABOUT = "Rigid foundation on a half-space that carries a column"
MOTION = 9
REACTION = tuple(f"column.{name}" for name in ("R0x", "R0z", "R0m", "mxx", "mxz", "mxt", "mzz", "mzt", "mtt"))
UNITS = ("N", "N", "N.m", "kg", "kg", "kg.m", "kg", "kg.m", "kg.m2")
PORTS = (
    port_input("ground.ax", "m/s2", "Acceleration of the free field, horizontal"),
    port_input("ground.az", "m/s2", "Acceleration of the free field, vertical"),
    port_input("ground.jx", "m/s3", "Slope of ground.ax within a step"),
    port_input("ground.jz", "m/s3", "Slope of ground.az within a step"),
    *(
        port_input(name, unit, f"{name[7:]} of the column; plain reactions where the masses are left at 0")
        for name, unit in zip(REACTION, UNITS, strict=True)
    ),
    port_input("given.ax", "m/s3", "Slope of base.ax within the step where slope = given"),
    port_input("given.az", "m/s3", "Slope of base.az within the step where slope = given"),
    port_input("given.alpha", "rad/s3", "Slope of base.alpha within the step where slope = given"),
    port_output("base.ax", "m/s2", "Acceleration of the foundation, for the column", REACTION),
    port_output("base.az", "m/s2", "Vertical acceleration of the foundation, for the column", REACTION),
    port_output("base.jx", "m/s3", "Slope of base.ax within the next step", (*REACTION, "given.ax")),
    port_output("base.jz", "m/s3", "Slope of base.az within the next step", (*REACTION, "given.az")),
    port_output("base.theta", "rad", "Rotation of the foundation, clockwise"),
    port_output("base.omega", "rad/s", "Its rate"),
    port_output("base.alpha", "rad/s2", "Its acceleration", REACTION),
    port_output("x", "m", "Sway of the foundation relative to the free field"),
    port_output("v", "m/s", "Its rate"),
    port_output("uz", "m", "Rise of the foundation from rest, relative to the free field"),
    port_output("base.vx", "m/s", "Horizontal velocity of the foundation in space"),
    port_output("base.vz", "m/s", "Its vertical velocity in space"),
    port_output("body.F0x", "N", "Force on the foundation, as its state determines it, for a column that it drives"),
    port_output("body.F0z", "N", "The same, vertical"),
    port_output("body.F0m", "N.m", "The same, moment"),
    port_output("body.Mxx", "kg", "Mass of the foundation, for that column"),
    port_output("body.Mzz", "kg", "The same, vertical"),
    port_output("body.Mtt", "kg.m2", "Its moment of inertia, for that column"),
    port_output("work", "J", "Energy given to the column so far"),
    parameter("mass", "kg", "Mass of the foundation", 60e3, POSITIVE),
    parameter("inertia", "kg.m2", "Its moment of inertia about the centre of the column's base joint", 1.2e5, POSITIVE),
    parameter("weight", "N", "Weight of the column, balanced by the soil at rest", 0.0),
    parameter("radius", "m", "r of the disk", 3.0, POSITIVE),
    parameter("density", "kg/m3", "rho of the soil", 1900.0, NOT_NEGATIVE),
    parameter("shear_velocity", "m/s", "Vs of the soil", 250.0, POSITIVE),
    parameter("poisson", "", "nu of the soil, up to 1/3", 0.3, (0.0, 1.0 / 3.0, "from 0 to 1/3")),
    slope_parameter(LINE),  # a parabola would halve the longest step that the dashpots leave stable
)
Given = given_of(PORTS)


def cone(value):
    """Return springs and dashpots (sway, vertical, rocking), and the rate 1/s at which the inner rotation follows."""
    r, rho, vs, nu = value.radius, value.density, value.shear_velocity, value.poisson
    area, second = math.pi * r * r, math.pi * r**4 / 4.0
    ratio = math.sqrt(2.0 * (1.0 - nu) / (1.0 - 2.0 * nu))
    shear, vp = rho * vs * vs, vs * ratio
    z0 = 9.0 * math.pi / 32.0 * (1.0 - nu) * ratio**2 * r
    return (
        (8.0 * shear * r / (2.0 - nu), rho * vs * area),
        (4.0 * shear * r / (1.0 - nu), rho * vp * area),
        (8.0 * shear * r**3 / (3.0 * (1.0 - nu)), rho * vp * second),
        vp / z0,
    )


def soil_forces(value, motion):
    """Return the forces on the foundation: horizontal, vertical, moment."""
    sway, heave, rocking, _ = cone(value)
    return (
        -(sway[0] * motion[0] + sway[1] * motion[1]),
        -(heave[0] * motion[2] + heave[1] * motion[3]),
        -(rocking[0] * motion[4] + rocking[1] * (motion[5] - motion[6])),
    )


def accelerations(value, motion):
    """Return the accelerations of the foundation."""
    f_x, f_z, f_t = soil_forces(value, motion)
    return solve(
        (value.mass + value.column_mxx, value.column_mxz, value.column_mxt),
        (value.mass + value.column_mzz, value.column_mzt),
        value.inertia + value.column_mtt,
        (f_x + value.column_R0x, f_z + value.column_R0z + carried(value), f_t + value.column_R0m),
    )


def carried(value):
    """Return the weight that the soil balances at rest, N: none before a column stands on it, which always weighs."""
    return value.weight if value.column_R0z != 0.0 else 0.0


def given_slopes(value):
    return value.given_ax, value.given_az, value.given_alpha


def needs(value, motion, a):
    """Return the forces and moment that the foundation needs of the column to accelerate by a: what its
    equation lacks.
    """
    f_x, f_z, f_t = soil_forces(value, motion)
    return value.mass * a[0] - f_x, value.mass * a[1] - f_z - carried(value), value.inertia * a[2] - f_t


def velocities(motion):
    """Return the velocities of the foundation in space."""
    return motion[1] + motion[7], motion[3] + motion[8], motion[5]


def move(value, motion, a, slope, h):
    """Take `motion` over h s under accelerations a + slope s."""
    _, _, _, rate = cone(value)
    omega, inner = motion[5], motion[6]
    motion[0], motion[1] = travel(motion[0], motion[1], a[0] - value.ground_ax, slope[0] - value.ground_jx, h)
    motion[2], motion[3] = travel(motion[2], motion[3], a[1] - value.ground_az, slope[1] - value.ground_jz, h)
    # inner' = rate (omega - inner), omega taken as the line between the ends of the step
    motion[4], motion[5] = travel(motion[4], omega, a[2], slope[2], h)
    left = math.exp(-rate * h)
    mean = (motion[5] - omega) / h
    motion[6] = left * inner + (1.0 - left) * (omega - mean / rate) + mean * h
    motion[7] += h * (value.ground_ax + 0.5 * h * value.ground_jx)
    motion[8] += h * (value.ground_az + 0.5 * h * value.ground_jz)


def outputs(value, motion, a, slope):
    """Return the outputs in the order of the table, but for the work."""
    x, v, z, theta, omega = motion[0], motion[1], motion[2], motion[4], motion[5]
    v_x, v_z, _ = velocities(motion)
    f_x, f_z, f_t = soil_forces(value, motion)
    seen = a[0], a[1], slope[0], slope[1], theta, omega, a[2], x, v, z, v_x, v_z
    return (*seen, f_x, f_z + value.weight, f_t, value.mass, value.mass, value.inertia)


def solve(first, second, third, right):
    """Return the solution of a symmetric, positive definite system of three, given by what its rows hold from the
    diagonal on.
    """
    xx, xz, xt = first
    by_z, by_t = xz / xx, xt / xx
    zz, zt = second[0] - by_z * xz, second[1] - by_z * xt
    f_z, f_t = right[1] - by_z * right[0], right[2] - by_t * right[0]
    by = zt / zz
    t = (f_t - by * f_z) / (third - by_t * xt - by * zt)
    z = (f_z - zt * t) / zz
    return (right[0] - xz * z - xt * t) / xx, z, t
