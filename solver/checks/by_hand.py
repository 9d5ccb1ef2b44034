"""The checks that codes make by hand, as rows that are compared with those of the time histories."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..ground.motion import STANDARD_GRAVITY
from ..models.column.model import Column
from ..statics.rocking import rocking_part
from .action import Action
from .kinematic import BEHAVIOUR_FACTOR, LIFE_SAFETY, Mechanism
from .limits import Limits
from .rigid_body import RigidBody, sliding_distance
from .table import MM, PERCENT, Row, Unit

NOT_IN_SPACE = (
    "by hand: nothing. The kinematic verification and ASCE 43 turn a body about one edge in a plane; `multiblock "
    "statics` pushes a structure over in any direction."
)
G = Unit("g", 1.0 / STANDARD_GRAVITY)


@dataclass(frozen=True, eq=False)
class ByHand:
    """The mechanism of the kinematic verification, and the rows of both methods by hand under an action."""

    mechanism: Mechanism
    rows: tuple[Row, ...]


def by_hand(found: Mechanism, own_period: float, action: Action, limits: Limits) -> ByHand:
    """Apply the kinematic verification and the approximate method of ASCE 43 under an action.

    `found` is the overturning mechanism of the column, `own_period` the period of its first mode (s). The vertical peak
    of the motions reduces the friction.
    """
    column, spectrum = found.curve.model, action.spectrum
    smooth = spectrum is action.target  # a spectrum of a code, else one of motions
    rows = [
        Row(
            "kinematic, linear",
            float(spectrum.psa(own_period)),
            BEHAVIOUR_FACTOR * found.a0,
            G,
            note=f"Circolare C8.7.1.2.1.7: alpha0 {found.alpha0:.3g}, e* {found.mass_part:.3g}, FC "
            f"{found.confidence_factor:g}, a0* {G.factor * found.a0:.3g} g, q {BEHAVIOUR_FACTOR:g}; spectrum at T1 "
            f"{own_period:.3g} s",
        ),
        Row(
            "kinematic, displacement",
            found.demand(spectrum, own_period, smooth),
            LIFE_SAFETY * found.d0,
            MM,
            note=f"Circolare C8.7.1.2.1.8: d0* {found.d0:.3g} m, {LIFE_SAFETY:g} d0* at SLV; spectrum of 8 % at TSLV "
            f"{found.period:.3g} s",
        ),
    ]
    # rocking of the rigid body, ASCE 43, A.2
    body = RigidBody(*rocking_part(column))
    angle = body.rotation(spectrum, column.g) if body.restitution > 0.0 else math.nan
    note = (
        f"ASCE 43, A.2: b / h {body.slenderness:.3g}, C_R {body.restitution:.3g}; rotation over that on the edge, "
        f"{body.edge_angle:.3g} rad"
        if body.restitution > 0.0
        else "ASCE 43, A.2: does not apply, too stocky to rock"
    )
    rows.append(
        Row("rocking, rigid body", angle / body.edge_angle, limits.displacement, PERCENT, f"joint {body.joint}", note)
    )
    rows += _sliding(column, action, limits)
    return ByHand(found, tuple(rows))


def _sliding(column: Column, action: Action, limits: Limits) -> list[Row]:
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
    vertical = max(float(np.max(np.abs(scaled.motion.az))) for scaled in action.motions)
    slip = sliding_distance(known[i], vertical, action.spectrum, column.g)
    dowel = "; the dowel is left out" if column.blocks[i].joint.dowel else ""
    note = f"ASCE 43, A.1: mu {known[i]:g}, vertical {G.factor * vertical:.3g} g; spectrum of 10 %{dowel}"
    return [Row("sliding, rigid body", slip, limits.slip * column.contacts[i].width, MM, f"joint {i + 1}", note)]
