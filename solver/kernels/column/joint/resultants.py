"""The forces and the regime of a joint of a column: dry, or bonded by mortar until it breaks (docs/mortar.md).

A phase holds the bonds at its instant. An evaluation computes the part of them that is left (bond.py).
"""

from typing import NamedTuple

from ...numba_ext.jit import leaf
from ..sections.section import contact_of, ends_of
from .bond import (
    BROKEN,
    Bond,
    bond_margin,
    bond_regime,
    bonded_forces,
    bonded_peak_pressure,
    held_bonded_forces,
)
from .law import joint_peak_pressure, law_of, resultants
from .regimes import ANY, contact_regime, regime_margin


class Bonds(NamedTuple):
    """The bonds of the joints at the start of a step, rows: their ends (m), reach (m), and cohesion (Pa)."""

    left: object
    right: object
    reach: object
    cohesion: object


@leaf
def is_bonded(model):
    """Return True if joints of the column may be bonded."""
    return model.settings.bonded != 0.0


@leaf
def bonds_of(model, joints):
    """Return the bonds at the start of the step."""
    return Bonds(joints.bond_left, joints.bond_right, model.blocks.reach, model.blocks.cohesion)


@leaf
def _bond_of(bonds, i):
    return Bond(bonds.left[i], bonds.right[i], bonds.reach[i])


# --- forces


@leaf
def resultants_of(model, bonds, joints, hold, i, opening, slope, opening_rate, slope_rate, slip):
    """Return N, M and loaded length of joint i; flag in `hold` that the joint has left its regime.

    The part of a bond that is left is stored. bonds: None if no joint of the column is bonded.
    """
    if bonds is None:
        return resultants(model.blocks, hold, i, opening, slope, opening_rate, slope_rate, slip)
    return _bonded_resultants(model.blocks, bonds, joints, hold, i, opening, slope, opening_rate, slope_rate, slip)


@leaf
def _bonded_resultants(blocks, bonds, joints, hold, i, opening, slope, opening_rate, slope_rate, slip):
    joints.bonded_left[i], joints.bonded_right[i] = BROKEN
    motion, bond = (opening, slope, opening_rate, slope_rate), _bond_of(bonds, i)
    # a dry joint
    if not bond.left < bond.right:
        return resultants(blocks, hold, i, opening, slope, opening_rate, slope_rate, slip)
    # a bonded joint, freely or held in a regime
    contact, law, regime = contact_of(blocks, i, slip), law_of(blocks, i), hold.held[i]
    if regime == ANY:
        force, moment, length, left, right = bonded_forces(contact, law, bond, *motion)
    else:
        force, moment, length, left, right, margin = held_bonded_forces(regime, contact, law, bond, *motion)
        if margin < 0.0:
            hold.outside[i] = 1
    # ends of the bond after this evaluation
    joints.bonded_left[i], joints.bonded_right[i] = left, right
    return force, moment, length


@leaf
def shear_capacity(model, bonds, joints, i, normal):
    """Return the shear capacity of joint i (N) by friction, dowel and mortar: unbounded (RIGID) if it never slides."""
    # friction and dowel
    capacity = model.blocks.friction[i] * normal + model.blocks.dowel[i]
    if bonds is None:
        return capacity
    # cohesion of the mortar over the bonded area
    bonded = (joints.bonded_right[i] - joints.bonded_left[i]) * model.blocks.depth[i]
    return max(0.0, capacity + bonds.cohesion[i] * bonded)


@leaf
def largest_pressure(model, joints, i, contact, law, length, opening, slope, opening_rate, slope_rate):
    """Return the largest pressure on joint i (Pa); length: its loaded length (m)."""
    motion = opening, slope, opening_rate, slope_rate
    if is_bonded(model):
        return bonded_peak_pressure(contact, law, joints.bonded_left[i], joints.bonded_right[i], *motion)
    return joint_peak_pressure(contact, law, length, *motion)


# --- regimes


@leaf
def _holds(model, joints, i):
    """Return True if joint i has a bond at the start of the step."""
    return is_bonded(model) and joints.bond_left[i] < joints.bond_right[i]


@leaf
def regime_of(model, joints, i, slip, opening, slope, opening_rate, slope_rate):
    """Return the regime of joint i for a motion of the middle of its contact (m, m/s, and slope in rad, rad/s)."""
    blocks = model.blocks
    damping = blocks.damping[i]
    # a bonded joint
    if _holds(model, joints, i):
        contact, bond = contact_of(blocks, i, slip), _bond_of(bonds_of(model, joints), i)
        return bond_regime(contact, damping, bond, opening, slope, opening_rate, slope_rate)
    # a dry joint
    left, right = ends_of(blocks, i, slip)
    return contact_regime(left, right, damping, opening, slope, opening_rate, slope_rate)


@leaf
def margin_of(model, joints, i, regime, slip, opening, slope, opening_rate, slope_rate):
    """Return the distance (m) of joint i from leaving a regime, for a motion of the middle of its contact."""
    blocks = model.blocks
    damping = blocks.damping[i]
    # a bonded joint
    if _holds(model, joints, i):
        contact, bond = contact_of(blocks, i, slip), _bond_of(bonds_of(model, joints), i)
        return bond_margin(regime, contact, damping, bond, opening, slope, opening_rate, slope_rate)
    # a dry joint
    left, right = ends_of(blocks, i, slip)
    return regime_margin(regime, left, right, damping, opening, slope, opening_rate, slope_rate)
