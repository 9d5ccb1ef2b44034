"""The command `risk`: how likely failure is in some years, from the results of a study and a hazard."""

from __future__ import annotations

import argparse
from functools import partial
from pathlib import Path
from typing import Any

from ..common.errors import InputError
from ..common.files import check_outputs
from ..studies.exports import SUFFIXES, write_fragilities
from ..studies.journal import SUFFIX
from ..studies.motions import MEASURES
from ..studies.results import Results
from ..studies.risk import RISK_NOTE, YEARS, Hazard, Risk, risk, risk_text, write_risks
from ..studies.statistics import check_made, failures_of, fit_fragility, measure_in, undecided_text
from .command_files import PICTURES, add_force, check_picture, check_suffix, write_outputs
from .study import add_study_options, results_from


def add_risk_command(commands: argparse._SubParsersAction[Any]) -> None:
    """Add the command `risk`."""
    parser = commands.add_parser("risk", help="how likely it falls in some years: a fragility and the hazard of a site")
    parser.set_defaults(command=_risk)
    add_study_options(parser, f"a study that has been run, its results (NAME{SUFFIX}, NAME.csv), or their folder")
    hazard = parser.add_argument_group("hazard")
    words = "table with the columns pga (g), pgv (m/s) or sa(PERIOD), rotd50(PERIOD), rotd100(PERIOD) (g), and rate "
    words += "(1/year) or return_period (years)"
    hazard.add_argument("--hazard", type=Path, metavar="FILE.csv", help=words)
    words = "in place of a table: the rate is a power law of the intensity with the exponent -K"
    hazard.add_argument("--slope", type=float, metavar="K", help=words)
    words = "with --slope: an intensity and its return period"
    hazard.add_argument("--point", type=float, nargs=2, metavar=("INTENSITY", "YEARS"), help=words)
    hazard.add_argument("--measure", help="pga, pgv or sa(PERIOD), if no header names it")
    words = f"time of the probability (default: {YEARS:g})"
    parser.add_argument("--years", type=float, default=YEARS, metavar="N", help=words)
    parser.add_argument("-o", "--output", type=Path, metavar="FILE.csv", help="write rates and shares")
    words = "write the fragilities for pelicun (FILE.csv) or OpenQuake (FILE.xml, NRML 0.5)"
    parser.add_argument("--export", type=Path, metavar="FILE", help=words)
    parser.add_argument("--plot", type=Path, metavar="FILE.png", help=f"draw them ({', '.join(PICTURES)})")
    add_force(parser)


def _risk(options: argparse.Namespace) -> None:
    check_suffix(options.output, ".csv")
    check_suffix(options.export, *SUFFIXES)
    check_picture(options.plot)
    check_outputs((options.output, options.export, options.plot), (options.study, options.hazard), options.force)
    hazard = _hazard(options)
    options.study = _journal(options.study)
    results = results_from(options)
    risks, unfit = _risks(results, hazard, str(options.hazard or "--measure"), options.years)
    # summary
    name, undecided = results.study["name"], int(results.undecided.sum())
    print(f"{name}: {len(results)} of {results.head['runs']} runs; hazard: {hazard}")
    print(*unfit, *(risk_text(failure, one) for failure, one in risks.items()), sep="\n")
    print(RISK_NOTE)
    if undecided:
        print(f"{undecided_text(undecided)}; the fragility takes them as standing")
    # files
    outputs: list[tuple[Path | None, Any]] = [(options.output, partial(write_risks, risks=risks))]
    fragilities = {failure: one.fragility for failure, one in risks.items()}
    outputs.append((options.export, partial(write_fragilities, name=name, fragilities=fragilities)))
    if options.plot is not None:
        from ..studies.pictures import draw_risks

        title = f"{name}: risk in {options.years:g} years"
        outputs.append((options.plot, lambda path: draw_risks(risks, path, title)))
    write_outputs(outputs)


def _hazard(options: argparse.Namespace) -> Hazard:
    """Return the hazard of the command line. Raises InputError."""
    if (options.slope is None) != (options.point is None) or (options.slope is None) == (options.hazard is None):
        raise InputError("--hazard FILE.csv, or --slope K and --point INTENSITY YEARS: exactly one must be given")
    if options.hazard is not None:
        return Hazard.from_csv(options.hazard, options.measure)
    if options.measure is None:
        raise InputError("--measure: missing, must name the measure of --point: pga, pgv or sa(PERIOD)")
    return Hazard.power_law(options.measure, options.slope, *options.point)


def _journal(path: Path) -> Path:
    """Return the journal of results given by their folder or table; any other path unchanged. Raises InputError."""
    if not path.is_dir():
        return path.with_suffix(SUFFIX) if path.suffix == ".csv" else path
    found = sorted(path.glob(f"*{SUFFIX}"))
    if len(found) != 1:
        raise InputError(f"{path}: has {len(found)} files *{SUFFIX}, must have one; else give the file")
    return found[0]


def _risks(results: Results, hazard: Hazard, source: str, years: float) -> tuple[dict[str, Risk], list[str]]:
    """Return the risks by the name of the failure, and a line for each failure without a fragility.

    Raises InputError unless some run was made and the results have the measure of the hazard and a fragility over it.
    """
    check_made(results)
    measures = {name: measure_in(results, name) for name in MEASURES if name in results}
    name = hazard.measure.name
    if measures.get(name) != hazard.measure:
        known = ", ".join(measure.label for measure in measures.values() if measure is not None)
        raise InputError(f"{source}: is over {hazard.measure.label}, must be over a measure of the results: {known}")
    risks: dict[str, Risk] = {}
    unfit = []
    for failure in failures_of(results):
        try:
            fitted = fit_fragility(results, name, failure.limit, chosen=failure.chosen)
        except InputError as error:
            unfit.append(f"{failure.name}: {error}")
            continue
        risks[failure.name if failure.limit == "hit" else fitted.how] = risk(fitted, hazard, years)
    if not risks:
        raise InputError("; ".join(unfit))
    return risks, unfit
