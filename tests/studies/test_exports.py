"""Exports of fragilities: by the documented forms of pelicun 3 and of OpenQuake's NRML 0.5."""

from __future__ import annotations

import csv
import math
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from scipy.stats import lognorm
from studies.test_risk import curve

from solver import InputError
from solver.studies import Measure
from solver.studies.exports import NRML, write_fragilities

FRAGILITIES = {
    "0.1 m": curve(0.3, 0.4),
    "hit, gap 5 mm": replace(curve(0.25, 0.6), measure=Measure("pgv")),
    "overturned": replace(curve(0.7, 0.5), measure=Measure("rotd50", 0.8)),
}


def test_pelicun_reads_demand_median_and_deviation(tmp_path: Path) -> None:
    write_fragilities(tmp_path / "fragility.csv", "my study", FRAGILITIES)
    with open(tmp_path / "fragility.csv", newline="", encoding="utf-8") as file:
        rows = {row["ID"]: row for row in csv.DictReader(file)}
    # names of pelicun's vocabulary of demands and units; Theta_0 is the median, Theta_1 the deviation of the logarithm
    demands = [(row["Demand-Type"], row["Demand-Unit"]) for row in rows.values()]
    assert demands == [
        ("Peak Ground Acceleration", "g"),
        ("Peak Ground Velocity", "mps"),
        ("Spectral Acceleration|0.8", "g"),
    ]
    assert list(rows) == ["my.study.0.1.m", "my.study.hit.gap.5.mm", "my.study.overturned"]
    for row, one in zip(rows.values(), FRAGILITIES.values(), strict=True):
        assert (row["LS1-Family"], row["Incomplete"], row["Demand-Offset"]) == ("lognormal", "0", "0")
        assert row["Demand-Directional"] == "1"  # else pelicun multiplies the demand by 1.2
        assert (float(row["LS1-Theta_0"]), float(row["LS1-Theta_1"])) == (one.median, one.deviation)


def test_openquake_gets_back_the_same_curves(tmp_path: Path) -> None:
    """Check the curves by the mean and standard deviation of the intensity, as the manual defines them."""
    write_fragilities(tmp_path / "fragility.xml", "my study", FRAGILITIES)
    root = ElementTree.parse(tmp_path / "fragility.xml").getroot()
    space = {"n": NRML}
    assert root.tag == f"{{{NRML}}}nrml"
    model = root.find("n:fragilityModel", space)
    assert model is not None
    assert set(model.attrib) == {"id", "assetCategory", "lossCategory"}
    states = (model.findtext("n:limitStates", "", space)).split()
    assert "RotD50(0.8 s, 5 %)" in model.findtext("n:description", "", space)
    functions = model.findall("n:fragilityFunction", space)
    units = {"PGA": 1.0, "PGV": 100.0, "SA(0.8)": 1.0}  # of g; cm/s of a velocity in m/s
    assert [function.find("n:imls", space).get("imt") for function in functions] == list(units)  # type: ignore[union-attr]
    for function, one, factor in zip(functions, FRAGILITIES.values(), units.values(), strict=True):
        assert (function.get("format"), function.get("shape")) == ("continuous", "logncdf")
        range_ = function.find("n:imls", space)
        assert range_ is not None
        assert 0.0 < float(range_.attrib["minIML"]) < factor * one.median < float(range_.attrib["maxIML"])
        (params,) = function.findall("n:params", space)
        assert [params.get("ls")] == states
        mean, deviation = (float(params.attrib[name]) for name in ("mean", "stddev"))
        sigma = math.sqrt(math.log1p((deviation / mean) ** 2))
        scale = mean**2 / math.hypot(mean, deviation)
        intensity = np.array([0.05, 0.3, 0.9])
        found = lognorm.cdf(factor * intensity, sigma, scale=scale)
        np.testing.assert_allclose(found, one.probability(intensity), rtol=1e-9)


def test_mistakes_of_exports(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"fragility\.json: must end in \.csv or \.xml"):
        write_fragilities(tmp_path / "fragility.json", "s", FRAGILITIES)
    for one, said in ((replace(curve(1.0, 0.5), measure=None), "pga"), (Measure("sa", 1.0, 0.02), r"Sa\(1 s, 2 %\)")):
        other = one if not isinstance(one, Measure) else replace(curve(1.0, 0.5), measure=one)
        with pytest.raises(InputError, match=f"over {said}, must be over pga, pgv or a spectrum of 5 % damping"):
            write_fragilities(tmp_path / "fragility.xml", "s", {"overturned": other})


def test_failures_that_differ_in_sign_or_in_blanks_have_names_of_their_own(tmp_path: Path) -> None:
    names = ("hit, at[1] -0.1 m", "hit, at[1] 0.1 m", "a-1", "a 1", "a.1")
    write_fragilities(tmp_path / "f.csv", "s", {name: curve(0.3, 0.4) for name in names})
    with open(tmp_path / "f.csv", newline="", encoding="utf-8") as file:
        found = [row["ID"] for row in csv.DictReader(file)]
    assert found == ["s.hit.at.1.minus.0.1.m", "s.hit.at.1.0.1.m", "s.a.1", "s.a.1.2", "s.a.1.3"]


def test_the_description_says_which_component_a_spectrum_is_of(tmp_path: Path) -> None:
    measures = {"overturned": Measure("rotd100", 0.5), "0.1 m": Measure("sa", 0.5)}
    curves = {name: replace(curve(0.3, 0.4), measure=measure) for name, measure in measures.items()}
    write_fragilities(tmp_path / "f.xml", "s", curves)
    text = (tmp_path / "f.xml").read_text(encoding="utf-8")
    assert "; SA(0.5) of s.overturned is RotD100(0.5 s, 5 %)</description>" in text
