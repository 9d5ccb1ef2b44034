"""Columns by the equations of the paper as a kind of model, with other kernels, lanes, coordinates and steps."""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import replace
from functools import lru_cache

import numpy as np

from ...common.errors import InputError
from ...ground.motion import STANDARD_GRAVITY
from ...kernels.column.sections.faces import RECTANGLE
from ...kernels.machine.library import load
from ...kernels.paper import entries
from ..column.kind import Columns
from ..column.kinematics import Chain, ColumnPhase, from_base, over_below
from ..column.lane_policy import common_reason_against_lanes
from ..column.lanes import LaneKernels
from ..column.linearization import SHORT, StillColumn, undamped
from ..column.model import Column
from ..column.modes import PART
from ..column.packing import FloatArray
from ..column.response import Response
from ..protocol import Lanes, RunPlan, Work

# cost of a run alone, relative to a column of the exact formulation in lanes; and s, the same times the step in lanes
ALONE, IN_LANES = 300.0, 1.3e-3
SLACK = 1e-6  # relative accuracy of the longest stable step


class PaperChain(Chain):
    """A column whose coordinates are the displacements v of the top faces and the settlements w of the blocks (m).

    Rotations and openings follow from v and w to first order.
    """

    safe = 0.9  # part of the barrier, for the terms that the first order neglects

    def places(self, phase: FloatArray) -> ColumnPhase:
        """Return the rotations and openings of a phase, and their rates."""
        v, w, v_rate, w_rate = (over_below(phase[..., k : k + self.n]) for k in range(0, 4 * self.n, self.n))
        return ColumnPhase(v / self.height, -w, v_rate / self.height, -w_rate)

    @staticmethod
    def coordinates(height: FloatArray, theta: FloatArray, opening: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return v and w, or their rates, from rotations and openings, or their rates."""
        return from_base(height * theta), -from_base(opening)

    def top_displacements(self, phase: FloatArray) -> FloatArray:
        """Return v (m), (..., n)."""
        return phase[..., : self.n].copy()

    def centroid_displacements(self, phase: FloatArray) -> FloatArray:
        """Return the displacements of the centroids to first order, m (..., n)."""
        return self.top_displacements(phase) - (self.height - self.centroid) * self.places(phase).theta

    def top_velocities(self, phase: FloatArray) -> FloatArray:
        """Return the rates of v (m/s), (..., n)."""
        return phase[..., 2 * self.n : 3 * self.n].copy()


class PaperColumns(Columns):
    """The kind of columns with settings.formulation "paper"."""

    entries = entries
    chain = PaperChain
    own_lanes = LaneKernels(entries.run_fixed_steps, stages=1)
    fixed = True

    @staticmethod
    def check_step(column: Column) -> None:
        """Raise InputError for a step that is not stable."""
        step = column.settings.step
        if step > SHORT and step > (most := longest_stable_step(column.with_settings(step=SHORT))) * (1.0 + SLACK):
            limit = f"must be at most {most:.4g} s, where central differences are stable"
            raise InputError(f"solver.step = {step}: {limit}")

    def lanes(self, model: Column, keep: Collection[str]) -> Lanes:
        """Return how runs are made in lanes: all columns of equal numbers of blocks share them."""
        return Lanes(self.reason_for_single_run(model, keep), (model.n, "paper"), model.settings.step)

    @staticmethod
    def why_not(model: Column) -> str:
        """Return the reason against lanes, which have rectangles only, or ""."""
        others = "" if model.sections <= {RECTANGLE} else "formulation paper with other joints than rectangles"
        return common_reason_against_lanes(model) or others

    def load(self, model: Column, keep: Collection[str]) -> None:
        load(entries.run_fixed_steps.group)

    def work(self, model: Column, keep: Collection[str]) -> Work:
        return Work(
            0.0, model.n * (ALONE if self.reason_for_single_run(model, keep) else IN_LANES / model.settings.step)
        )

    def in_lanes(self, response: Response, plan: RunPlan) -> bool:
        """Return False: lanes store no rows."""
        return False


KIND = PaperColumns()


@lru_cache(maxsize=64)
def longest_stable_step(column: Column) -> float:
    """Return the stable limit of the step (s), 2 / (omega (sqrt(1 + d^2) + d)), of the column in full contact.

    omega is the angular frequency of the highest mode, and d = eta omega counts because rates are extrapolated
    explicitly: a mode x'' + eta omega^2 x' + omega^2 x = 0, stepped as in kernels/paper/stepping.py, reaches the
    amplification factor -1 where (omega h)^2 / 4 + d omega h = 1. Joints that open only become softer. Without gravity
    they are assumed closed.
    """
    still = StillColumn(undamped(replace(column, g=column.g or STANDARD_GRAVITY)))
    omega = math.sqrt(np.max(np.abs(np.linalg.eigvals(still.stiffness(still.rest, PART)))))
    d = omega * max(block.joint.damping for block in column.blocks)
    return 2.0 / (omega * (math.hypot(1.0, d) + d))
