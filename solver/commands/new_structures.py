"""The structures that `new` asks about: architraves, an arch, stacks, a statue on bearings, casks; and their files."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from string import ascii_uppercase
from typing import Any, NamedTuple

import numpy as np

from ..ground.motion import STANDARD_GRAVITY
from ..models.column.materials import MATERIALS, Material
from ..models.structure.builders import arch
from ..models.structure.model import Structure
from .new_contacts import EVERYWHERE, Touching
from .questions import Limits, Question

Asked = Mapping[str, float]

COUNTS: Limits = ((1.0, 100.0), "a whole number from 1 to 100")
FRICTIONS: Limits = ((0.01, 2.0), "a coefficient of friction, from 0.01 to 2")
SEVERAL: Limits = ((2.0, 100.0), "a whole number from 2 to 100")
MOST_CASKS = 200  # those of a square grid have fewer than 1000 pairs
LINE_STIFFNESS = 1e9  # N/m2, along the line in which two casks touch: a choice (docs/neighbours.md)
RESTITUTION = 0.5  # of two casks, a choice
LENGTH = "H"  # key of a joint, not written: length of the blocks across it, m
# of pendulums, choices: displacement at which they slide (m), stiffness over weight (1/m) for 20 Hz on four of them
SLIDES_AT, VERTICAL = 1e-3, 0.25 * (2.0 * math.pi * 20.0) ** 2 / STANDARD_GRAVITY
# of height times width times depth of its base, that a statue fills. The body of a person: 0.3 of the box around it. A
# draped Roman statue of 650 kg on a base of 0.72 by 0.43 m, centroid at 0.635 m (Monaco and others 2020, table 1): at
# most 0.6, if of marble and not wider above
PART_OF_BOX, LEAST_PART, MOST_PART = 0.4, 0.3, 0.6
MASS_NOTE = (
    "# mass in kg: pressures follow it, overturning hardly (docs/check.md). A statue fills 0.3 to 0.6 of height times",
    "# width times depth of its base. Left out, it would be a full block of the material.",
)
MASSES = 0.05, 3.0  # limits, of the mass of the box over its base; above 1 if the statue is wider above


class AskedLaw(NamedTuple):
    """The material of the blocks of a new file, and the answers on its joints."""

    material: str  # a name in MATERIALS
    damping: float  # s
    touching: Touching = EVERYWHERE  # the part of the faces in contact
    friction: float = 0.0  # coefficient; 0: joints never slide
    dowel: float = 0.0  # N, shear that each joint bears beside friction
    tension: float = 0.0  # Pa, tensile strength of mortar until it breaks
    cohesion: float = 0.0  # Pa, of mortar until the joint slides

    @property
    def found(self) -> Material:
        """The data of the material."""
        return MATERIALS[self.material]

    @property
    def lines(self) -> list[str]:
        """The lines of the file on rim, friction and dowel, where there are any."""
        lines, rim = [], self.touching.rim
        if rim:
            lines.append(
                f"rim = {rim:.6g}                 # m, faces touch in a band along their edges; left out: all over"
            )
        if self.friction:
            lines.append(f"friction = {self.friction!r}         # coefficient; without it the joints never slide")
        if self.dowel:
            lines.append(f"dowel = {self.dowel!r}            # N, shear borne beside friction")
        if self.tension:
            lines.append(f"tensile_strength = {self.tension!r}  # Pa, of the mortar until it breaks, for good")
            lines.append(f"cohesion = {self.cohesion!r}         # Pa, of the mortar until the joint slides")
        return lines


class Built(NamedTuple):
    """A structure to choose: its description, its questions, and the functions of the answers."""

    text: str
    questions: dict[str, Question]
    parts: Callable[[Asked], dict[str, Any]]  # the tables [[block]] and [[joint]], with a density
    high: Callable[[Asked], float]  # m, H of most joints; others have that of their block, or their own LENGTH
    face: Callable[[Asked], float]  # m, width of the smallest face


def _colonnade(asked: Asked) -> dict[str, Any]:
    """Return shafts of drums in a row along x, with an architrave from the axis of each to that of the next."""
    columns, drums, spacing, density = int(asked["columns"]), int(asked["drums"]), asked["spacing"], asked["density"]
    blocks: list[dict[str, Any]] = []
    for c in range(columns):
        shaft = {"name": f"column{c + 1}", "shape": "drum", "repeat": drums, "on": "base", "at": [c * spacing, 0.0]}
        shaft |= {"diameter": asked["bottom"], "top_diameter": asked["top"], "height": asked["height"] / drums}
        blocks.append(shaft | {"density": density})
    for c in range(1, columns):
        beam: dict[str, Any] = {"name": f"architrave{c}", "on": [f"column{k}.{drums}" for k in (c, c + 1)]}
        beam |= {"at": [(c - 0.5) * spacing, 0.0], "width": spacing, "depth": asked["deep"], "height": asked["high"]}
        blocks.append(beam | {"density": density})
    pairs = [{"between": [f"architrave{c}", f"architrave{c + 1}"], LENGTH: spacing} for c in range(1, columns - 1)]
    return {"block": blocks, "joint": pairs}


def _middle_line(asked: Asked) -> tuple[float, float]:
    """Return the radius, m, and the angle, rad, of the middle line of an arch."""
    half, rise = 0.5 * asked["span"], asked["rise"]
    return 0.5 * (half**2 / rise + rise), 4.0 * math.atan2(rise, half)


def _arch(asked: Asked) -> dict[str, Any]:
    """Return the voussoirs of an arch from the span and the rise of its middle line."""
    radius, angle = _middle_line(asked)
    law = {"stiffness": 1e9, "damping": 0.0}  # replaced by the law in the file
    sizes = asked["thickness"], asked["depth"]
    found = arch(int(asked["voussoirs"]), radius, *sizes, law, angle, asked["density"]).to_dict()
    return {name: found[name] for name in ("block", "joint")}


def _stacks(asked: Asked) -> dict[str, Any]:
    """Return equal stacks in a row along x that no joint connects."""
    sizes = {"width": asked["width"], "depth": asked["depth"], "height": asked["height"], "density": asked["density"]}
    apart = asked["width"] + asked["gap"]
    places = [[k * apart, 0.0] for k in range(int(asked["stacks"]))]
    shared: dict[str, Any] = {"repeat": int(asked["levels"]), "on": "base"}
    return {"block": [{"name": f"stack{k}", **shared, "at": at, **sizes} for k, at in enumerate(places, start=1)]}


def _casks(asked: Asked) -> dict[str, Any]:
    """Return casks in a grid, named A1, A2, ..., B1, of which each may hit those beside it and across corners."""
    pitch = asked["diameter"] + asked["gap"]
    cask = {"shape": "drum", "on": "base", **{key: asked[key] for key in ("diameter", "height", "mass")}}
    law = {
        "reach": 1.5 * pitch - asked["diameter"],
        "line_stiffness": LINE_STIFFNESS,
        "restitution": RESTITUTION,
        "friction": asked["friction"],
    }
    blocks = [
        {"name": f"{ascii_uppercase[row]}{number + 1}", **cask, "at": [number * pitch, row * pitch]}
        for row in range(int(asked["rows"]))
        for number in range(int(asked["columns"]))
    ]
    return {"neighbours": law, "block": blocks}


def mass_of_statue(asked: Asked, prefix: str = "") -> float:
    """Estimate the mass of a statue, kg: its material fills a part of the box over its base; three digits."""
    return float(f"{asked.get('part', PART_OF_BOX) * _mass_of_box(asked, prefix):.3g}")


def masses_of_statue(asked: Asked, prefix: str = "") -> Limits:
    """Return the limits of the mass of a statue, kg, and their meaning; `prefix` begins the names of its sizes."""
    least, most = (part * _mass_of_box(asked, prefix) for part in MASSES)
    return (least, most), f"a mass in kg, from {least:.3g} to {most:.3g} in a box of that size"


def _mass_of_box(asked: Asked, prefix: str) -> float:
    height, width, depth = (asked[f"{prefix}{key}"] for key in ("height", "width", "depth"))
    return asked["density"] * height * width * depth


def _isolated(asked: Asked) -> dict[str, Any]:
    """Return a statue and its pedestal on a slab on four pendulum bearings."""
    density, width = asked["density"], asked["slab"]
    gap, corner = 0.1, 0.4 * width
    slab: dict[str, Any] = {"name": "slab", "position": [0.0, 0.0, gap], "width": width, "depth": width, "height": 0.2}
    blocks: list[dict[str, Any]] = [slab | {"density": density}]
    for name, on in (("pedestal", "slab"), ("statue", "pedestal")):
        sizes = {key: asked[f"{name}_{key}"] for key in ("width", "depth", "height")}
        known = {"mass": asked["statue_mass"]} if name == "statue" else {"density": density}
        blocks.append({"name": name, "on": on, **sizes, **known})
    full = density * sum(block["width"] * block["depth"] * block["height"] for block in blocks[:-1])
    weight = (full + asked["statue_mass"]) * STANDARD_GRAVITY
    bearing = {
        **{"kind": "pendulum", "between": ["slab", "base"], "diameter": 0.1, "capacity": asked["capacity"]},
        "at": [[x * corner, y * corner, gap] for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))],
        "radius": STANDARD_GRAVITY * (asked["period"] / (2.0 * math.pi)) ** 2,
        "friction": asked["bearing_friction"],
        "initial_stiffness": float(f"{asked['bearing_friction'] * weight / 4.0 / SLIDES_AT:.2g}"),
        **{"vertical_stiffness": float(f"{weight * VERTICAL:.2g}"), "vertical_damping": 1e-3},
    }
    return {"block": blocks, "bearing": [bearing]}


def _columns(asked: Asked) -> Limits:
    most = MOST_CASKS // int(asked["rows"])
    return (1.0, float(most)), f"a whole number from 1 to {most}"


def _mass_of_cask(asked: Asked) -> float:
    """Return the mass of a solid cask, kg; three digits."""
    return float(f"{asked['density'] * 0.25 * math.pi * asked['diameter'] ** 2 * asked['height']:.3g}")


def _rises(asked: Asked) -> Limits:
    most = 0.5 * asked["span"]
    return (0.01, most), f"a length in m, up to half of the span, {most:g}: a semicircle"


BUILT = {
    "colonnade": Built(
        "columns of drums in a row, under architraves",
        {
            "columns": Question("number of columns", 2, SEVERAL),
            "spacing": Question("distance of their axes (m)", 3.0),
            "drums": Question("number of drums in each", 6, COUNTS),
            "height": Question("height of a column (m)", 6.0),
            "bottom": Question("diameter at the bottom (m)", 1.0),
            "top": Question("diameter at the top (m)", 0.85),
            "high": Question("height of the architraves (m)", 0.8),
            "deep": Question("depth of the architraves, across the row (m)", 0.8),
        },
        _colonnade,
        lambda asked: asked["height"] / asked["drums"],
        lambda asked: min(asked["bottom"], asked["top"], asked["deep"]),
    ),
    "arch": Built(
        "an arch of equal voussoirs on the ground",
        {
            "voussoirs": Question("number of voussoirs", 9, COUNTS),
            "span": Question("span of its middle line (m)", 6.0),
            "rise": Question("rise of its middle line (m)", lambda asked: 0.5 * asked["span"], _rises),
            "thickness": Question("thickness, along the radius (m)", lambda asked: 0.15 * asked["span"]),
            "depth": Question("depth, across (m)", 1.0),
        },
        _arch,
        lambda asked: math.prod(_middle_line(asked)) / asked["voussoirs"],
        lambda asked: min(asked["thickness"], asked["depth"]),
    ),
    "stacks": Built(
        "equal stacks of blocks side by side, that do not touch",
        {
            "stacks": Question("number of stacks", 2, COUNTS),
            "levels": Question("number of blocks in each", 3, COUNTS),
            "width": Question("width of a block, along the row (m)", 0.8),
            "depth": Question("depth of a block (m)", 0.8),
            "height": Question("height of a block (m)", 0.8),
            "gap": Question("gap between two stacks (m)", 0.1),
        },
        _stacks,
        lambda asked: asked["height"],
        lambda asked: min(asked["width"], asked["depth"]),
    ),
    "isolated": Built(
        "a statue and its pedestal on a slab on four pendulum bearings",
        {
            **{
                f"{name}_{key}": Question(f"{key} of the {name} (m)", usual)
                for name, sizes in (("statue", (0.5, 0.45, 1.9)), ("pedestal", (0.9, 0.8, 0.8)))
                for key, usual in zip(("width", "depth", "height"), sizes, strict=True)
            },
            "statue_mass": Question(
                f"mass of the statue (kg), if unknown {PART_OF_BOX:g} of height x width x depth",
                partial(mass_of_statue, prefix="statue_"),
                partial(masses_of_statue, prefix="statue_"),
            ),
            "slab": Question("width of the square slab (m)", 1.6),
            "period": Question("period of the bearings (s)", 2.0, ((0.5, 10.0), "a period in s, from 0.5 to 10")),
            "bearing_friction": Question("their coefficient of friction", 0.06, FRICTIONS),
            "capacity": Question("displacement that they allow (m)", 0.25),
        },
        _isolated,
        lambda asked: asked["statue_height"],
        lambda asked: min(asked["statue_width"], asked["statue_depth"]),
    ),
    "casks": Built(
        "equal round casks in a row or a grid, that may slide and hit each other",
        {
            "rows": Question("number of rows", 1, ((1.0, 26.0), "a whole number from 1 to 26")),
            "columns": Question("number of casks in a row", 4, _columns),
            "diameter": Question("diameter of a cask (m)", 2.4),
            "height": Question("height of a cask (m)", 5.0),
            "mass": Question("mass of a cask (kg)", _mass_of_cask, ((1.0, 1e7), "a mass in kg, from 1 to 1e7")),
            "gap": Question("clear gap between two casks (m)", 0.5),
            "friction": Question(
                "coefficient of friction, on the ground and between casks",
                0.4,
                FRICTIONS,
            ),
        },
        _casks,
        lambda asked: asked["height"],
        lambda asked: asked["diameter"],
    ),
}


def origin_of_stiffness(material: Material) -> str:
    """Return a comment that says how the stiffness of joints follows from a material."""
    return "E / H of masonry" if material.has_joints else "1 / (H / E + 1 / 5e9): a dry joint, estimated"


def bounce_damping(structure: Structure) -> float:
    """Return eta, s, at which blocks bounce with critical damping: the median of 2 sqrt(m / (k A)), to two digits.

    k A is the sum over all joints under a block.
    """
    beds = np.zeros(structure.n)
    for joint in structure.joints:
        beds[joint.upper] += joint.bed.stiffness * joint.moments[0]
    masses = np.array([block.mass for block in structure.blocks])
    return float(f"{np.median(2.0 * np.sqrt(masses[beds > 0.0] / beds[beds > 0.0])):.2g}")


def structure_text(name: str, built: Built, asked: Asked, law: AskedLaw) -> str:
    """Return the text of the file of a structure with these answers in SI units, with comments. Raises InputError."""
    found = law.found
    why, high = origin_of_stiffness(found), built.high(asked)
    lines = [
        f"# {built.text[0].upper()}{built.text[1:]}. Lengths in m along x, y and z (up), masses in kg.",
        f"# {law.material}: {found.source}",
        "# Better than any table: measure a natural frequency, and choose the stiffness by `multiblock modes`.",
        f'name = "{name}"',
        "",
        "[joints]                     # of every joint",
        f"stiffness = {found.modulus(high):.4g}        # N/m3, of the material: {why}, H = {high:.4g} m",
        f"damping = {law.damping!r}            # s, eta: a mode of frequency f has the damping ratio pi f eta",
        f"strength = {found.strength!r}      # Pa, with which `multiblock check` compares the pressure",
    ]
    lines += law.lines
    for table, parts in built.parts(asked).items():
        if isinstance(parts, Mapping):
            lines += ["", f"[{table}]  # line_stiffness (N/m2) and restitution are choices: docs/neighbours.md"]
            lines += [f"{key} = {_value(value)}" for key, value in parts.items()]
            continue
        for part in parts:
            note = MASS_NOTE if part.get("name") == "statue" else ()
            lines += ["", f"[[{table}]]", *note]
            lines += [f"{key} = {_value(value)}" for key, value in part.items() if key != LENGTH]
            own = part.get(LENGTH, part["height"] if "on" in part else high)
            if own != high:
                key = "stiffness" if table == "joint" else "joint.stiffness"
                lines.append(f"{key} = {found.modulus(own):.4g}  # N/m3, H = {own:.4g} m")
    return "\n".join(lines) + "\n"


def _value(value: Any) -> str:
    """Format a value as TOML."""
    if isinstance(value, float):
        value = round(value, 10)
        return repr(value) if value == round(value) else f"{value:.10g}"
    if isinstance(value, Sequence) and not isinstance(value, str):
        return f"[{', '.join(map(_value, value))}]"
    return json.dumps(value)
