"""Fragilities as files of other programs: pelicun (CSV) and OpenQuake (NRML 0.5).

Each failure is a component, or a function, with one limit state: failures of a study may cross, damage states may not.
"""

from __future__ import annotations

import itertools
import math
import os
import re
from collections.abc import Mapping
from pathlib import Path
from xml.etree.ElementTree import Element, ElementTree, SubElement, indent

from ..common.errors import InputError
from ..common.files import whole_file, write_table
from .motions import Measure
from .statistics import Fragility

SUFFIXES = (".csv", ".xml")
HEADINGS = ("ID", "Incomplete", "Demand-Type", "Demand-Unit", "Demand-Offset", "Demand-Directional")
DIRECTIONAL = 1  # pelicun multiplies other demands by 1.2, for the worst direction
NRML = "http://openquake.org/xmlns/nrml/0.5"
STATE = "failure"
SPAN = 6.0  # deviations on either side of the median: range of the intensities of NRML
CUSTOMARY = 0.05  # the damping of spectral accelerations in both


def write_fragilities(path: str | os.PathLike[str], name: str, fragilities: Mapping[str, Fragility]) -> None:
    """Write fragilities by the names of their failures, in the format of the suffix: .csv or .xml.

    `name` is that of the study. Raises InputError, OSError.
    """
    write = {".csv": _write_pelicun, ".xml": _write_nrml}.get(Path(path).suffix.lower())
    if write is None:
        raise InputError(f"{path}: must end in {' or '.join(SUFFIXES)}")
    for one in fragilities.values():
        if one.measure is None or (one.measure.period and one.measure.damping != CUSTOMARY):
            said = one.name if one.measure is None else one.measure.label
            raise InputError(
                f"{path}: the fragility is over {said}, must be over pga, pgv or a spectrum of 5 % damping"
            )
    named: dict[str, Fragility] = {}
    for failure, one in fragilities.items():
        cleaned = _cleaned(f"{name}.{failure}")
        numbered = (f"{cleaned}.{k}" for k in itertools.count(2))
        named[next(key for key in itertools.chain((cleaned,), numbered) if key not in named)] = one
    write(path, named)


def _cleaned(name: str) -> str:
    """Return a name in letters, digits and dots; the sign of a negative number becomes a word."""
    return re.sub("[^A-Za-z0-9]+", ".", re.sub(r"(?<![A-Za-z0-9])-(?=\d)", "minus ", name)).strip(".")


def _write_pelicun(path: str | os.PathLike[str], fragilities: Mapping[str, Fragility]) -> None:
    rows = []
    for name, one in fragilities.items():
        measure = one.measure
        assert measure is not None
        kinds = {"pga": "Peak Ground Acceleration", "pgv": "Peak Ground Velocity"}
        kind = kinds.get(measure.name, f"Spectral Acceleration|{measure.period:g}")
        unit = "mps" if measure.name == "pgv" else "g"
        rows.append((name, 0, kind, unit, 0, DIRECTIONAL, "lognormal", one.median, one.deviation))
    write_table(path, [*HEADINGS, "LS1-Family", "LS1-Theta_0", "LS1-Theta_1"], rows)


def _write_nrml(path: str | os.PathLike[str], fragilities: Mapping[str, Fragility]) -> None:
    root = Element("nrml", xmlns=NRML)
    model = SubElement(root, "fragilityModel", id="multiblock", assetCategory="buildings", lossCategory="structural")
    measures = sorted({one.measure.label for one in fragilities.values() if one.measure is not None})
    said = f"lognormal fragilities over {', '.join(measures)}"
    for name, one in fragilities.items():
        if one.measure is not None and one.measure.name.startswith("rotd"):  # the format knows SA alone
            said += f"; {_imt(one.measure)[0]} of {name} is {one.measure.label}"
    SubElement(model, "description").text = said
    SubElement(model, "limitStates").text = STATE
    for name, one in fragilities.items():
        assert one.measure is not None
        imt, factor = _imt(one.measure)
        function = SubElement(model, "fragilityFunction", id=name, format="continuous", shape="logncdf")
        low, high = (factor * one.median * math.exp(sign * SPAN * one.deviation) for sign in (-1.0, 1.0))
        SubElement(function, "imls", imt=imt, noDamageLimit=repr(low), minIML=repr(low), maxIML=repr(high))
        # mean and standard deviation of the intensity, not of its logarithm
        mean = factor * one.median * math.exp(0.5 * one.deviation**2)
        spread = mean * math.sqrt(math.expm1(one.deviation**2))
        SubElement(function, "params", ls=STATE, mean=repr(mean), stddev=repr(spread))
    indent(root)
    with whole_file(path) as partial:
        ElementTree(root).write(partial, encoding="utf-8", xml_declaration=True)


def _imt(measure: Measure) -> tuple[str, float]:
    """Return a measure as OpenQuake names it, and the factor to its unit: g, of velocities cm/s."""
    if measure.name == "pgv":
        return "PGV", 100.0
    return ("PGA" if measure.name == "pga" else f"SA({measure.period:g})"), 1.0
