"""A check repeated with other moduli and dampings of the joints, to see whether the answer depends on them."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from ..common.errors import InputError, InputWarning, SolverError
from .answer import FAILS, outcome_of
from .subject import subject_of

CHANGES = (("modulus", 0.5), ("modulus", 2.0), ("damping", 0.25), ("damping", 4.0))


@dataclass(frozen=True)
class OtherJoints:
    """The outcome of a check with another modulus or damping of all joints."""

    key: str  # modulus or damping
    factor: float
    outcome: str
    note: str  # how many fall, or why no run could be made

    @property
    def text(self) -> str:
        """The outcome, the change and the note."""
        return f"{self.outcome} with {self.factor:g} times the {self.key} ({self.note})"


def changed(model: Any, key: str, factor: float) -> Any:
    """Return the model with this factor on the modulus or the damping (`key`) of every joint. Raises InputError."""
    stiffness, damping = (factor, 1.0) if key == "modulus" else (1.0, factor)
    return model.scaled_joints([stiffness] * len(model.laws), [damping] * len(model.laws))


def other_joints(model: Any, confidence_factor: float, outcome_and_note: Any) -> tuple[OtherJoints, ...]:
    """Return the outcome of the check with each of `CHANGES`; empty for a model without joints.

    `outcome_and_note` is a function of the changed subject. Damping is changed only if some joint has it. A model that
    cannot be built or solved counts as FAILS.
    """
    found = []
    for key, factor in CHANGES if model.laws else ():
        if key == "damping" and not model.is_damped:
            continue
        try:
            with warnings.catch_warnings():  # warnings would concern values that the user has not given
                warnings.simplefilter("ignore", InputWarning)
                outcome, note = outcome_and_note(subject_of(changed(model, key, factor), confidence_factor))
        except (InputError, SolverError) as why:
            outcome, note = FAILS, str(why)
        found.append(OtherJoints(key, factor, outcome, note))
    return tuple(found)


def joints_sentence(rows: Sequence[Any], others: Sequence[OtherJoints]) -> str:
    """Return the sentence on whether the answer of the rows changes with other joints, and what to measure then."""
    if not others:
        return "Whether the answer hangs on the modulus or the damping of the joints was not tried."
    own = outcome_of([row for row in rows if row.name != "overturning, margin"])  # not computed with other joints
    tried = ", ".join(f"{one.factor:g} times the {one.key}" for one in others)
    hangs = list(dict.fromkeys(one.key for one in others if one.outcome != own))
    if not hangs:
        return f"The answer stays with other joints: {tried}."
    said = "; ".join(one.text for one in others if one.key in hangs)
    which = " and on the ".join(hangs)
    return f"The answer hangs on the {which}: measure {'it' if len(hangs) == 1 else 'them'}. {said}."
