"""The checks that codes make by hand, as rows that are compared with those of the time histories."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..ground.motion import STANDARD_GRAVITY
from ..models.column.model import Column
from .kinematic import BEHAVIOUR_FACTOR, LIFE_SAFETY, Mechanism
from .limits import Limits
from .rigid_body import RigidBody, governing_body, sliding_distance
from .scaling import ScaledMotion
from .spectra import Spectral
from .table import MM, PERCENT, Row, Unit

NOT_IN_SPACE = (
    "by hand: nothing. The kinematic verification and ASCE 43 turn a body about one edge in a plane; `multiblock "
    "statics` pushes a structure over in any direction."
)
G = Unit("g", 1.0 / STANDARD_GRAVITY)


@dataclass(frozen=True, eq=False)
class ByHand:
    """The two methods by hand, and their rows under an action."""

    mechanism: Mechanism
    body: RigidBody
    rows: tuple[Row, ...]


def by_hand(
    column: Column,
    found: Mechanism,
    action: Spectral,
    smooth: bool,
    own_period: float,
    motions: tuple[ScaledMotion, ...],
    limits: Limits,
) -> ByHand:
    """Apply the kinematic verification and the approximate method of ASCE 43 under the spectrum of an action.

    Parameters
    ----------
    column : Column
        The column.
    found : Mechanism
        Its overturning mechanism.
    action : Spectral
        The spectrum of the action.
    smooth : bool
        Whether it is a spectrum of a code, else one of motions.
    own_period : float
        Period of the first mode (s).
    motions : tuple of ScaledMotion
        The motions, whose vertical peak reduces the friction.
    limits : Limits
        The limits of displacement, slip and friction.

    Returns
    -------
    ByHand
        The mechanism, the rigid body, and the rows of both methods.
    """
    rows = [
        Row(
            "kinematic, linear",
            float(action.psa(own_period)),
            BEHAVIOUR_FACTOR * found.a0,
            G,
            note=f"Circolare C8.7.1.2.1.7: alpha0 {found.alpha0:.3g}, e* {found.mass_part:.3g}, FC "
            f"{found.confidence_factor:g}, a0* {G.factor * found.a0:.3g} g, q {BEHAVIOUR_FACTOR:g}; spectrum at T1 "
            f"{own_period:.3g} s",
        ),
        Row(
            "kinematic, displacement",
            found.demand(action, own_period, smooth),
            found.capacity(),
            MM,
            note=f"Circolare C8.7.1.2.1.8: d0* {found.d0:.3g} m, {LIFE_SAFETY:g} d0* at SLV; spectrum of 8 % at TSLV "
            f"{found.period():.3g} s",
        ),
    ]
    # rocking of the rigid body, ASCE 43, A.2
    body = governing_body(column)
    angle = body.rotation(action, column.g) if body.restitution > 0.0 else math.nan
    note = (
        f"ASCE 43, A.2: b / h {body.slenderness:.3g}, C_R {body.restitution:.3g}; rotation over that on the edge, "
        f"{body.edge_angle:.3g} rad"
        if body.restitution > 0.0
        else "ASCE 43, A.2: does not apply, too stocky to rock"
    )
    rows.append(
        Row("rocking, rigid body", angle / body.edge_angle, limits.displacement, PERCENT, f"joint {body.joint}", note)
    )
    rows += _sliding(column, action, motions, limits)
    return ByHand(found, body, tuple(rows))


def _sliding(column: Column, action: Spectral, motions: tuple[ScaledMotion, ...], limits: Limits) -> list[Row]:
    """Return the row of the joint with the least friction, without its dowel; no row if no friction is known."""
    known = {
        i: float(given)
        for i, block in enumerate(column.blocks)
        if (given := limits.friction if block.joint.friction is None else block.joint.friction) is not None
    }
    if not known:
        return []
    i = min(known, key=lambda place: known[place])
    # slip of the joint under the spectrum and the largest vertical acceleration
    vertical = max(float(np.max(np.abs(scaled.motion.az))) for scaled in motions)
    slip = sliding_distance(known[i], vertical, action, column.g)
    dowel = "; the dowel is left out" if column.blocks[i].joint.dowel else ""
    note = f"ASCE 43, A.1: mu {known[i]:g}, vertical {G.factor * vertical:.3g} g; spectrum of 10 %{dowel}"
    return [Row("sliding, rigid body", slip, limits.slip * column.contacts[i].width, MM, f"joint {i + 1}", note)]
