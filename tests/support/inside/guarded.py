"""The answers of the guard before PythonFMU's library."""

from __future__ import annotations

import ctypes
import sys
from pathlib import Path
from typing import Any

from fmpy import extract
from fmpy.fmi2 import fmi2Boolean, fmi2Real, fmi2Status, fmi2String

from support.inside.lives import NAN
from support.instance import Instance


def instantiate(fmu: str, place: str) -> list[bool]:
    """Return True if instances are made in the wrong ways, then in those in which hosts write the URI, then without
    callbacks.

    The standard error has a line `=` after what belongs to each.
    """
    folder = Path(place, "Rødgrød 7%").resolve()
    folder.mkdir()
    extract(fmu, unzipdir=str(folder))
    column = Instance(fmu, folder=str(folder))
    dll, own = column.fmi.dll, (folder / "resources").as_uri().encode()
    plain = str(folder / "resources").encode()
    usual = {
        "name": b"column",
        "kind": 1,
        "guid": column.fmi.guid.encode(),
        "uri": own,
        "functions": ctypes.byref(column.fmi.callbacks),
    }

    def made(**changes: Any) -> bool:
        given = usual | changes
        pointer = dll.fmi2Instantiate(*(given[key] for key in usual), 0, 0)
        if pointer:
            dll.fmi2FreeInstance(ctypes.c_void_p(pointer))
        print("=", file=sys.stderr, flush=True)
        return bool(pointer)

    wrong: list[dict[str, Any]] = [
        *({"uri": uri} for uri in (None, b"file:///nowhere/at/all", b"", b"x" * 10000)),
        *({"guid": guid} for guid in (b"{other}", None)),
        {"kind": 0},
        *({"name": name} for name in (b"", None)),
    ]
    right = (own, own + b"/", b"file:" + own[7:], b"file://localhost" + own[7:], plain, b"file://" + plain)
    found = [made(**changes) for changes in (*wrong, *({"uri": uri} for uri in right), {"functions": None})]
    column.step(0.0, 0.1)
    column.close()
    return found


def last_step(column: Instance) -> list[Any]:
    """Return the answers to the four questions about the last step: their statuses, its status, time (s), end and
    message.
    """
    dll, c = column.fmi.dll, ctypes.c_void_p(column.fmi.component)
    status, time, flag, text = fmi2Status(), fmi2Real(), fmi2Boolean(), fmi2String()
    codes = [
        dll.fmi2GetStatus(c, 0, ctypes.byref(status)),
        dll.fmi2GetRealStatus(c, 2, ctypes.byref(time)),
        dll.fmi2GetBooleanStatus(c, 3, ctypes.byref(flag)),
        dll.fmi2GetStringStatus(c, 1, ctypes.byref(text)),
    ]
    return [codes, status.value, round(time.value, 9), flag.value, (text.value or b"").decode()]


def statuses(fmu: str) -> dict[str, Any]:
    """Return the answers to questions about steps: a good one, a discarded one, a good one, three wrong ones."""
    column = Instance(fmu, {"base.ax": 0.5})
    dll, c, status = column.fmi.dll, ctypes.c_void_p(column.fmi.component), fmi2Status()
    column.step(0.0, 0.1)
    seen = [last_step(column)]
    column.set({"base.ax": NAN})
    column.attempt("step", 0.1, 0.1)
    seen.append(last_step(column))
    column.set({"base.ax": 0.5})
    column.step(0.1, 0.1)
    seen.append(last_step(column))
    wrong = [column.attempt("step", 0.2, h) for h in (0.0, -0.1, NAN)]
    after = [dll.fmi2GetStatus(c, 0, ctypes.byref(status)), status.value]
    unknown = [dll.fmi2GetIntegerStatus(c, 0, ctypes.byref(status)), dll.fmi2GetStatus(c, 1, ctypes.byref(status))]
    column.step(0.2, 0.1)
    column.close()
    return {"steps": seen, "wrong": wrong, "after": after, "unknown": unknown}
