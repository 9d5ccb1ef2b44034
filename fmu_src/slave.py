"""The FMI lifecycle of one column: parameters in, steps made, outputs read. The numbers are the solver's.

The wrapper knows three answers only: OK; Discard, when do_step returns False; and Fatal, when an exception reaches it,
which would leave a dead instance behind. A step that cannot be made is discarded; whatever else is wrong ends in an
exception whose damage is undone first (host.survive_exception), so that reset and free still work.
"""

from __future__ import annotations

import json
import math
import sys
from pathlib import Path
from typing import Any, NoReturn
from xml.etree.ElementTree import Element

from pythonfmu import Fmi2Slave
from pythonfmu.enums import Fmi2Status

from solver import __version__
from solver.column import Column
from solver.kernels.layout import INPUT_AX, INPUT_AZ, row_size
from solver.stepper import Stepper

from .host import finalize_at_exit, survive_exception
from .model_description import LOG_CATEGORIES, model_description
from .variables import (
    AX,
    AZ,
    INPUTS,
    OVERTURN_JOINT,
    OVERTURN_TIME,
    OVERTURNED,
    column_from,
    parameter_names,
    variables,
)

COLUMN_FILE = "column.json"
GUID_FILE = "guid.txt"
TIME_SLACK = 1e-6  # of a step: how far a communication point may be from where the last step ended


class ColumnSlave(Fmi2Slave):  # type: ignore[misc]
    """A column of blocks as a co-simulation slave; `resources` holds its column.json and guid.txt."""

    log_categories = LOG_CATEGORIES

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        resources = Path(self.resources)
        finalize_at_exit(resources)
        self._column = Column.from_dict(json.loads((resources / COLUMN_FILE).read_text(encoding="utf-8")))
        self._table = variables(self._column)
        self._reference = {variable.name: k for k, variable in enumerate(self._table)}
        self._values: list[Any] = [variable.start for variable in self._table]
        first = len(INPUTS)
        self._row = slice(first, first + row_size(self._column.n))
        self._values[self._row] = [0.0] * row_size(self._column.n)
        self._put(OVERTURN_TIME.name, -1.0)
        self._put(OVERTURN_JOINT.name, 0)
        self._put(OVERTURNED.name, False)
        self._stepper: Stepper | None = None
        self._time = 0.0
        self._initialized = False
        self._outdated = False  # whether the outputs belong to an earlier time or input
        self.modelName = self._column.name
        guid = resources / GUID_FILE
        if guid.is_file():
            self.guid = guid.read_text(encoding="utf-8").strip()

    def to_xml(self, model_options: dict[str, str] | None = None) -> Element:
        """The model description; every flag comes from fmu_src/model_description.py."""
        blocks = "block" if self._column.n == 1 else "blocks"
        text = f"Column of {self._column.n} rigid {blocks} with no-tension elastic joints under base acceleration"
        return model_description(self._column.name, str(self.guid), text, __version__, self._table)

    # --- lifecycle

    def setup_experiment(self, start_time: float, stop_time: float | None, tolerance: float | None) -> None:
        """Take the start time; the solver's own tolerance is a parameter."""
        if not math.isfinite(start_time):
            self._fail(f"start time = {start_time}: must be a finite time in s")
        self._time = start_time

    def exit_initialization_mode(self) -> None:
        """Build the column from the parameters as they stand."""
        self._build()
        self._initialized = True

    def do_step(self, current_time: float, step_size: float) -> bool:
        """Advance by step_size, s, holding the inputs; False (Discard) with a logged reason if it cannot be done."""
        try:
            reason = self._step_problem(current_time, step_size)
            if reason is None:
                assert self._stepper is not None
                self._set_inputs(self._stepper)
                self._stepper.advance(current_time, step_size)
                self._time = current_time + step_size
                self._outdated = True
                return True
        except Exception as error:
            reason = str(error) or repr(error)
        self._say(Fmi2Status.discard, f"step from t = {current_time} s of {step_size} s not made: {reason}")
        return False

    def _step_problem(self, current_time: float, step_size: float) -> str | None:
        """Why a step cannot even be tried."""
        if not self._initialized:
            return "the slave is not initialized"
        if not (math.isfinite(step_size) and step_size > 0.0):
            return "the step must be a positive time"
        if not abs(current_time - self._time) <= TIME_SLACK * step_size + 1e-12 * abs(self._time):
            return f"the last step ended at t = {self._time} s"
        for k, variable in enumerate(INPUTS):
            if not math.isfinite(self._values[k]):
                return f"{variable.name} = {self._values[k]}: must be a finite acceleration in m/s2"
        return None

    # --- variables

    def get_real(self, vrs: list[int]) -> list[float]:
        """Values of Real variables; outputs are brought up to date with time and inputs first."""
        return self._get(vrs)

    get_integer = get_boolean = get_string = get_real

    def set_real(self, vrs: list[int], values: list[float]) -> None:
        """Set inputs at any time, parameters before the end of initialization."""
        for reference, value in zip(vrs, values, strict=True):
            if reference not in (AX, AZ):
                self._check_settable(reference)
            self._values[reference] = value
        self._outdated = True

    set_integer = set_boolean = set_string = set_real

    def _get(self, vrs: list[int]) -> list[Any]:
        try:
            if self._outdated:
                self._update()
            return [self._values[reference] for reference in vrs]
        except Exception as error:
            self._fail(f"outputs at t = {self._time} s: {str(error) or repr(error)}")

    def _check_settable(self, reference: int) -> None:
        known = 0 <= reference < len(self._table)
        if not known or self._table[reference].causality != "parameter":
            self._fail(f"value reference {reference}: is not an input or a parameter")
        if self._initialized:
            self._fail(f"{self._table[reference].name}: can be set before the end of initialization only")

    def _update(self) -> None:
        """Bring the outputs up to date."""
        if self._stepper is None:
            return  # not initialized: start values
        self._set_inputs(self._stepper)
        self._values[self._row] = self._stepper.observe(self._time).tolist()
        joint = self._stepper.overturned_joint
        self._put(OVERTURN_JOINT.name, joint)
        self._put(OVERTURNED.name, joint > 0)
        self._put(OVERTURN_TIME.name, self._stepper.overturn_time if joint else -1.0)
        self._outdated = False

    def _set_inputs(self, stepper: Stepper) -> None:
        stepper.inputs[INPUT_AX] = self._values[AX]
        stepper.inputs[INPUT_AZ] = self._values[AZ]

    def _build(self) -> None:
        try:
            column = column_from(self._column.name, self._column.n, lambda name: self._values[self._reference[name]])
            self._stepper = Stepper(column)
        except Exception as error:
            self._fail(parameter_names(str(error) or repr(error)))
        self._outdated = True

    def _put(self, name: str, value: float | int | bool) -> None:
        self._values[self._reference[name]] = value

    # --- what is said

    def _say(self, status: Fmi2Status, message: str) -> None:
        """To the master's logger, and to stderr for those who did not turn it on."""
        self.log(message, status)
        print(f"{self.instance_name}: {message}", file=sys.stderr)

    def _fail(self, message: str) -> NoReturn:
        """Say why and leave through the wrapper's only way out, with the instance alive behind it."""
        self._say(Fmi2Status.error, message)
        survive_exception(self, type(self), self.log_queue)
        raise RuntimeError(message)
