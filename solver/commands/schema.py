"""The command `schema`: JSON schemas of the files, made from the tables of keys and ranges by which they are read."""

from __future__ import annotations

import argparse
import json
from collections.abc import Collection, Iterable, Mapping
from dataclasses import fields
from typing import Any

from ..common.ranges import LENGTH, MAX_BLOCKS, NUMBERS
from ..ground import building
from ..kernels.column.sections.faces import SECTIONS
from ..kernels.structure.layout import MOST_CORNERS
from ..models import ports
from ..models.column import file as column_file
from ..models.column.block import BLOCK_SECTIONS, Block, Joint
from ..models.column.kind import KIND as COLUMNS
from ..models.column.materials import MATERIALS
from ..models.column.model import Column
from ..models.column.settings import FORMULATIONS, INTEGRATORS, SKIPS, Settings
from ..models.structure import bearing_tables, hull_tables, neighbours
from ..models.structure import file as structure_file
from ..models.structure.blocks.meshes import UP
from ..models.structure.blocks.parts import BESIDE_COLUMN, TOLERANCE
from ..models.structure.kind import STRUCTURES
from ..studies import definition, distributions, motions

Schema = dict[str, Any]
Ranges = Mapping[str, tuple[tuple[float, float], str]]

DRAFT = "https://json-schema.org/draft/2020-12/schema"
NUMBER: Schema = {"type": "number"}
TEXT: Schema = {"type": "string"}
FLAG: Schema = {"type": "boolean"}


def number(limits: tuple[float, float], meaning: str) -> Schema:
    """Return the schema of a number in a closed range."""
    return {**NUMBER, "minimum": limits[0], "maximum": limits[1], "description": meaning}


def whole(least: int, most: int | None = None) -> Schema:
    """Return the schema of a whole number."""
    found: Schema = {"type": "integer", "minimum": least}
    return found if most is None else {**found, "maximum": most}


def one_of(words: Iterable[str]) -> Schema:
    """Return the schema of a choice of words."""
    return {"enum": list(words)}


def several(items: Schema, least: int = 0, most: int | None = None) -> Schema:
    """Return the schema of a list."""
    found: Schema = {"type": "array", "items": items, "minItems": least}
    return found if most is None else {**found, "maxItems": most}


def vector(count: int) -> Schema:
    """Return the schema of a list of `count` numbers."""
    return several(NUMBER, count, count)


def one_or_several(item: Schema, least: int = 1, most: int | None = None) -> Schema:
    """Return the schema of a list that is an item, itself a list, or a list of such items."""
    return {"type": "array", "anyOf": [item, several(item, least, most)]}


def table(
    keys: Iterable[str],
    forms: Mapping[str, Schema] | None = None,
    required: Collection[str] = (),
    ranges: Ranges = NUMBERS,
    owner: type | None = None,
) -> Schema:
    """Return the schema of a table with these keys; no others are valid.

    Parameters
    ----------
    forms : mapping, optional
        The schemas of the keys that are no numbers. A key that has neither a schema nor a range may be anything.
    required : collection of str
        The keys that must be given.
    ranges : mapping
        The range of each number, with its meaning.
    owner : type, optional
        The dataclass whose fields have the defaults.
    """
    known = {key: number(*limits) for key, limits in ranges.items()} | dict(forms or {})
    usual = {item.name: {"default": item.default} for item in fields(owner)} if owner else {}
    usual = {key: value for key, value in usual.items() if value["default"] and type(value["default"]) in (float, str)}
    properties = {key: {**known.get(key, {}), **usual.get(key, {})} for key in keys}
    return {"type": "object", "properties": properties, "required": list(required), "additionalProperties": False}


def by_word(key: str, cases: Mapping[str, tuple[Collection[str], Collection[str]]], usual: str = "") -> Schema:
    """Return the rules on the keys of a table that depend on the word of `key`, `usual` if there is none.

    `cases` has by word the keys that are valid, and those of them that are required.
    """
    rules = []
    for word, (keys, required) in cases.items():
        chosen = {"properties": {key: {"const": word}}, "required": [] if word == usual else [key]}
        then = {"propertyNames": one_of(keys), "required": list(required)}
        rules.append({"if": chosen, "then": then})
    return {"allOf": rules}


def _of_pairs() -> Schema:
    """Return the schema of the table of neighbours."""
    ranges = {**neighbours.RANGES, "after_fall": neighbours.AFTER_FALL}
    pair = table(neighbours._OF_PAIR, {"between": several(TEXT, 2, 2)}, ("between",), ranges)
    sizes = {"width": LENGTH, "height": LENGTH}
    wall = table(neighbours._OF_WALL, {"at": vector(3), "normal": vector(2)}, neighbours._OF_WALL, sizes)
    return table(neighbours.KEYS, {"pair": several(pair), "wall": several(wall)}, (), ranges)


def _port(at: Schema) -> Schema:
    """Return the schema of the tables of ports, whose points are `at`."""
    return several(table(ports.KEYS, {"name": TEXT, "block": TEXT, "at": at}, ("name", "block")))


def column_schema() -> Schema:
    """Return the schema of a column file."""
    material = one_of(MATERIALS)
    words = {"section": one_of(SECTIONS), "strips": several(NUMBER, 1)}
    joint = table(column_file._JOINT_KEYS, words, owner=Joint)
    of_block: dict[str, Schema] = {
        "material": material,
        "section": one_of(BLOCK_SECTIONS),
        "joint": joint,
        "load": table(column_file._LOAD_KEYS, required=("mass",)),
        "repeat": whole(1, MAX_BLOCKS),
    }
    block = table(column_file._BLOCK_KEYS, of_block, ("height",), owner=Block)
    settings = {
        "formulation": one_of(FORMULATIONS),
        "integrator": one_of(INTEGRATORS),
        "without": several(one_of(SKIPS)),
    }
    forms: dict[str, Schema] = {
        "name": TEXT,
        "material": material,
        "block": several(block, 1),
        "joint": joint,
        "solver": table(column_file._SETTINGS_KEYS, settings, owner=Settings),
        "profile": several(vector(2), 2),
        "port": _port(several(NUMBER, 2, 3)),
        "neighbours": _of_pairs(),
    }
    return table(dict.fromkeys((*column_file._COLUMN_KEYS, *BESIDE_COLUMN)), forms, ("name", "block"), owner=Column)


def _block_in_space(law: Schema) -> Schema:
    """Return the schema of a block of a structure; `law` is that of its joint."""
    names: Schema = {"type": ["string", "array"], "items": TEXT}
    forms: dict[str, Schema] = {
        **dict.fromkeys(("name", "file"), TEXT),
        "shape": {**one_of(structure_file.SHAPES), "default": "box"},
        "on": names,
        "joint": law,
        "at": vector(2),
        **dict.fromkeys(("position", "rotation", "centroid"), vector(3)),
        "repeat": whole(1, MAX_BLOCKS),
        "outline": several(vector(2), 3),
        "points": several(vector(3), 4),
        "faces": several(several(whole(0), 3)),
        "foot": one_or_several(several(vector(2), 3, MOST_CORNERS + 1), 0, hull_tables.MOST_FEET),
        "feet": whole(1, hull_tables.MOST_FEET),
        "parts": whole(1, hull_tables.MOST_PARTS) | {"type": ["integer", "array"], "items": whole(4)},
        "inertia": vector(6),
        "up": one_of(UP),
        "repair": FLAG,
        "bore": number((0.0, LENGTH[0][1]), "a length in m, zero or positive"),
    }
    of_hull = {"scale": hull_tables.FACTOR, "unit": hull_tables.FACTOR, "level": hull_tables._LEVEL}
    ranges = {**NUMBERS, **of_hull, "volume": hull_tables._SIZE}
    shapes = structure_file._OF_SHAPE
    keys = dict.fromkeys((*structure_file._BLOCK, *(key for shape in shapes.values() for key in shape)))
    cases = {shape: ((*structure_file._BLOCK, *own), ()) for shape, own in shapes.items()}
    return table(keys, forms, (), ranges) | by_word("shape", cases, "box")


def _bearing(forms: Mapping[str, Schema]) -> Schema:
    """Return the schema of a table of bearings; `forms` has what it shares with joints."""
    place, needed, kinds = bearing_tables._PLACE, bearing_tables._NEEDED, bearing_tables.KINDS
    beside = (*bearing_tables._OF_RIM, "strength")
    cases = {
        kind: ((*place, *needed, *own, *others, *beside), ("between", "at", *needed, *own))
        for kind, (own, others) in kinds.items()
    }
    radius = number(*bearing_tables.RANGES["radius"])
    radius = several(radius, 2, 2) | radius | {"type": ["number", "array"]}
    own_forms = {"kind": one_of(kinds), "at": one_or_several(vector(3)), "radius": radius, "tension": FLAG}
    keys = dict.fromkeys(key for allowed, _ in cases.values() for key in allowed)
    return table(keys, {**forms, **own_forms}, ("kind",), bearing_tables.RANGES) | by_word("kind", cases)


def structure_schema() -> Schema:
    """Return the schema of a structure file, bearings included."""
    ranges = {**NUMBERS, **structure_file.OWN_RANGES}
    law = table(structure_file._LAW, ranges=ranges)
    bodies = {"between": several({"type": ["string", "integer"]}, 2, 2)}
    placed = {**bodies, "at": vector(3), "normal": vector(3)}
    own = {**placed, "section": one_of(structure_file._OF_SECTION), "outline": several(vector(2), 3)}
    joint = table(structure_file._JOINT, own, ("between",), ranges)
    ends = {**bodies, "from": vector(3), "to": vector(3), "tension_only": FLAG}
    tie = table(structure_file._TIE, ends, ("between", "from", "to", "stiffness"), structure_file.OF_TIES)
    settings = {"tolerance": {**number(*NUMBERS["tolerance"]), "default": TOLERANCE}, "without": several(TEXT)}
    forms: dict[str, Schema] = {
        "name": TEXT,
        "block": several(_block_in_space(law), 1),
        "joint": law | several(joint) | {"type": ["array", "object"]},
        "joints": law,
        "bearing": several(_bearing(placed)),
        "tie": several(tie),
        "port": _port(vector(3)),
        "neighbours": _of_pairs(),
        "solver": table(settings, settings),
    }
    return table(structure_file._KEYS, forms, ("name", "block"))


def _motion() -> Schema:
    """Return the schema of a motion of a study: a formula with its numbers, or a record."""
    shared, record = ("name", "load", *motions.ON_FLOOR), motions._OF_RECORDS
    cases = {name: ((*shared, "formula", *sorted(motions.Shaking.numbers_of(name))), ()) for name in motions.FORMULAS}
    numbers = sorted({key for keys, _ in cases.values() for key in keys} - {*shared, "formula"})
    forms: dict[str, Schema] = dict.fromkeys(numbers, NUMBER)
    forms |= {key: {"type": ["string", "number"]} for key in record}
    forms |= {"name": TEXT, "load": {"type": "object"}, "formula": one_of(cases), "record": TEXT}
    forms |= {"building": TEXT, "floor": whole(0)}
    rules = by_word("formula", cases)
    of_record = {"propertyNames": one_of((*shared, *record, *motions.BESIDE))}
    rules["allOf"].append({"if": {"required": ["record"]}, "then": of_record})
    rules["dependentRequired"] = {"building": ["floor"], "floor": ["building"]}
    return table(forms, forms) | rules | {"oneOf": [{"required": ["record"]}, {"required": ["formula"]}]}


def study_schema() -> Schema:
    """Return the schema of a study file."""
    spacing = {"from": NUMBER, "to": NUMBER, "count": whole(2), "spacing": one_of(("linear", "log"))}
    axis = table(spacing, spacing, ("from", "to", "count")) | several(NUMBER) | {"type": ["array", "object"]}
    beside, tails = ("distribution", *distributions._BESIDE), distributions._TAILS
    cases = {
        kind: ((*beside, *needs, *(tails if kind in distributions._CAN_BE_CUT else ())), needs)
        for kind, needs in distributions._NEEDS.items()
    }
    drawn: dict[str, Schema] = dict.fromkeys((key for keys, _ in cases.values() for key in keys), NUMBER)
    drawn |= dict.fromkeys(distributions._BESIDE, FLAG)
    drawn |= {"distribution": one_of(cases), "values": several(NUMBER, 1)}
    random = table(drawn, drawn, ("distribution",)) | by_word("distribution", cases)
    measure = {"measure": one_of(motions.MEASURES), "period": NUMBER, "damping": NUMBER}
    forms: dict[str, Schema] = {
        "name": TEXT,
        "kind": one_of(definition.KINDS),
        **{key: several(TEXT, 1) if key.endswith("s") else TEXT for key in definition.SUBJECTS},
        "motion": several(_motion(), 1),
        "grid": {"type": "object", "additionalProperties": axis},
        "random": {"type": "object", "additionalProperties": random},
        "intensity": table(measure, measure, ("measure",)),
        "samples": whole(1),
        "sampling": {**one_of(definition.SAMPLINGS), "default": definition.SAMPLINGS[0]},
        "seed": whole(0),
        "keep": several(one_of(dict.fromkeys((*COLUMNS.kept, *STRUCTURES.kept))), 1),
        "duration": {**NUMBER, "exclusiveMinimum": 0.0, "description": "a positive time in s"},
        "limits": axis,
    }
    return table(definition._KEYS, forms, ("name", "kind", "motion"))


def building_schema() -> Schema:
    """Return the schema of a building file: by a beam, or by modes."""
    storeys, factors = whole(1, building.MOST_STOREYS), several(number(*building.FACTOR), 1, building.MOST_STOREYS)
    damping = number(*building.DAMPING) | {"default": building.USUAL_DAMPING}
    ranges = {"period": building.PERIOD, "period_y": building.PERIOD, "height": LENGTH}
    ranges |= {"alpha": building.ALPHA, "alpha_y": building.ALPHA}
    mode = table(building.OF_MODE, {"damping": damping, "x": factors, "y": factors}, ("period",), ranges)
    mode |= {"anyOf": [{"required": ["x"]}, {"required": ["y"]}]}
    beam = table(building.OF_BEAM, {"name": TEXT, "storeys": storeys, "damping": damping}, building.BEAM_NEEDS, ranges)
    modes = table(building.OF_MODES, {"name": TEXT, "mode": several(mode, 1)}, ("mode",))
    return table(("building",), {"building": {"type": "object", "oneOf": [beam, modes]}}, ("building",))


SCHEMAS = {
    "column": column_schema,
    "structure": structure_schema,
    "study": study_schema,
    "building": building_schema,
}


def schema_of(kind: str) -> Schema:
    """Return the JSON schema (draft 2020-12) of a kind of file, one of SCHEMAS."""
    return {"$schema": DRAFT, "title": f"{kind} file of multiblock", **SCHEMAS[kind]()}


def add_schema_command(commands: Any) -> None:
    """Add the command `schema`."""
    parser = commands.add_parser("schema", help="the JSON schema of a kind of file, for editors")
    parser.set_defaults(command=_schema)
    parser.add_argument("kind", nargs="?", choices=SCHEMAS, metavar="KIND", help=f"{', '.join(SCHEMAS)}; else all")


def _schema(options: argparse.Namespace) -> None:
    found = schema_of(options.kind) if options.kind else {kind: schema_of(kind) for kind in SCHEMAS}
    print(json.dumps(found, indent=1))
