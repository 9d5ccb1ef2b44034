"""Calls that no host should make to a native FMU: NULL pointers, states made by hand, steps beyond the end."""

from __future__ import annotations

import ctypes
import hashlib
import json
import random
import struct
import threading
from collections.abc import Callable
from typing import Any

from fmpy.fmi2 import fmi2CallbackFunctions, fmi2CallbackLoggerTYPE

from support.inside.fmi3 import Instance3
from support.inside.lives import answer
from support.instance import Instance

Call = Callable[[], int]
Heard = dict[str, tuple[int, list[str]]]  # call and the argument that is NULL -> status, messages of the logger

FMI2_CALLS = {  # arguments after the instance: P a pointer to room, R value references, N their number, else a number
    "SetReal": "RNP",
    "GetReal": "RNP",
    "SetInteger": "INP",
    "GetInteger": "INP",
    "SetBoolean": "RNP",
    "GetBoolean": "BNP",
    "SetString": "SNP",
    "GetString": "SNP",
    "SetRealInputDerivatives": "RNOP",
    "GetRealOutputDerivatives": "FNOP",
    "GetDirectionalDerivative": "FNRNPP",
    "GetStatus": "0P",
    "GetRealStatus": "2P",
    "GetBooleanStatus": "3P",
    "GetStringStatus": "1P",
    "GetFMUstate": "P",
    "SetFMUstate": "P",
    "SerializedFMUstateSize": "PP",
    "SerializeFMUstate": "PPN",
    "DeSerializeFMUstate": "PNP",
}
FMI3_CALLS = {
    "SetFloat64": "RNPN",
    "GetFloat64": "RNPN",
    "SetInt64": "INPN",
    "GetInt64": "INPN",
    "SetBoolean": "BNPN",
    "GetBoolean": "BNPN",
    "SetString": "SNPN",
    "GetString": "SNPN",
    "GetOutputDerivatives": "FNOPN",
    "GetDirectionalDerivative": "FNRNPNPN",
    "GetFMUState": "P",
    "SetFMUState": "P",
    "SerializedFMUStateSize": "PP",
    "SerializeFMUState": "PPN",
    "DeserializeFMUState": "PNP",
}
REFERENCES = {"R": 1, "I": 2002, "B": 1015, "S": 2007, "F": 1001}  # tests/value_references.txt


def with_null(prefix: str, dll: Any, component: Any, name: str, calls: dict[str, str] | None = None) -> list[Call]:
    """Repeat a call with each of its pointers NULL in turn; they return the status."""
    bare = ctypes.CDLL(dll._name)  # FMPy's own functions would make pointers of what is NULL here
    kinds = (calls or FMI2_CALLS)[name]
    usual: list[Any] = []
    for kind in kinds:
        if kind in REFERENCES:
            usual.append(ctypes.cast((ctypes.c_uint * 1)(REFERENCES[kind]), ctypes.c_void_p))
        elif kind in "PO":
            room = (ctypes.c_int * 1)(1) if kind == "O" else (ctypes.c_double * 8)()
            usual.append(ctypes.cast(room, ctypes.c_void_p))
        else:
            usual.append(ctypes.c_size_t(1 if kind == "N" else int(kind)))

    def made(k: int) -> int:
        function = getattr(bare, prefix + name)
        return int(function(ctypes.c_void_p(component), *usual[:k], None, *usual[k + 1 :]))

    pointers = [k for k, kind in enumerate(kinds) if kind in "PO" or kind in REFERENCES]
    return [lambda k=k: made(k) for k in pointers]  # type: ignore[misc]


def _nulls(prefix: str, dll: Any, component: Any, calls: dict[str, str], said: list[str]) -> Heard:
    """Return the messages about every call with each of its pointers NULL in turn."""
    heard: Heard = {}
    for name in calls:
        for k, call in enumerate(with_null(prefix, dll, component, name, calls), start=1):
            said.clear()
            heard[f"{name}, pointer {k}"] = (call(), [*said])
    return heard


HEADER = 96  # bytes before what a native state keeps; the last text in it is a checksum
ODD = [b"\xff" * 8, *(struct.pack("<d", number) for number in (float("nan"), float("inf"), 1e5, -1e5, 0.0))]
ODD += [struct.pack("<q", number) for number in (2**40, 3, 1)]


def changed(data: bytes, some: random.Random) -> bytes:
    """Return a native state with a few of its numbers changed, under a right checksum."""
    head, content = data[:HEADER], bytearray(data[HEADER:])
    for _ in range(some.choice([1, 1, 3])):
        most = len(content) // 8
        place = 8 * some.randrange(some.choice([12, most, most]))
        content[place : place + 8] = some.choice(ODD)
    checksum = 14695981039346656037
    for byte in content:
        checksum = ((checksum ^ byte) * 1099511628211) % 2**64
    words = head.rstrip(b"\0").split(b"\n")
    words[-1] = f"{checksum:016x}".encode()
    return b"\n".join(words).ljust(HEADER, b"\0") + bytes(content)


def _listening(fmu: str) -> tuple[Instance, list[str]]:
    """Return an instance of FMI 2.0, and the list of what it tells its logger."""
    said: list[str] = []

    @fmi2CallbackLoggerTYPE
    def hear(_environment: Any, _name: bytes, _status: int, _category: bytes, text: bytes) -> None:
        said.append(text.decode())

    callbacks = fmi2CallbackFunctions()
    callbacks.logger = hear
    column = Instance(fmu, {"base.ax": 0.5}, callbacks=callbacks)
    column.keep = (callbacks, hear)  # type: ignore[attr-defined]
    column.step(0.0, 0.1)
    return column, said


def nulls(fmu: str) -> tuple[Heard, bool]:
    """Return the messages about NULL pointers; whether the instance behaves as before."""
    column, said = _listening(fmu)
    before = column.get()
    heard = _nulls("fmi2", column.fmi.dll, column.fmi.component, FMI2_CALLS, said)
    same = column.get() == before
    column.step(0.1, 0.1)
    column.close()
    return heard, same


def made_without_callbacks(fmu: str) -> bool:
    """Return True if an instance is made."""
    fmi = Instance(fmu).fmi
    return bool(fmi.dll.fmi2Instantiate(b"column", 1, fmi.guid.encode(), b"", None, 0, 0))


def nulls3(fmu: str) -> tuple[Heard, bool]:
    """Return the messages about NULL pointers in FMI 3.0; whether the instance behaves as before."""
    column = Instance3(fmu)
    column.initialize()
    column.set(base__ax=0.5)
    column.step(0.0, 0.1)
    before = column.get("block.ux", "base.Fx")
    heard = _nulls("fmi3", column.fmi.dll, column.fmi.component, FMI3_CALLS, column.said)
    return heard, column.get("block.ux", "base.Fx") == before


def unlikely_states(fmu: str, count: int) -> tuple[int, int, bool]:
    """Return how many states with changed numbers are refused and taken; whether a whole one still gives what
    it did.
    """
    column, _ = _listening(fmu)
    before, whole = column.get(), column.fmi.getFMUState()
    data = column.fmi.serializeFMUstate(whole)
    some, refused, taken = random.Random(1), 0, 0
    for _ in range(count):
        try:
            read = column.fmi.deSerializeFMUstate(changed(data, some))
        except Exception:
            refused += 1
            continue
        taken += 1
        column.fmi.setFMUState(read)
        column.attempt("get")
        column.attempt("step", 0.1, 0.01)
        column.fmi.freeFMUState(read)
    column.fmi.setFMUState(whole)
    return refused, taken, column.get() == before


NO_STATES = (b"", b"{}", b"[]", b"null", b"1" * 5000, b"[" * 100000, b'{"format": ' * 100000)


def damaged_states(fmu: str) -> tuple[list[str], bool]:
    """Return the answer of a PythonFMU to the size, and to the bytes, of a state that came from damaged bytes, and to a
    whole
    one with too little room; whether a whole one still gives its bytes.
    """
    column = Instance(fmu, {"base.ax": 0.5})
    column.step(0.0, 0.1)
    whole = column.fmi.getFMUState()
    data = column.fmi.serializeFMUstate(whole)
    room, size = ctypes.create_string_buffer(len(data)), ctypes.c_size_t()
    damaged = [column.fmi.deSerializeFMUstate(some) for some in (data[:-1], b"", b"[" * 100000)]
    heard = []
    for state in damaged:
        heard.append(column.attempt("fmi2SerializedFMUstateSize", column.fmi.component, state, ctypes.byref(size)))
        heard.append(column.attempt("fmi2SerializeFMUstate", column.fmi.component, state, room, len(data)))
        column.fmi.freeFMUState(state)
    heard.append(column.attempt("fmi2SerializeFMUstate", column.fmi.component, whole, room, len(data) - 1))
    same = bool(column.fmi.serializeFMUstate(whole) == data)
    column.close()
    return heard, same


def impossible_states(fmu: str) -> tuple[list[str], bool]:
    """Return the answer of a PythonFMU to bytes that are no state, under a right checksum; whether it behaves as
    before.
    """
    column = Instance(fmu, {"base.ax": 0.5})
    column.step(0.0, 0.1)
    before = column.get()
    data = column.fmi.serializeFMUstate(column.fmi.getFMUState())
    parts = json.loads(data[64:])
    values, arrays = parts["values"], parts["arrays"]
    (kind, numbers) = arrays["state"]
    contents = [*NO_STATES, json.dumps({"format": parts["format"]}).encode()]
    changes: list[dict[str, Any]] = [
        {"mode": "elsewhere"},
        {"mode": ["stepping"]},
        {"time": float("nan")},
        {"time": "now"},
        {"shaken": 1},
        {"stamp": [1, 2]},
        {"values": values[:-1]},
        {"values": ["1.0", *values[1:]]},
        {"values": [10**400, *values[1:]]},
        {"values": [None, *values[1:]]},
        {"values": [*values[:-2], "\ud800", values[-1]]},
        {"built_from": parts["built_from"][1:]},
        {"built_from": [-1.0, *parts["built_from"][1:]]},
        {"arrays": {}},
        {"arrays": arrays | {"more": [kind, numbers]}},
        {"arrays": arrays | {"state": [kind, numbers[1:]]}},
        {"arrays": arrays | {"state": ["<f4", numbers]}},
        {"arrays": arrays | {"state": ["O", numbers]}},
        {"arrays": arrays | {"state": [kind, [numbers]]}},
        {"arrays": arrays | {"state": [kind, [float("inf"), *numbers[1:]]]}},
        {"arrays": arrays | {"counts": [arrays["counts"][0], [-1, *arrays["counts"][1][1:]]]}},
        {"arrays": arrays | {"base": [kind, [*arrays["base"][1][:14], 1e9, *arrays["base"][1][15:]]]}},
        {"more": 1},
    ]
    contents += [json.dumps(parts | change).encode() for change in changes]
    heard = []
    for content in contents:
        state = hashlib.sha256(content).hexdigest().encode() + content

        def restore(state: bytes = state) -> None:
            column.fmi.setFMUState(column.fmi.deSerializeFMUstate(state))

        heard.append(answer(restore))
    same = column.get() == before
    column.step(0.1, 0.1)
    column.close()
    return heard, same


def beyond(fmu: str) -> list[Any]:
    """Step to the stop time, one with a rounding error, and beyond it; then after a reset, where there is none."""
    column = Instance(fmu, initialize=False)
    column.fmi.setupExperiment(startTime=0.0, stopTime=0.3)
    column.fmi.enterInitializationMode()
    column.fmi.exitInitializationMode()
    column.set({"base.ax": 0.5})
    heard: list[Any] = [column.attempt("step", 0.0, 0.4), column.attempt("step", 0.0, 0.1)]
    heard += [column.attempt("step", 0.1, 0.2 * (1.0 + 1e-9)), column.attempt("step", 0.3, 1e-3)]
    heard.append(column.get("block[1].ux")[0] != 0.0)
    column.fmi.reset()
    column.initialize()
    heard.append(column.attempt("step", 0.0, 100.0))
    column.fmi.reset()
    for stop in (-1.0, float("nan")):
        heard.append(answer(lambda stop=stop: column.fmi.setupExperiment(startTime=0.0, stopTime=stop)))  # type: ignore[misc]
    column.fmi.freeInstance()
    return heard


def beyond3(fmu: str) -> list[Any]:
    """Step in FMI 3.0 to the stop time, then beyond; also a step within which an importer gives inputs."""
    heard: list[Any] = []
    asked: list[float] = []

    def give(_environment: Any, t: float, *_rest: Any) -> None:
        asked.append(t)

    followed: dict[str, Any] = {"intermediateUpdate": give, "requiredIntermediateVariables": [1]}
    for options in ({}, followed):
        column = Instance3(fmu, **options)
        column.fmi.enterInitializationMode(startTime=0.0, stopTime=0.3)
        column.fmi.exitInitializationMode()
        asked.clear()
        heard.append(answer(lambda column=column: column.step(0.0, 0.4)))  # type: ignore[misc]
        heard.append(len(asked))
        heard.append(answer(lambda column=column: column.step(0.0, 0.3)))  # type: ignore[misc]
        heard.append(answer(lambda column=column: column.step(0.3, 0.1)))  # type: ignore[misc]
    return heard


def tolerances(fmu: str) -> list[float]:
    """Return solver.tolerance: as built; with one of the experiment; set before it; set after it; after a reset;
    restored.
    """
    column = Instance(fmu, initialize=False)

    def now(experiment: float | None = None) -> float:
        column.fmi.setupExperiment(tolerance=experiment)
        return float(column.get("solver.tolerance")[0])

    seen = [now(), now(1e-8)]
    column.set({"solver.tolerance": 1e-7})
    seen.append(now(1e-8))
    column.fmi.reset()
    seen.append(now())
    column.set({"solver.tolerance": 1e-6})
    data = column.fmi.serializeFMUstate(column.fmi.getFMUState())
    column.fmi.reset()
    column.fmi.setFMUState(column.fmi.deSerializeFMUstate(data))
    seen.append(now(1e-8))
    return seen


def with_tolerances(fmu: str, pairs: list[tuple[float | None, float | None]]) -> list[list[Any]]:
    """Return the outputs of runs under the experiment's tolerance, the parameter's, or neither."""
    return [_with_tolerance(fmu, *pair) for pair in pairs]


def _with_tolerance(fmu: str, experiment: float | None, parameter: float | None) -> list[Any]:
    column = Instance(fmu, {} if parameter is None else {"solver.tolerance": parameter}, initialize=False)
    column.fmi.setupExperiment(tolerance=experiment)
    column.fmi.enterInitializationMode()
    column.fmi.exitInitializationMode()
    column.set({"base.ax": 1.5})
    column.step(0.0, 0.5)
    return column.get()


def in_a_thread(fmu: str, stack: int) -> list[Any]:
    """Return the outputs of a life in a thread with a limited stack, bytes."""
    found: list[Any] = []

    def live() -> None:
        column = Instance(fmu, {"base.ax": 0.1})
        column.step(0.0, 0.01)
        column.fmi.deSerializeFMUstate(column.fmi.serializeFMUstate(column.fmi.getFMUState()))
        found.extend(column.get("block[1].ux", "base.Fx"))

    threading.stack_size(stack)
    thread = threading.Thread(target=live)
    thread.start()
    thread.join()
    return found
