"""The motion of the ports of a column, along the chain of its blocks."""

from ...numba_ext.jit import kernel
from ...numba_ext.numbers import sine_cosine
from ..joint.sliding import can_slide


@kernel
def see_points(motion, model, phase, ports, spots):
    """Fill `spots` with the motion of the ports (SPOTS, of as many as `ports`) in an evaluated phase.

    Along the chain, from the base up. Displacements count from the column as built, and all is relative to the point of
    the base under the column: m, m/s, m/s2.
    """
    n, blocks, slides = model.n, model.blocks, can_slide(model)
    x, z, built_x, built_z, vx, vz, ax, az = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0  # of the top face below
    turn_below, spin_below, alpha_below = motion.theta, motion.omega, motion.alpha
    for i in range(n - 1, -1, -1):
        turn, spin = phase.theta[i] + motion.theta, phase.theta_rate[i] + motion.omega
        alpha = phase.theta_acceleration[i] + motion.alpha
        # across the joint: the opening along n, the slip along t
        phi, swing, swings = 0.5 * (turn + turn_below), 0.5 * (spin + spin_below), 0.5 * (alpha + alpha_below)
        sine, cosine = sine_cosine(phi + blocks.lean[i])
        opening, opens, opened = phase.opening[i], phase.opening_rate[i], phase.opening_acceleration[i]
        slip, slides_by, slid = 0.0, 0.0, 0.0
        if slides:
            slip, slides_by, slid = phase.slip[i], phase.slip_rate[i], phase.slip_acceleration[i]
            sine_built, cosine_built = sine_cosine(blocks.lean[i])
            built_x, built_z = built_x + blocks.offset[i] * cosine_built, built_z - blocks.offset[i] * sine_built
        x, z = x + (opening * sine + slip * cosine), z + (opening * cosine - slip * sine)
        # velocity: rates across and along the joint, with its rotation
        across, along = opens - slip * swing, slides_by + opening * swing
        vx, vz = vx + (across * sine + along * cosine), vz + (across * cosine - along * sine)
        # acceleration, with the terms of Coriolis and centripetal acceleration
        across = opened - opening * swing * swing - 2.0 * slides_by * swing - slip * swings
        along = slid - slip * swing * swing + 2.0 * opens * swing + opening * swings
        ax, az = ax + (across * sine + along * cosine), az + (across * cosine - along * sine)
        sine, cosine = sine_cosine(turn + blocks.tilt[i])
        sine_built, cosine_built = sine_cosine(blocks.tilt[i])
        square, upper = spin * spin, blocks.height[i]
        # ports of the block: from the middle of its bottom face by an arm that turns with it
        for p in range(ports.n):
            if int(ports.body[p]) == i:
                right, up = ports.x[p], blocks.centroid[i] + ports.z[p]
                arm_x, arm_z = up * sine + right * cosine, up * cosine - right * sine
                spots.x[p] = (x - built_x) + (arm_x - (up * sine_built + right * cosine_built))
                spots.z[p] = (z - built_z) + (arm_z - (up * cosine_built - right * sine_built))
                spots.vx[p], spots.vz[p] = vx + spin * arm_z, vz - spin * arm_x
                spots.ax[p] = ax + alpha * arm_z - square * arm_x
                spots.az[p] = az - alpha * arm_x - square * arm_z
        # the middle of the top face, for the next block
        x, z, built_x, built_z = (
            x + upper * sine,
            z + upper * cosine,
            built_x + upper * sine_built,
            built_z + upper * cosine_built,
        )
        vx, vz = vx + spin * upper * cosine, vz - spin * upper * sine
        ax += upper * (alpha * cosine - square * sine)
        az -= upper * (alpha * sine + square * cosine)
        turn_below, spin_below, alpha_below = turn, spin, alpha
