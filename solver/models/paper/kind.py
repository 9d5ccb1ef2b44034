"""Columns by the equations of the paper as a kind of model: columns with other kernels, lanes and coordinates."""

from __future__ import annotations

from collections.abc import Collection

from ...kernels.machine.library import load
from ...kernels.paper import entries
from ..column.kind import Columns
from ..column.lane_policy import why_no_lanes
from ..column.lanes import LaneKernels
from ..column.model import Column
from ..column.response import Response
from ..protocol import Lanes, Plan, Work
from .kinematics import PaperChain
from .stability import check_step

# cost of a run alone, relative to a column of the exact formulation in lanes; and s, the same times the step in lanes
ALONE, IN_LANES = 300.0, 1.3e-3


class PaperColumns(Columns):
    """The kind of columns with settings.formulation "paper"."""

    entries = entries
    chain = PaperChain
    own_lanes = LaneKernels(entries.run_fixed_steps, stages=1)
    fixed = True
    check_step = staticmethod(check_step)

    def lanes(self, model: Column, keep: Collection[str]) -> Lanes:
        """Return how runs are made in lanes: all columns of equal numbers of blocks share them."""
        return Lanes(self.why_alone(model, keep), (model.n, "paper"), model.settings.step)

    @staticmethod
    def why_not(model: Column) -> str:
        """Return the reason against lanes, which have rectangles only, or ""."""
        others = "" if model.has_rectangles_only else "formulation paper with other joints than rectangles"
        return why_no_lanes(model) or others

    def load(self, model: Column, keep: Collection[str]) -> None:
        """Load the kernels of these lanes."""
        load_lanes()

    def work(self, model: Column, keep: Collection[str]) -> Work:
        """Return the approximate cost, which depends on the step in lanes."""
        return Work(0.0, model.n * (ALONE if self.why_alone(model, keep) else IN_LANES / model.settings.step))

    def in_lanes(self, response: Response, plan: Plan) -> bool:
        """Return False: lanes store no rows."""
        return False


KIND = PaperColumns()


def load_lanes() -> None:
    """Load the kernels of lanes into this process."""
    load(entries.run_fixed_steps.group)
