"""A structure in space under a check: the subject that two horizontal components shake."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..column.friction import friction_history
from ..common.errors import InputError
from ..dynamics.uncertainty import Spread
from ..ground.motion import Motion
from ..runs.table import Table
from ..space.ensemble import vary
from ..space.modes import modes_in_space
from ..space.response import SpatialResponse
from ..space.rest import rest_of
from ..space.structure import Structure
from .action import Action
from .kinematic import rocking_period
from .limits import Limits
from .subject import FloatArray, Joints, Pair

# s on a still base: of 53 falls of a trilith, a podium and an arch, which were followed for 60 s, one came after the
# end of the motion, by 1.4 s, while 17 of 96 runs still rocked after 60 s
SETTLE = 10.0
WHOLE = SETTLE - 1e-6  # s, less rounding
CARRIES = 1e-3  # of all weight: what a joint counts as carrying, at least


@dataclass(frozen=True, eq=False)
class InSpace:
    """A structure as subject of a check. Raises InputError if it has no stable rest."""

    model: Structure
    confidence_factor: float
    word = "structure"
    across = True
    two_ways = True  # turned by half a turn
    settle = SETTLE
    edge = math.nan
    of_model = (
        "The blocks move in space. Blocks that no joint connects do not meet, and contacts do not move as faces slide.",
        f"A run that still rocks {SETTLE:g} s after the motion counts as standing: rocking in space decays slowly.",
        "Once a block has fallen the run ends; what it hits is not considered.",
    )

    def __post_init__(self) -> None:
        if not self.model.weight > 0.0:
            raise InputError(f"g = {self.model.g}: must be positive, without weight nothing falls")
        rest_of(self.model)

    @cached_property
    def joints(self) -> Joints:
        """The joints by the names of the blocks that they connect."""
        beds = [joint.bed for joint in self.model.joints]
        return Joints(
            names=self.model.joint_names,
            width=np.array([joint.face.width for joint in self.model.joints]),
            strength=np.array([bed.strength or math.nan for bed in beds]),
            friction=np.array([math.nan if bed.friction is None else bed.friction for bed in beds]),
        )

    @cached_property
    def yields(self) -> FloatArray:
        """Forces at which the ties yield, N."""
        return np.array([tie.yield_ or math.nan for tie in self.model.ties])

    @cached_property
    def period(self) -> float:
        """Of the first mode about rest, s."""
        return 1.0 / float(modes_in_space(self.model).frequency[0])

    @property
    def longest(self) -> float:
        """Period of a rigid block whose centroid is as high, s: it does not depend on the width."""
        blocks = self.model.blocks
        height = sum(block.mass * float(block.centroid[2]) for block in blocks) / sum(block.mass for block in blocks)
        return rocking_period(height, self.model.g, self.confidence_factor)

    def verdict(self, run: SpatialResponse) -> str:
        """Of the run; if it still rocks after SETTLE it stands."""
        rocks = run.verdict == "undecided" and run.stats["settled_for"] >= WHOLE
        return "standing" if rocks else run.verdict

    def moved(self, run: SpatialResponse) -> float:
        """Largest horizontal displacement of a block, m."""
        return float(np.max(run.peaks["u"]))

    def slips(self, run: SpatialResponse) -> FloatArray:
        """Slip of each joint since rest, m (rows, joints)."""
        found: FloatArray = run.slip - run.slip[0]
        return found

    def shear_ratio(self, run: SpatialResponse) -> FloatArray:
        """Shear over compression of each joint (rows, joints)."""
        carried = np.maximum(run.N[0], CARRIES * self.model.weight)
        return friction_history(np.hypot(run.Tx, run.Ty), run.N, carried)

    def tensions(self, run: SpatialResponse) -> FloatArray:
        """Largest force of each tie, N."""
        return run.peaks["tie"]

    def to_vary(self, run: SpatialResponse) -> Structure:
        """The structure."""
        return self.model

    def vary(self, model: Structure, motion: Motion, spread: Spread, rng: np.random.Generator) -> Pair:
        """A structure and a motion with varied data."""
        return vary(model, motion, spread, rng)

    def kept(self, peaks: bool) -> tuple[str, ...]:
        """Verdicts, and with peaks displacements of the blocks."""
        return ("peak_u", "verdict", "settled_for", "overturn_time") if peaks else ("verdict", "settled_for")

    def verdicts(self, table: Table) -> NDArray[np.str_]:
        """Of each run; those that still rock after SETTLE stand, those that failed are undecided."""
        found = table["verdict"]
        rocks = (found == "undecided") & (table["settled_for"] >= WHOLE)
        return np.where(rocks, "standing", found)

    def tops(self, table: Table) -> FloatArray:
        """Largest horizontal displacements, m."""
        found: FloatArray = np.max(table["peak_u"], axis=1)
        return found

    def by_hand(self, action: Action, limits: Limits) -> None:
        """None: both methods are for what turns in a plane about one edge."""
        return

    def digest(self) -> bytes:
        """The arrays of the kernels, strengths and names."""
        arrays = [np.ascontiguousarray(array) for array in self.model.model]
        parts = [array.tobytes() for array in (*arrays, self.joints.strength, self.yields)]
        return b"".join([*parts, repr((self.model.name, self.model.names)).encode()])
