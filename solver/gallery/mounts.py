"""The mounts of a gallery, and the structure of an object on one.

A mount does not depend on the object: its bearings have periods and shares of the weight in place of stiffnesses and
forces.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Any

import numpy as np

from ..common.errors import InputError, check_number, reading, shown
from ..common.files import check_file_name, toml_of
from ..common.ranges import LENGTH, NUMBERS
from ..common.tables import check_table, tables_in
from ..models.column.materials import MATERIALS
from ..models.structure.model import Structure
from .objects import Exhibit

GRAVITY = 9.80665  # m/s2
# N/m3, of a dry joint: the lower end of docs/materials.md. At 5e9 runs take twice as long, and a block tips as if its
# foot were 1 % wider
STIFFEST = 1e9
BELOW = 0.1  # m, height of bearings, which are points
PLAN = ("width", "depth")
_PERIODS = ("period", "vertical_period", "initial_period")
_PERIOD = (1e-3, 100.0), "a period in s, from 0.001 to 100"
_SHARE = (1e-4, 10.0), "a share from 1e-4 to 10"
_OF_SLAB = {"beyond": ((0.0, 10.0), "a length in m, from 0 to 10"), "height": LENGTH, "density": NUMBERS["density"]}


@dataclass(frozen=True)
class Mount:
    """A mount: a table of the list, which goes from the least to the most intervention."""

    name: str
    foot: float = 1.0  # factor on the width and depth of the contact under the object
    pedestal: float = 1.0  # the same of the pedestal
    joint: Mapping[str, Any] = field(default_factory=dict)  # law of the joint under the object
    tie: Mapping[str, Any] = field(default_factory=dict)  # an upright tie in its middle, from the object to its support
    slab: Mapping[str, float] = field(default_factory=dict)  # on the bearings, under the pedestal
    bearing: Mapping[str, Any] = field(default_factory=dict)

    @property
    def text(self) -> str:
        """The changes that it makes, as in its file, in SI units; "nothing" without any."""
        factors = [f"{word} x {factor:g}" for word in ("foot", "pedestal") if (factor := getattr(self, word)) != 1.0]
        tables = [(word, getattr(self, word)) for word in ("joint", "tie", "slab", "bearing")]
        laws = [f"{word} ({', '.join(f'{key} {_in_words(law[key])}' for key in law)})" for word, law in tables if law]
        return "; ".join([*factors, *laws]) or "nothing"


def _in_words(value: Any) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value).lower()


def read_mounts(path: str | os.PathLike[str]) -> tuple[Mount, ...]:
    """Read a list of mounts, one table `[[mount]]` for each. Raises InputError."""
    with reading(path):
        data = toml_of(path)
        check_table("", data, ("mount",))
        found: dict[str, Mount] = {}
        for number, table in enumerate(tables_in("mount", data), start=1):
            key = f"mount[{number}]"
            check_table(f"{key}.", table, [item.name for item in fields(Mount)])
            name = check_file_name(f"{key}.name", table.get("name"))
            if name in found:
                raise InputError(f"{key}.name = {name}: must be another name, it is taken")
            for word in ("foot", "pedestal"):
                check_number(f"{key}.{word}", table.get(word, 1.0), (1.0, 10.0), "a factor from 1 to 10")
            for word in ("joint", "tie", "slab", "bearing"):
                if not isinstance(table.get(word, {}), Mapping):
                    raise InputError(f"{key}.{word} = {shown(table[word])}: must be a table of keys")
            if ("slab" in table) != ("bearing" in table):
                raise InputError(f"{key}: slab and bearing must be given together")
            found[name] = Mount(**table)
        return tuple(found.values())


def mounted(exhibit: Exhibit, mount: Mount) -> Structure:
    """Return the structure of an object on a mount.

    The object is a box with the given centroid, or a mesh. Joints are dry, on whole faces, with the modulus (at
    most `STIFFEST`) and friction of the material, and the damping that is critical as the object bounces. Raises
    InputError with the names of both.
    """
    with reading(f"{exhibit.name} on mount {mount.name}"):
        material, below = MATERIALS[exhibit.material], _support(exhibit, mount)
        shape: dict[str, Any] = {key: value for key, value in exhibit.box.items() if key != "centroid"}
        if exhibit.mesh:
            shape = {"shape": "mesh", "file": exhibit.mesh, "density": material.density}
        law = {"stiffness": STIFFEST, "damping": 0.0, "friction": material.friction, "strength": material.strength}
        support = below.get("name", "base")
        blocks = [*filter(None, [below]), {"name": "object", "on": support, "joint": dict(mount.joint), **shape}]
        data = {"name": f"{exhibit.name} - {mount.name}", "g": GRAVITY, "joints": law, "block": blocks}
        # what follows from masses and sizes: damping, bearings, ends of the tie
        plain = Structure.from_dict(data)
        solid = plain.blocks[-1]
        low, high = float(np.min(solid.corners[:, 2])), float(np.max(solid.corners[:, 2]))
        centroid = np.array([*solid.centroid[:2], low + exhibit.box["centroid"]]) if exhibit.box else solid.centroid
        area = sum(joint.moments[0] for joint in plain.joints if joint.upper == plain.n - 1)
        law["stiffness"] = min(material.modulus(high - low), STIFFEST)
        law["damping"] = 2.0 * math.sqrt(solid.mass / (law["stiffness"] * area))
        if mount.bearing:
            data["bearing"] = [_bearing(mount, sum(block.mass for block in plain.blocks), below)]
            below["position"] = [0.0, 0.0, BELOW]
            del below["on"]
        if mount.tie:
            tie = dict(mount.tie)
            half = 0.5 * check_number("tie.length", tie.pop("length", None), *LENGTH)
            middles = centroid, plain.blocks[0].centroid if below else np.array([0.0, 0.0, low])
            ends = [
                (np.array([0.0, 0.0, low + way]) - z).tolist() for way, z in zip((half, -half), middles, strict=True)
            ]
            data["tie"] = [{**tie, "between": ["object", support], "from": ends[0], "to": ends[1]}]
        return _adjusted(Structure.from_dict(data), exhibit, mount, below)


def _pedestal(exhibit: Exhibit, mount: Mount) -> dict[str, float]:
    """Return the sizes and the mass of the pedestal, as wide as the mount makes it; empty without one."""
    return {key: value * (mount.pedestal if key in PLAN else 1.0) for key, value in exhibit.pedestal.items()}


def _support(exhibit: Exhibit, mount: Mount) -> dict[str, Any]:
    """Return the table of the block under the object; empty for the floor, of which a fixed pedestal is a part.

    On bearings the pedestal is fastened to its slab: one block, which tapers from the one to the other.
    """
    under = _pedestal(exhibit, mount) or exhibit.box
    if not mount.slab:
        return {"name": "pedestal", "on": "base", **under} if exhibit.pedestal and not exhibit.fixed else {}
    if not under:
        raise InputError("slab: must be left out of a mesh without a pedestal, whose size is not given")
    check_table("slab.", mount.slab, tuple(_OF_SLAB))
    beyond, height, density = (check_number(f"slab.{key}", mount.slab.get(key), *of) for key, of in _OF_SLAB.items())
    slab = {key: under[key] + 2.0 * beyond for key in PLAN} | {"height": height}
    table: dict[str, Any] = {"name": "slab", "on": "base", **slab, "mass": density * math.prod(slab.values())}
    if exhibit.pedestal:
        table |= {key: table[key] + under[key] for key in ("height", "mass")}
        table |= {f"top_{key}": under[key] for key in PLAN}
    return table


def _bearing(mount: Mount, mass: float, slab: Mapping[str, float]) -> dict[str, Any]:
    """Return the table of four equal bearings near the corners of the slab, which carry `mass` (kg)."""
    table, each = dict(mount.bearing), 0.25 * mass
    rates = {
        key.removesuffix("period"): 2.0 * math.pi / check_number(f"bearing.{key}", table.pop(key), *_PERIOD)
        for key in _PERIODS
        if key in table
    }
    shares = {
        key: check_number(f"bearing.{key}", table.pop(key), *_SHARE)
        for key in ("damping_ratio", "yield_ratio")
        if key in table
    }
    rubber = table.get("kind") in ("elastomeric", "lead_rubber")
    if "damping_ratio" in shares and "" in rates:
        table["damping"] = 2.0 * shares["damping_ratio"] * each * rates[""]
    if "yield_ratio" in shares:
        table["yield"] = shares["yield_ratio"] * each * GRAVITY
    if not rubber and "" in rates:
        table["radius"] = GRAVITY / rates.pop("") ** 2
    table |= {f"{key}stiffness": each * rate**2 for key, rate in rates.items()}
    x, y = (0.5 * (slab[key] - table.get("diameter", 0.0)) for key in PLAN)
    at = [[a * x, b * y, BELOW] for a, b in ((-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0))]
    return table | {"between": ["slab", "base"], "at": at}


def _adjusted(structure: Structure, exhibit: Exhibit, mount: Mount, below: Mapping[str, Any]) -> Structure:
    """Return the structure with the centroid of its object, and the contact under it as wide as the mount says.

    `below` is the table of its support. Raises InputError if the contact overhangs it, or a fixed pedestal.
    """
    solid, joints = structure.blocks[-1], list(structure.joints)
    if exhibit.box:
        low = float(np.min(solid.corners[:, 2]))
        solid = replace(solid, centroid=np.array([*solid.centroid[:2], low + exhibit.box["centroid"]]))
    support = below or _pedestal(exhibit, mount)
    most = [support.get(f"top_{key}", support.get(key, math.inf)) for key in PLAN]
    for j, joint in enumerate(joints):
        if joint.upper == structure.n - 1 and mount.foot > 1.0:
            wide = replace(joint.face, outline=mount.foot * joint.face.outline)
            if np.any(2.0 * np.abs(wide.points()[:, :2]) > np.multiply(most, 1.0 + 1e-9)):
                pairs = np.ptp(wide.outline, axis=0), most
                made, limit = (" x ".join(f"{one:.4g}" for one in pair) for pair in pairs)
                on = "pedestal" if exhibit.pedestal else "slab"
                raise InputError(f"foot = {mount.foot:g}: makes {made} m, must fit on the {on}, {limit} m")
            joints[j] = replace(joint, face=wide, above=wide if joint.above is not None else None)
    return replace(structure, blocks=(*structure.blocks[:-1], solid), joints=tuple(joints), described=None)
