"""What a long run shows on a terminal: how far it is, and that kernels are being compiled."""

from __future__ import annotations

import sys
import time as clock
from types import TracebackType
from typing import Any, Self

from .ensemble import interruptible
from .first_run import are_kept, make_kernels
from .single_run import Glance

PATIENCE = 2.0  # s, for which nothing is shown


class Line:
    """A line of tqdm, if that is installed, for what takes longer than 2 s; to be used as a context."""

    def __init__(self, **form: Any) -> None:
        self._form = form  # as tqdm takes it
        self._begin = clock.monotonic()
        self._bar: Any = None

    def show(self, reached: float, total: float | None) -> None:
        """Draw how much of the total, if that is known, is reached."""
        if self._bar is None and clock.monotonic() - self._begin > PATIENCE:
            try:
                from tqdm import tqdm
            except ModuleNotFoundError:
                self._begin = float("inf")
                return
            self._bar = tqdm(total=total, initial=reached, leave=False, file=sys.stderr, **self._form)
        if self._bar is not None:
            self._bar.n = reached
            self._bar.refresh()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Wipe the line."""
        if self._bar is not None:
            self._bar.close()


class ProgressLine(Line):
    """A callback of `simulate`: the time reached, of `duration` s from `start` on."""

    def __init__(self, start: float, duration: float) -> None:
        super().__init__(bar_format="{percentage:3.0f}% |{bar}| {n:.4g} of {total:.4g} s")
        self._start, self._duration = start, duration

    def __call__(self, t: float, seen: Glance) -> None:
        """Show that time t, s, is reached."""
        self.show(min(self._duration, t - self._start), self._duration)


class RunsLine(Line):
    """A callback of `simulate_many` and `run_study`: runs done."""

    def __init__(self) -> None:
        super().__init__(unit="run")

    def __call__(self, done: int, total: int | None) -> None:
        """Show that so many runs are done."""
        self.show(done, total)


def compile_kernels() -> None:
    """Have the kernels that every run needs, and say so if they have to be compiled, which takes a while.

    They are made in a thread beside: an interruption is heard at once.
    """
    if not are_kept():
        print("compiling the kernels, once", flush=True)
        interruptible(make_kernels)
