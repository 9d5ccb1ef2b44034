"""The checks that codes make by hand, as rows beside those of the time histories, and where the two disagree."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

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
G = Unit("g", 1.0 / 9.80665)


@dataclass(frozen=True, eq=False)
class ByHand:
    """Both methods and what they ask for under an action."""

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
    """Kinematic verification and approximate method of ASCE 43 under the spectrum of an action.

    smooth: it is a spectrum of a code. own_period: of the first mode, s.
    """
    rows = [
        Row(
            "kinematic, linear",
            float(action.psa(own_period)),
            BEHAVIOUR_FACTOR * found.a0,
            G,
            note=f"Circolare C8.7.1.2.1.7: alpha0 {found.alpha0:.4g}, e* {found.mass_part:.3g}, FC "
            f"{found.confidence_factor:g}, a0* {found.a0 / 9.80665:.4g} g, q {BEHAVIOUR_FACTOR:g}; spectrum at T1 "
            f"{own_period:.3g} s",
        ),
        Row(
            "kinematic, displacement",
            found.demand(action, own_period, smooth),
            found.capacity(),
            MM,
            note=f"Circolare C8.7.1.2.1.8: d0* {found.d0:.4g} m, {LIFE_SAFETY:g} d0* at SLV; spectrum of 8 % at TSLV "
            f"{found.period():.3g} s",
        ),
    ]
    body = governing_body(column)
    angle = body.rotation(action, column.g) if body.restitution > 0.0 else math.nan
    note = (
        f"ASCE 43, A.2: b / h {body.slenderness:.4g}, C_R {body.restitution:.3g}; rotation over that on the edge, "
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
    """Of the joint with the least friction; none if no friction is known."""
    known = {
        i: float(given)
        for i, block in enumerate(column.blocks)
        if (given := limits.friction if block.joint.friction is None else block.joint.friction) is not None
    }
    if not known:
        return []
    i = min(known, key=lambda place: known[place])
    vertical = max(float(np.max(np.abs(scaled.motion.az))) for scaled in motions)
    slip = sliding_distance(known[i], vertical, action, column.g)
    note = f"ASCE 43, A.1: mu {known[i]:g}, vertical {vertical / 9.80665:.3g} g; spectrum of 10 %"
    return [Row("sliding, rigid body", slip, limits.slip * column.contacts[i].width, MM, f"joint {i + 1}", note)]
