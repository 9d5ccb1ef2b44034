"""A rigid foundation on a half-space under a column: cone models of the soil, sway, rocking and vertical.

J. P. Wolf, Foundation Vibration Analysis Using Simple Physical Models (1994): a disk of radius r on a half-space of
shear modulus G = rho Vs^2 and Poisson's ratio up to 1/3. Sway: spring 8 G r / (2 - nu) and dashpot rho Vs A; vertical:
4 G r / (1 - nu) and rho Vp A; rocking: 8 G r^3 / (3 (1 - nu)), with a dashpot rho Vp I between the foundation and an
inner rotation of the inertia rho I z0 (lumped parameters of the rotational cone), z0 = 9 pi / 32 (1 - nu) (Vp/Vs)^2 r.
"""

import math

from .partner import LINE, Partner, parameter, port_input, port_output, slope_parameter, travel

REACTION = tuple(f"column.{name}" for name in ("R0x", "R0z", "R0m", "mxx", "mxz", "mxt", "mzz", "mzt", "mtt"))
UNITS = ("N", "N", "N.m", "kg", "kg", "kg.m", "kg", "kg.m", "kg.m2")


class Soil(Partner):
    """motion = [x, x', z, z', theta, theta', inner rate, ground velocity x, z]; x, z from rest in the free field."""

    title = "soil"
    about = "Rigid foundation on a half-space that carries a column"
    axes = ("ax", "az", "alpha")
    ports = (
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
        port_output("work", "J", "Energy given to the column so far"),
        parameter("mass", "kg", "Mass of the foundation", 60e3),
        parameter("inertia", "kg.m2", "Its moment of inertia about the centre of the column's base joint", 1.2e5),
        parameter("weight", "N", "Weight of the column, balanced by the soil at rest", 0.0),
        parameter("radius", "m", "r of the disk", 3.0),
        parameter("density", "kg/m3", "rho of the soil", 1900.0),
        parameter("shear_velocity", "m/s", "Vs of the soil", 250.0),
        parameter("poisson", "", "nu of the soil, up to 1/3", 0.3),
        slope_parameter(LINE),  # a parabola would halve the longest step that the dashpots leave stable
    )

    def at_start(self):
        r, rho, vs, nu = (self.value(name) for name in ("radius", "density", "shear_velocity", "poisson"))
        if not 0.0 <= nu <= 1.0 / 3.0:
            raise ValueError(f"poisson = {nu}: must be from 0 to 1/3")
        self.constants = cone(r, rho, vs, nu)
        return [0.0] * 9

    def soil_forces(self):
        """On the foundation: horizontal, vertical, moment."""
        x, v, z, w, theta, omega, inner, _, _ = self.motion
        (k_x, c_x), (k_z, c_z), (k_t, c_t), _ = self.constants
        return -(k_x * x + c_x * v), -(k_z * z + c_z * w), -(k_t * theta + c_t * (omega - inner))

    def accelerations(self):
        r0x, r0z, r0m, xx, xz, xt, zz, zt, tt = (self.value(name) for name in REACTION)
        f_x, f_z, f_t = self.soil_forces()
        mass, inertia = self.value("mass"), self.value("inertia")
        matrix = [[mass + xx, xz, xt], [xz, mass + zz, zt], [xt, zt, inertia + tt]]
        return solve(matrix, [f_x + r0x, f_z + r0z + self.value("weight"), f_t + r0m])

    def needs(self, a):
        own = self.value("mass"), self.value("mass"), self.value("inertia")
        rest = 0.0, self.value("weight"), 0.0
        return [m * each - f - r for m, each, f, r in zip(own, a, self.soil_forces(), rest, strict=True)]

    def velocities(self):
        _, v, _, w, _, omega, _, ground_x, ground_z = self.motion
        return [v + ground_x, w + ground_z, omega]

    def move(self, a, slope, h):
        x, v, z, w, theta, omega, inner, ground_x, ground_z = self.motion
        rate = self.constants[3]
        ground = self.value("ground.ax"), self.value("ground.az")
        jerk = self.value("ground.jx"), self.value("ground.jz")
        x, v = travel(x, v, a[0] - ground[0], slope[0] - jerk[0], h)
        z, w = travel(z, w, a[1] - ground[1], slope[1] - jerk[1], h)
        # inner' = rate (omega - inner), omega taken as the line between the ends of the step
        theta, turned = travel(theta, omega, a[2], slope[2], h)
        left = math.exp(-rate * h)
        mean = (turned - omega) / h
        inner = left * inner + (1.0 - left) * (omega - mean / rate) + mean * h
        ground_x += h * (ground[0] + 0.5 * h * jerk[0])
        ground_z += h * (ground[1] + 0.5 * h * jerk[1])
        self.motion = [x, v, z, w, theta, turned, inner, ground_x, ground_z]

    def outputs(self, a, slope):
        x, v, z, _, theta, omega, *_ = self.motion
        velocity_x, velocity_z, _ = self.velocities()
        return {
            "base.ax": a[0], "base.az": a[1], "base.jx": slope[0], "base.jz": slope[1],
            "base.theta": theta, "base.omega": omega, "base.alpha": a[2], "x": x, "v": v, "uz": z,
            "base.vx": velocity_x, "base.vz": velocity_z,
        }  # fmt: skip


def cone(r, rho, vs, nu):
    """Springs and dashpots (sway, vertical, rocking), and the rate 1/s at which the inner rotation follows."""
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


def solve(matrix, right):
    """Solution of a symmetric, positive definite system of three, by elimination."""
    rows = [[*row, value] for row, value in zip(matrix, right, strict=True)]
    for k in range(3):
        for row in rows[k + 1 :]:
            factor = row[k] / rows[k][k]
            row[k:] = [there - factor * here for there, here in zip(row[k:], rows[k][k:], strict=True)]
    found = [0.0] * 3
    for k in (2, 1, 0):
        rest = rows[k][3] - sum(rows[k][i] * found[i] for i in range(k + 1, 3))
        found[k] = rest / rows[k][k]
    return found
