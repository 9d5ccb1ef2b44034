"""Seeded scenes of everyday models with any of their features: what each does with its rows, the kernels must do.

A scene is a call without arguments that returns numbers: a run of a column or a structure, or of twelve in lanes.
"""

from __future__ import annotations

import hashlib
import warnings
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from multiblock import Column, Motion, Structure, natural_modes, simulate, simulate_many
from solver import InputError
from solver.common.files import toml_of
from solver.kernels.column.api.engine import BASE_INPUTS
from solver.kernels.column.formulations.coupled_base import BODY
from solver.kernels.layout.spaces import DRIVES
from solver.kernels.machine.entry import ENTRIES
from solver.kernels.structure import entries as structures
from solver.kernels.structure.coupled import BODY as BODY_IN_SPACE
from solver.kernels.structure.coupled import INPUTS, ROTATION, TURNING_BODY
from solver.kernels.structure.layout import INPUT_LOADS
from solver.models.column.stepper import Stepper
from solver.models.structure.driven import Chosen, DrivenStructure, packed
from solver.models.structure.modes import modes_in_space

G = 9.80665  # m/s2
EXAMPLES = Path(__file__).resolve().parent.parent / "examples" / "structures"
OTHERS = ("facade", "pallets", "statue-on-pendulums", "statue-on-rubber", "statue-on-lead-rubber", "trilith")
KINDS = ("columns", "structures", "lanes", "lanes in space")
RUNS = 12  # of a scene of lanes
STEPS = 50  # of 1 ms, as of an FMU
MASSES = ("M", "Mxx", "Mzz", "Mtt", "Jxx", "Jyy")  # of a body that drives the base: kg, kg m2
MOST_BLOCKS, MOST_VARIANTS = 6, 50
Model = Column | Structure
Numbers = list[np.ndarray]


def _some(rng: np.random.Generator, part: float) -> bool:
    return bool(rng.random() < part)


def _motion(rng: np.random.Generator, longest: float = 2.0) -> Motion:
    duration = float(rng.uniform(0.3, longest))
    amplitude = G * float(10.0 ** rng.uniform(-1.5, 0.3))
    if _some(rng, 0.4):
        return Motion.harmonic(amplitude, float(10.0 ** rng.uniform(-0.3, 1.2)), duration)
    count = int(rng.integers(2, 60))
    ax, az = amplitude * rng.normal(size=count), 0.3 * amplitude * rng.normal(size=count)
    if _some(rng, 0.3):  # it begins and ends still
        ax[: count // 3] = az[: count // 3] = 0.0
    return Motion.from_samples(duration / count, ax, az, hold=_some(rng, 0.3))


# --- columns


def _column_data(rng: np.random.Generator) -> dict[str, Any]:
    n = int(rng.integers(1, MOST_BLOCKS + 1))
    round_, dry, brittle = _some(rng, 0.4), _some(rng, 0.5), _some(rng, 0.15)
    paper = _some(rng, 0.12)
    joint: dict[str, Any] = {
        "stiffness": float(10.0 ** rng.uniform(8.0, 10.0)),
        "damping": 0.0 if _some(rng, 0.15) else float(10.0 ** rng.uniform(-4.0, -2.3)),
    }
    if dry and not paper:
        joint["friction"] = float(rng.uniform(0.1, 0.8))
        if _some(rng, 0.3):
            joint["dowel"] = float(10.0 ** rng.uniform(2.0, 4.0))
    if brittle and not paper:
        joint |= {"friction": 0.6, "tensile_strength": float(10.0 ** rng.uniform(3.5, 6.0)), "cohesion": 1e5}
    blocks = []
    for _ in range(n):
        width = float(rng.uniform(0.4, 1.2))
        block: dict[str, Any] = {"height": float(rng.uniform(0.3, 1.5)), "width": width, "depth": width}
        block["density"] = float(rng.uniform(1500.0, 2800.0))
        own: dict[str, Any] = {}
        if round_:
            block["section"] = "circle"
            if _some(rng, 0.3):
                block |= {"section": "annulus", "bore": 0.3 * width}
        if not paper and not brittle:
            if _some(rng, 0.2):
                own["rim"] = float(rng.uniform(0.02, 0.2)) * width
            elif _some(rng, 0.15):
                own |= {"section": "strips", "strips": [0.4, 0.2, 0.0, 0.2, 0.4]}
            if _some(rng, 0.15):
                own["offset"] = float(rng.uniform(-0.05, 0.05)) * width
            if _some(rng, 0.1):
                own["inclination"] = float(rng.uniform(-0.01, 0.01))
        if own:
            block["joint"] = own
        blocks.append(block)
    solver: dict[str, Any] = {"tolerance": float(10.0 ** rng.uniform(-6.0, -3.0))}
    if paper:
        solver |= {"formulation": "paper", "step": 2e-5}
        for block in blocks:
            block.pop("bore", None)
            block["section"] = "rectangle"
    elif _some(rng, 0.4):
        skips = rng.choice(["elastic", "rest", "dashpots", "resultants", "implicit", "peaks"], 2, replace=False)
        solver["without"] = [str(name) for name in skips]
    data: dict[str, Any] = {"name": "scene", "joint": joint, "block": blocks, "solver": solver}
    if not paper and not brittle and _some(rng, 0.2):
        data["port"] = [
            {
                "name": f"p{k}",
                "block": f"block{int(rng.integers(1, n + 1))}",
                "at": [0.1, float(rng.uniform(-0.2, 0.2))],
            }
            for k in range(int(rng.integers(1, 3)))
        ]
    return data


# --- structures


def _law(rng: np.random.Generator) -> dict[str, Any]:
    law: dict[str, Any] = {
        "stiffness": float(10.0 ** rng.uniform(8.3, 9.7)),
        "damping": float(10.0 ** rng.uniform(-4.0, -2.0)),
    }
    if _some(rng, 0.6):
        law["friction"] = float(rng.uniform(0.1, 0.8))
    if _some(rng, 0.2):
        law["rim"] = float(rng.uniform(0.03, 0.1))
    elif _some(rng, 0.15):
        law |= {"friction": 0.6, "tensile_strength": float(10.0 ** rng.uniform(4.0, 6.0)), "cohesion": 1e5}
    return law


def _structure_data(rng: np.random.Generator) -> dict[str, Any]:
    if _some(rng, 0.35):
        other: dict[str, Any] = toml_of(EXAMPLES / f"{rng.choice(OTHERS)}.toml")
        other["joints"] |= {"damping": float(10.0 ** rng.uniform(-4.0, -2.0)), "friction": float(rng.uniform(0.1, 0.8))}
        return other
    stacks, names, blocks = int(rng.integers(1, 3)), [], []
    for s in range(stacks):
        on = "base"
        for i in range(int(rng.integers(1, 4))):
            name = f"s{s}b{i}"
            width = float(rng.uniform(0.5, 0.9))
            block: dict[str, Any] = {"name": name, "on": on, "height": float(rng.uniform(0.3, 1.2)), "density": 2500.0}
            if on == "base":
                block["at"] = [1.0 * s, 0.0]
            if _some(rng, 0.4):
                block |= {"shape": "drum", "diameter": width}
                if _some(rng, 0.3):
                    block["bore"] = 0.3 * width
            else:
                block |= {"width": width, "depth": float(rng.uniform(0.5, 0.9))}
                if _some(rng, 0.2):
                    block["rotation"] = [0.0, 0.0, float(rng.uniform(-0.3, 0.3))]
            blocks.append(block)
            names.append(name)
            on = name
    data: dict[str, Any] = {"name": "scene", "joints": _law(rng), "block": blocks}
    if _some(rng, 0.3):
        data["tie"] = [
            {"between": [names[-1], "base"], "from": [0.0, 0.0, 0.2], "to": [1.0, 2.0, 0.0], "stiffness": 1e6}
        ]
        if _some(rng, 0.5):
            data["tie"][0] |= {"slack": 0.002, "yield": 1e4}
    if _some(rng, 0.3):
        data["neighbours"] = {
            "reach": 0.6,
            "line_stiffness": 1e8,
            "stiffness": 1e9,
            "restitution": 0.5,
            "friction": 0.4,
        }
    if _some(rng, 0.25):
        data["port"] = [{"name": "p", "block": names[-1], "at": [0.1, 0.0, 0.1]}]
    data["solver"] = {"tolerance": float(10.0 ** rng.uniform(-6.0, -4.0))}
    if _some(rng, 0.3):
        data["solver"]["without"] = [str(rng.choice(["peaks", "elastic", "stabilized"]))]
    return data


# --- scenes


def _made(rng: np.random.Generator, kind: type[Any], draw: Callable[[np.random.Generator], dict[str, Any]]) -> Any:
    """Return the first model drawn that the readers accept and that stands."""
    for _ in range(MOST_VARIANTS):
        try:
            return kind.from_dict(draw(rng))
        except InputError:
            continue
    raise RuntimeError("no model was accepted: the draws of scenes.py do not fit the keys of models")


def _run(model: Model, motion: Motion) -> Numbers:
    with np.errstate(all="ignore"):
        loads = {port.name: {"Fx": 300.0, "Fz": -200.0} for port in model.ports}
        response = simulate(model, motion, loads=loads or None)
        found = [response.ux, response.N, *(response.peaks[name] for name in sorted(response.peaks))]
        modes = natural_modes(model) if isinstance(model, Column) else modes_in_space(model)
        return [*found, modes.frequency, _driven(model, motion)]


def _driven(model: Model, motion: Motion) -> np.ndarray:
    """Return outputs as an FMU steps a model whose base follows inputs, or is driven by a body, and may turn."""
    drive, turns = ("acceleration", "body", "horizontal")[len(motion.ax) % 3], len(motion.ax) % 2
    driven: Any
    if isinstance(model, Column):
        driven, names, loads, body = Stepper(model), BASE_INPUTS.fields, 6 * len(model.ports), BODY.fields
        if model.settings.formulation == "exact":
            driven.driven_by(drive, "line", 1)
        else:
            body = ()
    else:
        chosen = Chosen(model.settings.tolerance, drive=DRIVES[drive], turns=turns)
        driven, names = DrivenStructure(model, packed(model), chosen), INPUTS.fields
        loads, body = len(INPUT_LOADS.fields) * len(model.ports), BODY_IN_SPACE.fields
        if turns:
            body = (*ROTATION.fields, *body, *TURNING_BODY.fields)
    if drive == "acceleration":
        body = ()
    of_body = [1e5 if name in MASSES else 0.0 for name in body]
    rows = []
    for k in range(STEPS):
        t, given = 1e-3 * k, {}
        if drive == "acceleration":
            given = {"ax": float(motion.ax[k % len(motion.ax)]), "az": float(motion.az[k % len(motion.az)])}
        inputs = [given.get(name, 0.0) for name in names]
        driven.drive(t, *inputs, *(10.0 * np.cos(np.arange(loads) + k)), *of_body)
        driven.advance(t, 1e-3)
        rows.append(np.array(driven.observe(t + 1e-3)))
    return np.concatenate([*rows, *_derivatives(driven, model, 1e-3 * STEPS)])


def _derivatives(driven: Any, model: Model, t: float) -> Numbers:
    """Return the rates of the outputs and their derivatives along inputs, as a native FMU has them where one can be
    built.
    """
    row, other = np.zeros((2, driven.seen.size))
    if isinstance(model, Structure):
        seeds = np.ones(driven._inputs.size)
        record = driven.record
        lines = record[: record._fields.index("held")]  # neither held samples nor loads
        structures.rates(*driven.arrays, t, *lines, row, np.zeros(row.size))
        structures.feedthrough(*driven.arrays, seeds, 0.0, t, other, np.zeros(row.size))
        return [row.copy(), other.copy()]
    if model.settings.formulation != "exact" or model.ports:
        return []
    none, split, other_split = np.zeros(0), np.zeros(row.size), np.zeros(row.size)
    seeds = np.ones(len(BASE_INPUTS.fields) + len(BODY.fields))
    given, rooms = (none, none, none, 1.0), (row, split, other, other_split)
    ENTRIES["column_driven", "rates"](model.n, *driven.arrays, t, *given, *rooms)
    rates = row.copy()
    ENTRIES["column_driven", "feedthrough"](model.n, *driven.arrays, seeds, seeds, 0.0, t, *given, *rooms)
    return [rates, row.copy()]


def _run_many(models: list[Model], motions: list[Motion]) -> Numbers:
    table = simulate_many(models, motions, keep=("peak_top_ux",), threads=1)
    return [np.array(list(table["peak_top_ux"]))]


def scene(kind: str, seed: int, number: int) -> Callable[[], Numbers]:
    """Return the scene of that number; the same arguments give the same one."""
    rng = np.random.default_rng([seed, KINDS.index(kind), number])
    in_space = kind in ("structures", "lanes in space")
    draw, of = (_structure_data, Structure) if in_space else (_column_data, Column)
    if kind in ("columns", "structures"):
        return partial(_run, _made(rng, of, draw), _motion(rng, 1.0 if in_space else 2.0))
    models = [_made(rng, of, draw)] * RUNS
    return partial(_run_many, models, [_motion(rng, 0.5 if in_space else 1.0) for _ in range(RUNS)])


def digest(kind: str, seed: int, number: int) -> str:
    """Hash of what a scene gives; the reason if it is refused or the solver gives up."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            found = scene(kind, seed, number)()
    except ValueError as error:
        return str(error)
    content = hashlib.sha256()
    for numbers in found:
        content.update(np.ascontiguousarray(numbers, dtype=float).tobytes())
    return content.hexdigest()
