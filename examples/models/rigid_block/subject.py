"""The block under a check."""

import math

from solver.checks.kinematic import rocking_period
from solver.checks.subject import Subject, subject_of

from .block import Block

SMALL = 0.9  # 1 - amplitude over alpha, at which its period is given


@subject_of.register(Block)
class BlockSubject(Subject):
    """The checks of one rigid block; all else is as of any model without joints."""

    of_model = ("The block does not slide, and does not leave the floor.",)

    @property
    def period(self) -> float:
        """The period of rocking by a tenth of alpha, s (Housner's equation 8)."""
        return 4.0 / self.model.p * math.acosh(1.0 / SMALL)

    @property
    def longest(self) -> float:
        """Period when it rocks by 0.4 of what overturns it, s."""
        return rocking_period(0.5 * self.model.height, self.model.g, self.confidence_factor)

    @property
    def edge(self) -> float:
        """Displacement of the top at which it balances, m."""
        return float(self.model.height * self.model.alpha)
