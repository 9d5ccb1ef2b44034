"""A structure in space under a check: the subject that two horizontal components shake."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..common.errors import InputError
from ..models.column.response import friction_history
from ..models.protocol import SETTLE
from ..models.structure.model import Structure
from ..models.structure.modes import frequencies_at_rest, sliding_frequencies
from ..models.structure.overlap import Overlap
from ..models.structure.response import SpatialResponse
from ..models.structure.rest import rest_of
from ..models.structure.stack import highest_alone
from ..statics.rocking import restitution_sentence, rocking_part
from .kinematic import rocking_period
from .spectra import FloatArray
from .subject import JointProperties, Subject, subject_of

CARRIES = 1e-3  # least carried load of a joint over the whole weight


@subject_of.register(Structure)
@dataclass(frozen=True, eq=False)
class InSpace(Subject):
    """A structure as subject of a check. Raises InputError if it has no stable rest."""

    model: Structure
    two_ways = True  # a motion and the same turned by half a turn differ
    of_model = (
        "The blocks move in space. Contacts move as faces slide. Blocks meet over joints and as neighbours alone.",
        f"A run that still rocks {SETTLE:g} s after the motion is undecided: rocking in space decays slowly.",
        "Once a block has fallen the run ends; what it hits is not considered.",
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.model.weight > 0.0:
            raise InputError(f"g = {self.model.g}: must be positive, without weight nothing falls")
        rest_of(self.model)

    @cached_property
    def joints(self) -> JointProperties:
        """The joints, named after the blocks that they connect."""
        found = JointProperties.of(
            self.model.joint_names, [joint.face.width for joint in self.model.joints], self.model.laws
        )
        if self.model.bearings:  # bearings are meant to slide: their displacement is compared, not their slip
            first = len(self.model.joints) - len(self.model.bearings)
            found.width[first:], found.friction[first:] = math.nan, 0.0
        return found

    @cached_property
    def bearings(self) -> tuple[tuple[str, ...], FloatArray]:
        capacity = [joint.bearing.capacity for joint in self.model.bearings if joint.bearing is not None]
        return self.model.bearing_names, np.array(capacity)

    @property
    def neighbours(self) -> tuple[str, ...]:
        return self.model.pair_names

    @property
    def bonds(self) -> tuple[str, ...]:
        return self.model.bond_names

    @cached_property
    def yields(self) -> FloatArray:
        return np.array([tie.yield_ or math.nan for tie in self.model.ties])

    @cached_property
    def period(self) -> float:
        return 1.0 / float(frequencies_at_rest(self.model)[0])

    @property
    def longest(self) -> float:
        """The period (s) of a rigid block with its centroid at the same height; it does not depend on the width."""
        blocks = self.model.blocks
        height = sum(block.mass * float(block.centroid[2]) for block in blocks) / sum(block.mass for block in blocks)
        return rocking_period(height, self.model.g, self.confidence_factor)

    @cached_property
    def isolated(self) -> float:
        if not self.model.bearings:
            return 0.0
        slowest = float(sliding_frequencies(self.model)[0])
        return 1.0 / slowest if slowest > 0.0 else math.inf

    @property
    def restitution(self) -> str:
        """The sentence on the restitution of the column, or of the most slender block that carries nothing."""
        alone = [] if self.planar else highest_alone(self.model)
        if not alone:
            return super().restitution
        slender = min(alone, key=lambda column: rocking_part(column).slenderness)
        return f"{slender.name}, alone on its joint: {restitution_sentence(slender)}"

    def shear_ratio(self, run: SpatialResponse) -> FloatArray:
        carried = np.maximum(run.N[0], CARRIES * self.model.weight)
        return friction_history(np.hypot(run.Tx, run.Ty), run.N, carried)

    def overlap(self, run: SpatialResponse) -> Overlap | None:
        """Return the overlap of its blocks, or None for a single block that does not pass into the base."""
        return run.overlap if self.model.n > 1 or run.overlap.between else None

    def digest(self) -> bytes:
        """Return the bytes of the kernel arrays, strengths and names."""
        parts = [array.tobytes() for array in (self.model.model.numbers, self.joints.strength, self.yields)]
        return b"".join([*parts, repr((self.model.name, self.model.names)).encode()])
