"""A state is got, set, serialized and restored."""

from __future__ import annotations

from collections.abc import Callable
from math import sin
from pathlib import Path
from typing import Any

from support.instance import Instance


def drive(column: Instance, first: int, last: int) -> list[float]:
    """Shake a column hard enough to rock, by steps and slopes that differ from one to the next; all outputs."""
    t = sum(1e-3 * (1 + k % 7) for k in range(first))
    for k in range(first, last):
        h = 1e-3 * (1 + k % 7)
        column.set({"base.ax": 1.5 * sin(12.6 * t), "base.az": 0.2 * sin(40.0 * t), "base.jx": 5.0 * sin(3.0 * t)})
        column.step(t, h)
        t += h
    return column.get()


def bits(values: list[Any]) -> list[str]:
    """Return every digit of some numbers."""
    return [float(value).hex() for value in values]


def life(
    fmu: str, moved: Callable[[Instance, int, int], list[Any]], steps: int, changed: dict[str, float]
) -> dict[str, bool]:
    """State kept, serialized, set elsewhere; reset; another parameter, which is a part of it.

    moved: makes steps from one number to another, and gives all outputs.
    """
    body = Instance(fmu)
    first = bits(body.get())
    moved(body, 0, steps)
    saved = body.fmi.getFMUState()
    data = body.fmi.serializeFMUstate(saved)
    end = bits(moved(body, steps, 2 * steps))
    body.fmi.setFMUState(saved)
    found = {"further on": bits(moved(body, steps, 2 * steps)) == end}
    body.fmi.setFMUState(saved)
    body.set(changed)
    found["what is changed acts"] = bits(moved(body, steps, 2 * steps)) != end
    body.fmi.setFMUState(saved)
    found["it is part of the state"] = bits(moved(body, steps, 2 * steps)) == end
    other = Instance(fmu, initialize=False)
    other.fmi.setFMUState(other.fmi.deSerializeFMUstate(data))
    found["elsewhere"] = bits(moved(other, steps, 2 * steps)) == end
    body.fmi.reset()
    body.initialize()
    found["reset"] = bits(body.get()) == first
    found["again"] = bits(moved(body, 0, 2 * steps)) == end
    return found


def go_on(fmu: str) -> dict[str, bool]:
    """Return the results that are the same to the last bit after a state has been set again."""
    column = Instance(fmu)
    drive(column, 0, 150)
    at_save = bits(column.get())
    saved = column.fmi.getFMUState()
    first = bits(drive(column, 150, 300))
    column.set({"joint[2].damping": 4e-3})
    further = bits(drive(column, 300, 400))
    column.fmi.setFMUState(saved)
    same = {"at once": bits(column.get()) == at_save, "further on": bits(drive(column, 150, 300)) == first}
    column.set({"joint[2].damping": 4e-3})
    tuned = column.fmi.getFMUState()
    same["with another damping"] = bits(drive(column, 300, 400)) == further
    column.fmi.setFMUState(saved)
    column.fmi.setFMUState(tuned)
    same["from the later state"] = bits(drive(column, 300, 400)) == further
    column.fmi.freeFMUState(saved)
    column.fmi.freeFMUState(tuned)
    column.close()
    return same | {"changes with the damping": first != further}


def with_a_wrong_parameter(fmu: str) -> bool:
    """Return True if a state saved while `g` stood wrong goes on once it is right, after serializing too."""
    column = Instance(fmu)
    drive(column, 0, 50)
    column.set({"g": float("nan")})
    saved = column.fmi.getFMUState()
    column.fmi.setFMUState(saved)
    column.set({"g": 9.80665})
    first = bits(drive(column, 50, 100))
    read = column.fmi.deSerializeFMUstate(column.fmi.serializeFMUstate(saved))
    column.fmi.setFMUState(read)
    column.set({"g": 9.80665})
    same = bits(drive(column, 50, 100)) == first
    column.fmi.freeFMUState(saved)
    column.fmi.freeFMUState(read)
    column.close()
    return same


def retuned(fmu: str) -> bool:
    """Return True if a state whose tunable parameter has acted on outputs, but on no step, goes on once serialized."""
    column = Instance(fmu)
    drive(column, 0, 50)
    column.set({"joint[2].damping": 4e-3})
    column.get()
    saved = column.fmi.getFMUState()
    first = bits(drive(column, 50, 100))
    column.fmi.setFMUState(column.fmi.deSerializeFMUstate(column.fmi.serializeFMUstate(saved)))
    same = bits(drive(column, 50, 100)) == first
    column.close()
    return same


def fall(fmu: str) -> dict[str, bool]:
    """Let a column fall, stand again, be fallen again, and fall again."""
    verdict = ("overturned", "overturn_time", "overturn_joint")
    column = Instance(fmu, {"base.ax": 4.0})
    saved = column.fmi.getFMUState()
    column.step(0.0, 8.0)
    fallen = column.get(*verdict, "block[1].ux")
    after = column.fmi.getFMUState()
    column.fmi.setFMUState(saved)
    found = {"fell": bool(fallen[0]), "stands again": column.get(*verdict) == [False, -1.0, 0]}
    column.fmi.setFMUState(after)
    found["fallen again"] = column.get(*verdict, "block[1].ux") == fallen
    column.fmi.setFMUState(saved)
    column.step(0.0, 8.0)
    return found | {"falls again": column.get(*verdict, "block[1].ux") == fallen}


def half(fmu: str, state: str, values: dict[str, float | str]) -> list[str]:
    """Make half a run, write its state to a file, and make the rest of the run."""
    column = Instance(fmu, values)
    drive(column, 0, 150)
    Path(state).write_bytes(column.fmi.serializeFMUstate(column.fmi.getFMUState()))
    return bits(drive(column, 150, 300))


def other_half(fmu: str, state: str) -> list[str]:
    """Make the rest of the run from the file."""
    column = Instance(fmu, initialize=False)
    column.fmi.setFMUState(column.fmi.deSerializeFMUstate(Path(state).read_bytes()))
    return bits(drive(column, 150, 300))


def back(fmu: str, values: dict[str, float | str]) -> bool:
    """Return True if outputs after a state has been set are those from when it was got."""
    column = Instance(fmu, values)
    before = drive(column, 0, 150)
    saved = column.fmi.getFMUState()
    drive(column, 150, 160)
    column.fmi.setFMUState(saved)
    return bits(column.get()) == bits(before)


def back_and_on(fmu: str, state: str, values: dict[str, float | str]) -> tuple[bool, list[str]]:
    """Do as `half`, and return whether the rest is the same again from the state that was got, whatever was tuned in
    between.
    """
    column = Instance(fmu, values)
    drive(column, 0, 150)
    saved = column.fmi.getFMUState()
    Path(state).write_bytes(column.fmi.serializeFMUstate(saved))
    first = bits(drive(column, 150, 300))
    column.set({"joint[1].damping": 1e-2})
    drive(column, 300, 310)
    column.fmi.setFMUState(saved)
    return bits(drive(column, 150, 300)) == first, first


def refused(fmu: str, state: str) -> str:
    """Return the answer of an instance to a state that is not its own; fails unless the instance works as before
    afterwards.
    """
    column = Instance(fmu, {"base.ax": 1.0})
    column.step(0.0, 0.1)
    before = column.get()
    read = column.fmi.deSerializeFMUstate(Path(state).read_bytes())
    heard = column.attempt("setFMUState", read)
    assert "status" in heard, heard
    assert column.get() == before
    column.step(0.1, 0.1)
    column.fmi.reset()
    column.initialize()
    column.set({"base.ax": 1.0})
    column.step(0.0, 0.1)
    assert column.get() == before
    column.close()
    return heard


def unreadable(fmu: str, state: str) -> str:
    """Return the messages about bytes that are no state."""
    return Instance(fmu).attempt("deSerializeFMUstate", Path(state).read_bytes())


def sliding(fmu: str, values: dict[str, float]) -> dict[str, Any]:
    """Compare a state taken while a joint slides, set again and, as bytes, in another instance: the same bits from
    there on.
    """
    column = Instance(fmu, values)
    slip, rate, k = 0.0, 0.0, 0
    while not (k > 20 and abs(rate) > 1e-5):  # m in a step: it slides, and not for the first time perhaps
        drive(column, k, k + 1)
        k += 1
        now = column.get("joint[2].slip")[0]
        slip, rate = now, now - slip
    at_save = bits(column.get())
    saved = column.fmi.getFMUState()
    stored = column.fmi.serializeFMUstate(saved)
    first = bits(drive(column, k, k + 150))
    goes_on = abs(column.get("joint[2].slip")[0] - slip)
    column.fmi.setFMUState(saved)
    found: dict[str, Any] = {"at once": bits(column.get()) == at_save}
    found["further on"] = bits(drive(column, k, k + 150)) == first
    other = Instance(fmu)
    other.fmi.setFMUState(other.fmi.deSerializeFMUstate(stored))
    found["elsewhere"] = bits(drive(other, k, k + 150)) == first
    found["parameters elsewhere"] = other.get(*values) == [*values.values()]
    column.fmi.freeFMUState(saved)
    column.close()
    other.close()
    return found | {"step": k, "slid": goes_on, "end": first}
