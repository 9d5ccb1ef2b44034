"""A reference run that an FMU carries with its results, and its repetition: extra/org.fmi-standard.fmi-ls-ref.

Inputs and results are CSV files, which the manifest of the layered standard names (fmi-ls-ref 1.0.0-alpha.1).
"""

from __future__ import annotations

import contextlib
import csv
import io
import math
import zipfile
from pathlib import Path
from typing import Any
from xml.sax.saxutils import quoteattr

import numpy as np

from solver.common.errors import InputError, needing
from solver.common.files import identifier_of
from solver.ground.motion import STANDARD_GRAVITY, Motion

from .body import Body
from .variables import ACCELERATIONS

FOLDER = "extra/org.fmi-standard.fmi-ls-ref"
STEP, STEPS = 0.01, 100  # s
FREQUENCY, AMPLITUDE = 2.0, 0.2 * STANDARD_GRAVITY  # Hz, m/s2
BODY_MASS = 1e6  # kg, of a body that drives the base
ALIKE = 1e-5  # of the largest value of a unit: hosts that accumulate time differently differ by 4e-7
MANIFEST = """\
<?xml version="1.0" encoding="UTF-8"?>
<fmiReferences xmlns:fmi-ls="http://fmi-standard.org/fmi-ls-manifest"
    fmi-ls:fmi-ls-name="org.fmi-standard.fmi-ls-ref" fmi-ls:fmi-ls-version="1.0.0-alpha.1"
    fmi-ls:fmi-ls-description="Layered Standard providing information on related files included in an FMU.">
    <Related type="application/x-ma-hs-experiments" source={experiment} role="experiment/smoke-test"
        description="The run below"/>
    <Related type="text/csv" source={inputs} role="other" description="Inputs, each held over a step of {step} s"/>
    <Related type="text/csv" source={outputs} role="result" description="What the outputs are under these inputs"/>
    <Related type="text/plain" source="../../documentation/fmi-ls-ref.txt" role="document"
        description="What the run is, and which differences are to be expected"/>
</fmiReferences>
"""
# by the schema of MA-HS-Experiments (draft of July 2026)
EXPERIMENT = """\
<?xml version="1.0" encoding="UTF-8"?>
<Experiments name={name} description="To see that a host runs the FMU as its builder did">
    <Experiment name="reference run" description={about}>
        <TransientSimulation startTime="0.0" stopTime="{stop}" stepSize="{step}"/>
        <Stimuli source={inputs}/>
        <References source={outputs}/>
    </Experiment>
</Experiments>
"""
ABOUT = "base acceleration of 0.2 g at 2 Hz along x, each input held over a step"
EXPECTED = """\
Reference run in extra/org.fmi-standard.fmi-ls-ref: {stop} s, {about} of {step} s. Hosts that add up time in other ways
differ by up to 4e-7 of the largest value of a unit; a difference beyond {alike:g} is a fault. The run is repeated by
`multiblock replay FILE.fmu`.
"""


def reference_files(body: Body, motion: Motion | None = None, arrays: bool = False) -> dict[str, bytes]:
    """Run a body for a short time under its record, and return the files of the reference results by path in the FMU.

    With `arrays` the variables of blocks, joints and ports are arrays and are left out; ports carry no load. Raises
    InputError if the parameters are wrong, SolverError if the run fails.
    """
    table = body.table()
    start = {variable.name: variable.start for variable in table}
    stepper = body.stepper(body.described(start.__getitem__))
    stepper.record = body.samples(motion)
    inputs = [[_input(variable.name, variable.unit, k * STEP) for variable in body.inputs] for k in range(STEPS + 1)]
    rows = []
    for k in range(STEPS + 1):
        if k:
            stepper.drive((k - 1) * STEP, *inputs[k - 1])
            stepper.advance((k - 1) * STEP, STEP)
        else:
            stepper.drive(0.0, *inputs[0])
            stepper.stand_on_base()
        rows.append([k * STEP, *stepper.observe(k * STEP).tolist()])
    # files, named after the model
    outputs = [variable.name for variable in table[len(body.inputs) : len(body.inputs) + body.sizes[0]]]
    seen = ["time", *outputs], rows
    given = ["time", *(variable.name for variable in body.inputs)], [[k * STEP, *row] for k, row in enumerate(inputs)]
    name = identifier_of(body.name)
    words: dict[str, Any] = {"stop": STEPS * STEP, "step": STEP, "alike": ALIKE}
    sources = {"inputs": f"{name}_in.csv", "outputs": f"{name}_out.csv", "experiment": f"{name}.exp", "name": body.name}
    quoted = words | {key: quoteattr(text) for key, text in sources.items()} | {"about": quoteattr(ABOUT)}
    return {
        f"{FOLDER}/fmi-ls-manifest.xml": MANIFEST.format(**quoted).encode(),
        f"{FOLDER}/{name}.exp": EXPERIMENT.format(**quoted).encode(),
        "documentation/fmi-ls-ref.txt": EXPECTED.format(**words, about=ABOUT).encode(),
        f"{FOLDER}/{name}_in.csv": _csv(*given, arrays),
        f"{FOLDER}/{name}_out.csv": _csv(*seen, arrays),
    }


def _input(name: str, unit: str, t: float) -> float:
    """Return an input at time t: the base, or the first body that drives it, is shaken along x.

    The body stands on springs along z.
    """
    acceleration = AMPLITUDE * math.sin(2.0 * math.pi * FREQUENCY * t)
    owner, _, what = name.partition(".")
    if owner == "base":
        return acceleration if what == "ax" and unit in ACCELERATIONS else 0.0
    if owner != "body":
        return 0.0
    heavy = dict.fromkeys(("M", "Mxx", "Mzz", "Mtt", "Jxx", "Jyy"), BODY_MASS)
    return {"F0x": BODY_MASS * acceleration, **heavy}.get(what, 0.0)


def _csv(names: list[str], rows: list[list[float]], arrays: bool) -> bytes:
    kept = [k for k, name in enumerate(names) if not arrays or "[" not in name]
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    csv.writer(text, lineterminator="\n", quoting=csv.QUOTE_ALL).writerow([names[k] for k in kept])
    writer.writerows([[f"{row[k]:.12g}" for k in kept] for row in rows])
    return text.getvalue().encode()


def replay(file: Path) -> str:
    """Repeat the reference run of an FMU with FMPy, and report the agreement. Raises InputError if results differ."""
    with needing("fmu", "fmpy"):
        import fmpy
        from fmpy import read_model_description
    inputs, expected = _carried(file)
    names = [name for name in expected.dtype.names or () if name != "time"]
    run: dict[str, Any] = {"stop_time": STEPS * STEP, "output_interval": STEP, "fmi_type": "CoSimulation"}
    try:
        with contextlib.redirect_stdout(io.StringIO()):  # FMPy warns of inputs of ports that are arrays: they stay 0
            found = fmpy.simulate_fmu(str(file), input=inputs, output=names, **run)
    except Exception as error:
        raise InputError(f"{file}: does not run its reference results: {error}") from error
    # differences, relative to the largest value of each unit
    variables = read_model_description(str(file), validate=False).modelVariables
    units = {v.name: v.unit or (v.declaredType.unit if v.declaredType else "") for v in variables}
    largest: dict[str, float] = {}
    for name in names:
        largest[units[name]] = max(largest.get(units[name], 0.0), float(np.max(np.abs(expected[name]))))
    worst, where = max((_difference(found[name], expected[name], largest[units[name]]), name) for name in names)
    said = f"{file}: {len(names)} outputs at {len(expected)} instants, largest difference {worst:.1e} ({where})"
    if not worst <= ALIKE:
        raise InputError(f"{said}; must be at most {ALIKE:g} of the largest value of its unit")
    return said


def _difference(found: Any, expected: Any, largest: float) -> float:
    if len(found) != len(expected) or not np.all(np.isfinite(found)):
        return math.inf
    return float(np.max(np.abs(found - expected))) / (largest or 1.0)


def _carried(file: Path) -> tuple[Any, ...]:
    """Read the reference inputs and results of an FMU. Raises InputError."""
    try:
        with zipfile.ZipFile(file) as archive:
            found = [
                [
                    archive.read(name).decode()
                    for name in archive.namelist()
                    if name.startswith(FOLDER + "/") and end in name
                ]
                for end in ("_in.csv", "_out.csv")
            ]
    except (OSError, zipfile.BadZipFile) as error:
        raise InputError(f"{file}: must be an FMU: {error}") from error
    if not all(found):
        raise InputError(f"{file}: has no reference results inside, must be built with build-fmu --reference")
    return tuple(_table(texts[0]) for texts in found)


def _table(text: str) -> Any:
    names, *rows = csv.reader(io.StringIO(text))
    return np.array([tuple(map(float, row)) for row in rows], dtype=[(name, float) for name in names])
