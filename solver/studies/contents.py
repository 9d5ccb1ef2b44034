"""Validation of the journal of a study: invalid content is refused even if its checksum is right."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from ..common.errors import InputError, check_whole, shown
from ..common.files import check_file_name
from ..common.ranges import check_choice
from ..models.protocol import WORDS
from .definition import KINDS, MOST_RUNS, SAMPLINGS
from .distributions import Random
from .motions import MEASURES, Measure
from .subjects import always_kept, check_alike, kind_in, sizes_of, subject_from

FAILED = "failed"  # the verdict of a run that the solver could not finish


def check_head(head: Mapping[str, Any]) -> None:
    """Raise InputError unless the first line of a journal describes a study."""
    study = _part(head, "study", dict)
    _part(head, "versions", dict)
    runs, blocks = _whole(head, "runs", 1, MOST_RUNS), _whole(head, "blocks", 1, 10**6)
    # the study
    check_file_name("study.name", _part(study, "name", str))
    check_choice("study.kind", study.get("kind"), KINDS)
    check_choice("study.sampling", study.get("sampling"), SAMPLINGS)
    _whole(study, "seed", 0, math.inf)
    samples = _whole(study, "samples", 1, MOST_RUNS)
    # its models and motions
    columns = [subject_from(_is(f"columns[{k}]", table, dict)) for k, table in enumerate(_part(study, "columns", list))]
    check_alike(columns)
    sizes, kind = sizes_of(columns), columns[0].kind
    _must("blocks", blocks, blocks == sizes["block"], f"{sizes['block']}, the most of a column")
    _must("sizes", head.get("sizes"), head.get("sizes") == (sizes if kind.across else None), f"{sizes}, of structures")
    motions = [_is(f"motions[{k}]", table, dict) for k, table in enumerate(_part(study, "motions", list))]
    for table in motions:
        _part(table, "name", str)
    # grid, number of runs, random parameters, measure
    grid = _part(study, "grid", dict)
    for name in grid:
        _numbers(f"grid.{name}", _part(grid, name, list), finite=True)
    made = len(columns) * len(motions) * samples * math.prod(map(len, grid.values()))
    _must("runs", runs, runs == made, f"{made}, as the study has them")
    for name, table in _part(study, "random", dict).items():
        Random.from_table(f"random.{name}", table)
    _must("study.intensity", None, "intensity" in study, "a table, or null")
    if study["intensity"] is not None:
        Measure.from_table(_part(study, "intensity", dict))
    # limits, and the names of outputs, varied numbers and measures
    _numbers("limits", _part(study, "limits", list), finite=True)
    _names("keep", _part(study, "keep", list), tuple(kind.kept), always_kept(kind))
    _names("varied", _part(head, "varied", list), None, ("column", "motion", *grid))
    _names("measured", _part(head, "measured", list), MEASURES, ("pga", "pgv"))


def check_row(head: Mapping[str, Any], row: Any) -> None:
    """Raise InputError unless a later line of that journal is a run: [number, values, measures, outputs, failure]."""
    study = head["study"]
    _must("run", row, isinstance(row, list) and len(row) == 5, "a list of number, values, measures, outputs, failure")
    # number, varied values and measures of the run
    number, values, measures, outputs, failure = row
    _must("run", number, type(number) is int and 0 <= number < head["runs"], f"a number below {head['runs']}")
    for key, found, names in (("values", values, head["varied"]), ("measures", measures, head["measured"])):
        _must(key, found, isinstance(found, list) and len(found) == len(names), f"a list of {len(names)} numbers")
    _numbers("values", values, finite=outputs is not None)  # a run of infinite numbers has failed
    for name, value, count in zip(
        ("column", "motion"), values, map(len, (study["columns"], study["motions"])), strict=False
    ):
        _must(name, value, value in range(count), f"a whole number below {count}")
    _numbers("measures", [value for value in measures if value is not None])
    _is("failure", failure, str)
    if outputs is None:
        return
    # outputs: texts, numbers, or one number per part of the model
    _is("outputs", outputs, dict)
    for name in study["keep"]:
        value = outputs.get(name)
        if name in WORDS:
            check_choice(name, value, (*WORDS[name], FAILED))
        elif kind_in(head).kept[name].kind is not None:
            _numbers(name, [value])
        else:
            most = length_of(head, name)
            _must(name, value, isinstance(value, list) and len(value) <= most, f"at most {most} numbers")
            _numbers(name, value)


def length_of(head: Mapping[str, Any], name: str) -> int:
    """Return the length of a result of one run, the largest over the models of the study.

    It counts blocks for columns; blocks, joints, ties or components for structures.
    """
    return int(head["sizes"][kind_in(head).kept[name].of] if "sizes" in head else head["blocks"])


def _must(key: str, value: Any, right: bool, meaning: str) -> None:
    if not right:
        raise InputError(f"{key} = {shown(value)}: must be {meaning}")


def _is(key: str, value: Any, kind: type) -> Any:
    words = {dict: "a table", list: "a list", str: "a text", bool: "true or false"}
    _must(key, value, isinstance(value, kind), words[kind])
    return value


def _part(table: Mapping[str, Any], key: str, kind: type) -> Any:
    return _is(key, table.get(key), kind)


def _whole(table: Mapping[str, Any], key: str, low: int, high: float) -> int:
    return check_whole(key, table.get(key), low, high, f"a whole number, at least {low}")


def _numbers(key: str, values: list[Any], finite: bool = False) -> None:
    for value in values:
        is_number = type(value) is float or (type(value) is int and abs(value) < 2**63)
        _must(key, value, is_number and (math.isfinite(value) or not finite), "a number")


def _names(key: str, names: list[Any], known: tuple[str, ...] | None, needed: tuple[str, ...]) -> None:
    """Raise InputError unless `names` are unique, among `known` (None: any), and include all `needed`."""
    texts = all(isinstance(name, str) and (known is None or name in known) for name in names)
    _must(key, names, texts and len(set(names)) == len(names) and set(needed) <= set(names), "names, each once")
