"""A rigid slab on isolators under a column: linear, lead-rubber or friction pendulum; ground acceleration in.

Force of the isolators on the slab, x being its displacement relative to the ground:

    linear             -(k x + c x')
    lead-rubber        -(k x + c x' + Q z)
    friction-pendulum  -(N / R x + c x' + mu N z),  N what the slab weighs with the column on it

z is the hysteretic variable of Bouc and Wen with exponent 1 (Wen, J. Eng. Mech. Div. ASCE 102 (1976) 249-263),
z' = (x' - (|x'| z + x' |z|) / 2) / yield, which is a function of the path x alone: exact for any step.
"""

import math

from .partner import PARABOLA, Partner, parameter, port_input, port_output, slope_parameter, travel

LINEAR, LEAD_RUBBER, PENDULUM = "linear", "lead-rubber", "friction-pendulum"
REACTION = ("column.R0x", "column.R0z", "column.mxx", "column.mxz")
ALL = (*REACTION, "ground.ax", "ground.az")


class Isolator(Partner):
    """motion = [x, x', z, velocity of the ground]."""

    title = "isolator"
    about = "Rigid slab on isolators that carries a column"
    axes = ("ax",)
    ports = (
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
        port_output("force", "N", "Force of the isolators on the slab", ("column.R0z", "ground.az")),
        port_output("base.vx", "m/s", "Velocity of the slab in space"),
        port_output("work", "J", "Energy given to the column so far"),
        parameter("mass", "kg", "Mass of the slab", 40e3),
        parameter("kind", "", "linear, lead-rubber or friction-pendulum", LINEAR),
        parameter("stiffness", "N/m", "k, after yielding", 1.2e6),
        parameter("damping", "N.s/m", "c", 0.0),
        parameter("strength", "N", "Q of the lead core", 6e4),
        parameter("yield", "m", "Displacement that the hysteretic force needs to build up", 5e-3),
        parameter("radius", "m", "R of the pendulum", 2.0),
        parameter("friction", "", "mu of the pendulum", 0.05),
        parameter("g", "m/s2", "Acceleration of gravity", 9.80665),
        slope_parameter(PARABOLA),
    )

    def at_start(self):
        return [0.0] * 4

    def isolator_force(self, x, v, z):
        """On the slab, N."""
        value = self.value
        kind = value("kind")
        if kind == LINEAR:
            return -(value("stiffness") * x + value("damping") * v)
        if kind == LEAD_RUBBER:
            return -(value("stiffness") * x + value("damping") * v + value("strength") * z)
        if kind == PENDULUM:
            normal = value("mass") * (value("g") + value("ground.az")) - value("column.R0z")
            return -(normal / value("radius") * x + value("damping") * v + value("friction") * normal * z)
        raise ValueError(f"kind = {kind!r}: must be {LINEAR}, {LEAD_RUBBER} or {PENDULUM}")

    def accelerations(self):
        value = self.value
        met = value("column.R0x") - value("column.mxz") * value("ground.az")
        return [(self.isolator_force(*self.motion[:3]) + met) / (value("mass") + value("column.mxx"))]

    def needs(self, a):
        return [self.value("mass") * a[0] - self.isolator_force(*self.motion[:3])]

    def velocities(self):
        return [self.motion[1] + self.motion[3]]

    def move(self, a, slope, h):
        x, v, z, ground = self.motion
        acceleration = a[0] - self.value("ground.ax")
        jerk = slope[0] - self.value("ground.jx")
        if self.value("kind") != LINEAR:
            here = x
            for s in [*turns(v, acceleration, jerk, h), h]:
                there, _ = travel(x, v, acceleration, jerk, s)
                z = hysteresis(z, (there - here) / self.value("yield"))
                here = there
        x, v = travel(x, v, acceleration, jerk, h)
        self.motion = [x, v, z, ground + h * (self.value("ground.ax") + 0.5 * h * self.value("ground.jx"))]

    def outputs(self, a, slope):
        x, v, z, ground = self.motion
        return {
            "base.ax": a[0], "base.az": self.value("ground.az"),
            "base.jx": slope[0], "base.jz": self.value("ground.jz"),
            "x": x, "v": v, "z": z, "force": self.isolator_force(x, v, z), "base.vx": v + ground,
        }  # fmt: skip


def hysteresis(z, path):
    """z after a path in one direction, in yield displacements."""
    if path < 0.0:
        return -hysteresis(-z, -path)
    if z < 0.0:  # elastic until z passes through zero
        elastic = min(path, -z)
        z, path = z + elastic, path - elastic
    return 1.0 - (1.0 - z) * math.exp(-path)


def turns(v, a, j, h):
    """Instants within 0 < s < h, in order, where v + a s + j s^2 / 2 changes its sign."""
    if j == 0.0:
        roots = [-v / a] if a != 0.0 else []
    else:
        square = a * a - 2.0 * j * v
        if square <= 0.0:
            return []
        far = -(a + math.copysign(math.sqrt(square), a))
        roots = [far / j] + ([2.0 * v / far] if far != 0.0 else [])
    return sorted(s for s in roots if 0.0 < s < h)
