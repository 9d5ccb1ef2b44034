"""The command `new`: asks about a column or structure, and writes its file with comments and sources of its values."""

from __future__ import annotations

import argparse
import tomllib
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

from ..common.errors import InputError, reading
from ..common.files import MB, check_file_name, check_outputs, whole_file
from ..common.text import lines_of
from ..common.text_tables import table_of
from ..models.column.materials import MATERIALS
from ..models.column.model import Column
from ..models.column.rest import check_rest
from ..models.structure.blocks.meshes import UP
from ..models.structure.model import Structure
from ..statics.rocking import column_damping_on_edge, critical_damping, restitution_sentence
from .command_files import add_force, check_suffix
from .new_contacts import Touching, asked_contact, strips_of
from .new_mesh import new_from_mesh
from .new_structures import (
    BUILT,
    LEAST_PART,
    MASS_NOTE,
    MOST_PART,
    PART_OF_BOX,
    AskedLaw,
    Built,
    bounce_damping,
    mass_of_statue,
    masses_of_statue,
    origin_of_stiffness,
    structure_text,
)
from .questions import HEIGHT, SIZE, Limits, Question, answer_to, choice, number, parsed

T = TypeVar("T")

DAMPING = 1e-3  # s, until blocks and joints are known
SURVEYS = (("height", "width", "depth"), ("height", "diameter"))

# options of a mesh, and their usual values
_OF_MESH: dict[str, Any] = {"material": "marble", "unit": 1.0, "repair": False, "feet": 1, "parts": None, "up": None}
DAMPINGS: Limits = ((0.0, 1.0), "a time in s, from 0 to 1")
# the least of EN 1996-1-1 (docs/mortar.md); old lime mortar has less
STRESSES: Limits = ((0.001, 10.0), "a stress in MPa, from 0.001 to 10")
TENSION = Question("tensile strength of the mortar (MPa)", 0.05, STRESSES, 1e6)
COHESION = Question("cohesion of the mortar (MPa)", 0.1, STRESSES, 1e6)


class Shape(NamedTuple):
    """A shape to choose: its description, its questions, and the function that makes blocks from the answers."""

    text: str
    questions: dict[str, Question]
    blocks: Callable[[dict[str, float]], list[dict[str, float]]]


def _stack(asked: dict[str, float], across: str) -> list[dict[str, float]]:
    """Return blocks of equal height, whose sizes vary linearly from the bottom to the top."""
    count = int(asked["count"])
    height, bottom, top = asked["height"] / count, asked["bottom"], asked["top"]
    blocks = []
    for k in range(count):  # from the top
        upper, lower = (top + (bottom - top) * place / count for place in (k, k + 1))
        block = {"height": height, across: lower}
        if upper != lower:
            block[f"top_{across}"] = upper
        if across == "width":
            block |= {"depth": lower} | ({"top_depth": upper} if upper != lower else {})
        blocks.append(block)
    return blocks


def _statue(asked: dict[str, float]) -> list[dict[str, float]]:
    statue = {key: asked[key] for key in ("height", "width", "depth", "mass", "centroid")}
    pedestal = {key: asked[f"pedestal_{key}"] for key in ("height", "width", "depth")}
    return [statue, pedestal]


def _centroids(asked: dict[str, float]) -> Limits:
    return (1e-3, asked["height"]), f"a height in m, up to that of the statue, {asked['height']:g}"


COUNT: Limits = ((1.0, 1000.0), "a whole number from 1 to 1000")
SHAPES = {
    "drums": Shape(
        "a column of round drums",
        {
            "count": Question("number of drums", 6, COUNT),
            "height": Question("height of all drums together (m)", 6.0, HEIGHT),
            "bottom": Question("diameter at the bottom (m)", 1.0),
            "top": Question("diameter at the top (m)", 0.85),
        },
        partial(_stack, across="diameter"),
    ),
    "statue": Shape(
        "a statue on a pedestal",
        {
            "height": Question("height of the statue (m)", 1.8),
            "width": Question("width of its base, in the direction of the motion (m)", 0.5),
            "depth": Question("depth of its base, across (m)", 0.5),
            "part": Question(
                f"part of height x width x depth that it fills, {LEAST_PART:g} if slender, {MOST_PART:g} if draped",
                PART_OF_BOX,
                ((0.01, 1.0), "a part from 0.01 to 1"),
            ),
            "mass": Question("mass of the statue (kg), if unknown that of this part", mass_of_statue, masses_of_statue),
            "centroid": Question(
                "height of its centre of mass over its base (m), half of its own if unknown",
                lambda asked: 0.5 * asked["height"],
                _centroids,
            ),
            "pedestal_height": Question("height of the pedestal (m)", 1.0),
            "pedestal_width": Question("width of the pedestal, in the direction of the motion (m)", 0.7),
            "pedestal_depth": Question("depth of the pedestal, across (m)", 0.7),
        },
        _statue,
    ),
    "tapered": Shape(
        "an obelisk, a pinnacle or a chimney that narrows, square",
        {
            "count": Question("number of blocks", 4, COUNT),
            "height": Question("height of all blocks together (m)", 4.0, HEIGHT),
            "bottom": Question("width at the bottom (m)", 0.8),
            "top": Question("width at the top (m)", 0.5),
        },
        partial(_stack, across="width"),
    ),
    "survey": Shape("blocks from a survey, a table FILE.csv", {}, lambda asked: _survey()),
}


def add_new_command(commands: argparse._SubParsersAction[Any]) -> None:
    """Add the command `new`."""
    parser = commands.add_parser("new", help="asks about a column or structure and writes its file, with comments")
    parser.set_defaults(command=_new)
    parser.add_argument("column", type=Path, nargs="?", metavar="COLUMN.toml", help="the file to write")
    parser.add_argument("-o", "--output", type=Path, metavar="FILE.toml", help="the same, beside --mesh")
    parser.add_argument("--mesh", type=Path, metavar="FILE", help="a closed mesh (OBJ, STL, glTF) as a block in space")
    parser.add_argument("--material", default=_OF_MESH["material"], help=f"of the mesh: {', '.join(MATERIALS)}")
    parser.add_argument(
        "--unit", type=float, default=_OF_MESH["unit"], help="m per unit of the mesh, 1e-3 if it is in mm (default: 1)"
    )
    parser.add_argument("--repair", action="store_true", help="flip triangles of the mesh that face inwards")
    parser.add_argument(
        "--feet",
        type=int,
        default=_OF_MESH["feet"],
        metavar="N",
        help="number of separate feet of the mesh (default: 1)",
    )
    words = "largest number of convex parts of the mesh (default: its hull)"
    parser.add_argument("--parts", type=int, metavar="N", help=words)
    parser.add_argument("--up", choices=UP, help="axis of the mesh that points up (default: y of glTF, else z)")
    add_force(parser)


def _new(options: argparse.Namespace) -> None:
    if options.column is not None and options.output is not None:
        raise InputError(f"{options.column}: must be left out beside -o {options.output}, both name the file to write")
    path: Path | None = options.column or options.output
    if path is None:
        raise InputError("COLUMN.toml: missing, must be the file to write")
    if options.mesh is not None:
        return new_from_mesh(options, path)
    for key, usual in _OF_MESH.items():
        if getattr(options, key) != usual:
            raise InputError(f"--{key}: must be left out, or --mesh given")
    check_suffix(path, ".toml")
    check_outputs((path,), (), options.force)
    # shape, material and sizes
    name = check_file_name("name", path.stem)
    shapes: dict[str, Shape | Built] = {**SHAPES, **BUILT}
    shape = choice("what stands there", {key: one.text for key, one in shapes.items()}, "drums")
    material = choice("material", {key: found.source for key, found in MATERIALS.items()}, "marble")
    asked = {"density": MATERIALS[material].density}
    for key, question in shapes[shape].questions.items():
        asked[key] = number(question, asked)
    text_of: Callable[[AskedLaw], str]
    if shape in BUILT:
        width, text_of = BUILT[shape].face(asked), partial(structure_text, name, BUILT[shape], asked)
    else:
        blocks = SHAPES[shape].blocks(asked)
        width, text_of = min(map(_least_size, blocks)), partial(column_text, name, SHAPES[shape].text, blocks)
    model_of: Any = Structure.from_dict if shape in BUILT else Column.from_dict
    # contact, damping and friction of the joints
    touching = asked_contact(width, MATERIALS[material].has_joints, asked["width"] if shape == "statue" else 0.0)
    trial = text_of(AskedLaw(material, DAMPING, touching))
    damping = _asked_damping(model_of(tomllib.loads(trial)), touching)
    friction, dowel, mortar = asked.get("friction", 0.0), 0.0, (0.0, 0.0)
    slides = {"yes": "by friction", "no": "they never slide"}
    is_round = 'section = "circle"' in trial or 'shape = "drum"' in trial
    if touching.everywhere and not is_round:  # a round section has no law of mortar
        slides["mortar"] = "once their mortar has broken, which bears tension and cohesion until then"
    sliding = "" if friction else choice("joints may slide", slides, "no")
    if sliding == "mortar":
        friction = MATERIALS[material].friction
        mortar = number(TENSION), number(COHESION)
    elif sliding == "yes":
        friction = MATERIALS[material].friction
        force = ((0.0, 1e9), "a force in kN, zero or positive")
        dowel = number(Question("shear that dowels bear in each joint (kN), 0 without", 0.0, force, 1e3))
    # text of the file, validated before it is written
    text = text_of(AskedLaw(material, damping, touching, friction, dowel, *mortar))
    with reading(path):
        said = (_structure_lines if shape in BUILT else _column_lines)(model_of(tomllib.loads(text)), path)
        with whole_file(path) as beside:
            beside.write_text(text, encoding="utf-8")
    print(*said, sep="\n")


def _least_size(block: dict[str, float]) -> float:
    """Return the least width of the faces of a block (m)."""
    names = ("width", "depth", "diameter", "top_width", "top_depth", "top_diameter")
    return min(block[name] for name in names if name in block)


def _asked_damping(model: Any, touching: Touching) -> float:
    """Ask for the damping, s; the proposal is the critical damping of the rocking part, computed with its joint.

    `model` is a column or a structure, with another damping.
    """
    if model.kind.across:
        proposed = bounce_damping(model)
        words = "damping eta of the joints (s); proposed: 2 sqrt(m / (k A)) of the blocks, no measured value"
    else:
        critical = critical_damping(model) if touching.everywhere else column_damping_on_edge(model)
        proposed = float(f"{min(critical, DAMPINGS[0][1]):.2g}")
        rocks = "2 sqrt(m / (k A)) of the part that rocks"
        what = rocks if touching.everywhere else "critical as it stands on its edge"
        words = f"damping eta of the joints (s); proposed: {what}, no measured value"
    return number(Question(words, proposed, DAMPINGS))


def _column_lines(column: Column, path: Path) -> list[str]:
    """Return the lines to print on a new column, with the next commands. Raises InputError."""
    check_rest(column, from_rest=False)
    height = sum(block.height for block in column.blocks)
    mass = sum(block.mass for block in column.blocks)
    return [
        f"{path}: {column.n} blocks, {height:.4g} m, {mass:.5g} kg.",
        f"{restitution_sentence(column)} `multiblock calibrate` adapts the damping to a measured one.",
        "Next:",
        f"  multiblock statics {path}",
        f"  multiblock check {path} --spectrum ec8 --ag 0.25 --soil B --report report.html",
    ]


def _structure_lines(structure: Structure, path: Path) -> list[str]:
    """Return the lines to print on a new structure, with the next commands."""
    height = max(float(block.corners[:, 2].max()) for block in structure.blocks)
    mass = sum(block.mass for block in structure.blocks)
    return [
        f"{path}: {structure.n} blocks, {len(structure.joints)} joints, {height:.4g} m, {mass:.5g} kg. Next:",
        f"  multiblock simulate {path} --wavelet ricker --frequency 1 --pga 0.3 --view scene.html",
        f"  multiblock check {path} --spectrum ec8 --ag 0.25 --soil B --report report.html",
    ]


def column_text(name: str, what: str, blocks: Sequence[dict[str, float]], law: AskedLaw) -> str:
    """Return the text of a column file, with comments; `Column.from_toml` validates it later.

    `what` describes it in the first comment; `blocks` are their keys from the top down, without joint and density.
    """
    found = law.found
    lines = [
        f"# {what[0].upper()}{what[1:]}. Lengths in m, masses in kg, blocks from the top down.",
        f"# {law.material}: {found.source}",
        "# Better than any table: measure a natural frequency, and `multiblock calibrate --frequencies`.",
        f'name = "{name}"',
        f'material = "{law.material}"           # density, strength and stiffness of all that is not given below',
        "",
        "[joint]                      # of every block, under it",
        f"damping = {law.damping!r}            # s, eta: a mode of frequency f has the damping ratio pi f eta; a guess",
        f"# strength = {found.strength!r}  # Pa, of the material: pressure at the edge is compared with it",
    ]
    lines += law.lines
    # the blocks from the top down
    why = origin_of_stiffness(found)
    for place, block in enumerate(blocks):
        lines += ["", "[[block]]"]
        if "diameter" in block:
            lines.append('section = "circle"')
        if "mass" in block:
            lines += MASS_NOTE
        lines += [f"{key} = {value:.10g}" for key, value in block.items()]
        if "mass" not in block:
            lines.append(f"# density = {found.density:.10g}         # kg/m3, of the material")
        lines.append(f"# joint.stiffness = {found.modulus(block['height']):.4g}  # N/m3, of the material: {why}")
        lines += strips_of(law.touching, block) if place == 0 else []
    return "\n".join(lines) + "\n"


def _survey() -> list[dict[str, float]]:
    """Ask for a table, and return its blocks from the top down: lines of height,width,depth or height,diameter, m."""
    question = "table, with the first line height,width,depth or height,diameter, then blocks from the top down"
    path = Path(answer_to(question, "survey.csv"))
    with reading(path):
        table = table_of(lines_of(path, MB))
        header = tuple(key.lower() for key in table.names)
        if header not in SURVEYS:
            raise InputError("line 1: must be height,width,depth or height,diameter, in m")
        blocks = []
        table.check_widths()
        for line, row in zip(table.lines, table.rows, strict=True):
            values = (parsed(f"line {line}: {key}", text, SIZE) for key, text in zip(header, row, strict=True))
            blocks.append(dict(zip(header, values, strict=True)))
        if not blocks:
            raise InputError("must have a line for each block")
    return blocks
