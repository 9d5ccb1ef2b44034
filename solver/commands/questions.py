"""The questions of `new`, for a word or a number; on a terminal a wrong answer is asked for again."""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import NamedTuple, TypeVar

from ..common.errors import InputError, check_number
from ..common.files import with_point
from ..common.plausible import HIGHEST
from ..common.ranges import listed

T = TypeVar("T")

Limits = tuple[tuple[float, float], str]
# narrower than in a column file: a wrong answer is asked for again
SIZE: Limits = ((0.01, HIGHEST), f"a positive length in m, from 0.01 to {HIGHEST:g}")
HEIGHT: Limits = ((0.01, 300.0), "a positive length in m, from 0.01 to 300")


class Question(NamedTuple):
    """A question for a number: text, default, limits with their meaning, factor to SI.

    `usual` and `limits` may be functions of the answers before.
    """

    text: str
    usual: float | Callable[[dict[str, float]], float]
    limits: Limits | Callable[[dict[str, float]], Limits] = SIZE
    factor: float = 1.0


def choice(text: str, choices: dict[str, str], usual: str) -> str:
    """Ask for one of the choices, shown with their meanings, and return its word."""

    def chosen(answer: str) -> str:
        if answer not in choices:
            raise InputError(f"{text} = {answer}: must be one of {listed(choices, answer)}")
        return answer

    for key, meaning in choices.items():
        print(f"  {key}: {meaning}")
    return _accepted(text, usual, chosen)


def number(question: Question, asked: dict[str, float] | None = None) -> float:
    """Ask for a number, and return it in SI units; `asked`: the answers before."""
    usual = question.usual(asked or {}) if callable(question.usual) else question.usual
    limits = question.limits(asked or {}) if callable(question.limits) else question.limits
    return question.factor * _accepted(
        question.text, f"{usual:g}", lambda answer: parsed(question.text, answer, limits)
    )


def _accepted(text: str, usual: str, check: Callable[[str], T]) -> T:
    """Return the result of `check` on the answer, asking again on a terminal. Raises InputError elsewhere."""
    while True:
        answer = answer_to(text, usual)
        try:
            return check(answer)
        except InputError as error:
            if not sys.stdin.isatty():
                raise
            print(error)


def parsed(key: str, text: str, limits: Limits) -> float:
    """Parse a number within limits. Raises InputError."""
    (least, most), meaning = limits
    try:
        value = float(text)
    except ValueError:
        raise InputError(with_point(text) or f"{key} = {text}: must be {meaning}") from None
    if value > most and limits in (SIZE, HEIGHT) and value < 1e3 * most:
        meaning += f"; {text} mm are {1e-3 * value:g}"
    value = check_number(key, value, (least, most), meaning)
    if meaning.startswith("a whole number") and value != round(value):
        raise InputError(f"{key} = {text}: must be {meaning}")
    return value


def answer_to(text: str, usual: str) -> str:
    """Read the answer from the terminal or a pipe; an empty line takes the default, shown in brackets."""
    print(f"{text} [{usual}]: ", end="", flush=True)
    line = sys.stdin.readline()
    if not line:
        raise InputError(f"{text}: no answer, the input has ended")
    if not sys.stdin.isatty():
        print(line.strip())
    return line.strip() or usual
