"""The progress of a long run on a terminal."""

from __future__ import annotations

import sys
import time as clock
from typing import Any, Self

from ..common.digits import percent
from ..ground.motion import Motion
from ..runs.simulate import simulate

PATIENCE = 2.0  # s, before which nothing is shown
FIRST_LINE, LONGER = 10.0, 1.5  # s until the first line in a pipe; factor from the time of a line to that of the next


class Line:
    """A context with a progress line of tqdm (a bar in a notebook), for work that takes longer than 2 s."""

    def __init__(self, **form: Any) -> None:
        self._form = form  # as tqdm takes it
        self._begin = clock.monotonic()
        self._bar: Any = None

    def show(self, reached: float, total: float | None) -> None:
        """Draw the share of the total, if known, that is reached."""
        if self._bar is None and clock.monotonic() - self._begin > PATIENCE:
            from tqdm import auto

            self._bar = auto.tqdm(total=total, initial=reached, leave=False, file=sys.stderr, **self._form)
        if self._bar is not None:
            self._bar.n = reached
            self._bar.refresh()

    def begin(self, phase: str) -> None:
        """Start again for the runs of a phase, whose name the line then shows."""
        self.__exit__()
        self._bar, self._begin = None, clock.monotonic()
        self._form["desc"] = phase

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        """Clear the line."""
        if self._bar is not None:
            self._bar.close()


def simulated(subject: Any, motion: Motion, duration: float | None, **options: Any) -> Any:
    """Call `simulate` with a progress line on a terminal: the time reached, of the duration."""
    whole = motion.duration if duration is None else duration
    with Line(bar_format="{percentage:3.0f}% |{bar}| {n:.4g} of {total:.4g} s") as line:

        def show(t: float, seen: object) -> None:
            line.show(min(whole, t - motion.start), whole)

        return simulate(subject, motion, duration, callback=show if sys.stderr.isatty() else None, **options)


class RunsLine(Line):
    """A callback of `simulate_many` and `run_study` that shows the number of runs made."""

    def __init__(self) -> None:
        super().__init__(unit="run")

    def __call__(self, done: int, total: int | None) -> None:
        """Show that `done` of `total` runs are made."""
        self.show(done, total)


class PlainLine(Line):
    """The progress in a file or a pipe: a line after 10 s, and then at increasing intervals."""

    def __init__(self) -> None:
        super().__init__()
        self._next = FIRST_LINE
        self._before: int | None = None  # runs made before the first call

    def begin(self, phase: str) -> None:
        """Start again for the runs of a phase, whose name the lines then begin with."""
        super().begin(phase)
        self._next, self._before = FIRST_LINE, None

    def __call__(self, done: int, total: int | None) -> None:
        """Print the number of runs made, and the estimated time left."""
        took = clock.monotonic() - self._begin
        if self._before is None:
            self._before = done
        if took < self._next or total is None:
            return
        self._next = took * LONGER
        pace = (done - self._before) / took
        left = f", {(total - done) / pace:.0f} s left" if pace > 0.0 else ""
        phase = f"{self._form['desc']}: " if "desc" in self._form else ""
        print(
            f"{phase}{done} of {total} runs, {percent(done / total, '.0f')}, after {took:.0f} s{left}",
            file=sys.stderr,
            flush=True,
        )
