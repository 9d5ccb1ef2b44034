"""Docstrings of functions begin with a verb in the imperative, those of properties with a noun phrase."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path
from tokenize import COMMENT, generate_tokens

import pytest
from support.fmus import ROOT

FOLDERS = (
    *("build_fmu.py", "fmu_src", "multiblock", "solver/checks", "solver/commands", "solver/common", "solver/ground"),
    *("solver/kernels", "solver/models", "solver/plotting", "solver/runs", "solver/statics", "solver/studies"),
    *("tests", "benchmarks", "validation", "stress", "examples"),
)
# what docstrings of functions may begin with: D401 of ruff refuses other forms of verbs, and accepts all other words
VERBS = """
    Abort Accept Accumulate Add Adjust Advance Align Allow Append Apply Arrange Ask Assemble Assert Assign
    Attach Average Avoid Begin Bind Bisect Bound Bracket Branch Break Bring Broadcast Build Cache Calculate
    Calibrate Call Cap Carry Change Check Choose Classify Clear Clip Close Collect Combine Compare Compile
    Complete Compute Concatenate Connect Convert Copy Correct Count Couple Crack Create Cut Damp Decide Declare
    Decode Decorate Deduplicate Define Delete Describe Detect Determine Differentiate Disable Discard Dispatch
    Display Divide Do Draw Drive Drop Emit Enable Encode End Ensure Enter Estimate Evaluate Evict Examine
    Exchange Execute Exit Expand Export Extend Extract Extrapolate Factor Factorize Fetch Fill Filter Find
    Finish Fit Flag Fold Follow Forget Format Free Freeze Generate Get Give Group Guard Guess Handle Hash Hit
    Hold Identify Ignore Import Include Increment Initialize Insert Install Instantiate Integrate Interpolate
    Interpret Interrupt Invert Iterate Join Judge Keep Kill Label Lay Lead Leave Let Limit Line Link List Load
    Locate Look Loosen Lower Make Map Mark Mask Match Measure Merge Minimize Mirror Move Multiply Name Negate
    Normalize Note Offer Open Optimize Override Overwrite Pack Pad Parse Partition Pass Patch Pause Perform
    Perturb Pick Pickle Place Play Plot Pop Pose Post Predict Prepare Press Print Probe Process Produce Project
    Propagate Provide Pull Push Put Quantify Query Raise Randomize Rank Rate Reach Read Rebuild Recall Recompute
    Record Recover Reduce Refine Refuse Register Reject Release Reload Remember Remove Rename Render Renew
    Repeat Replace Report Represent Require Reset Reshape Resolve Rest Restore Restrict Return Reuse Rewind
    Rewrite Rotate Round Run Sample Save Scale Scan Search See Select Send Separate Serialize Serve Set Settle
    Shake Shift Shorten Show Shrink Simplify Simulate Skip Slide Smooth Solve Sort Span Split Spread Stack Start
    State Step Stop Store Strip Subscribe Substitute Subtract Sum Suppress Suspend Swap Sweep Switch Tabulate
    Take Tell Terminate Test Throw Tilt Time Trace Track Transform Translate Transpose Treat Truncate Try Turn
    Unpack Unzip Update Use Validate Vary Verify Visit Wait Walk Warn Weigh Widen Wrap Write Yield Zero Zip
"""


def faults(source: str) -> Iterator[tuple[int, str]]:
    """Yield the line and the first line of docstrings that begin as they should not."""
    for node in ast.walk(ast.parse(source)):
        if not isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)) or not (text := ast.get_docstring(node)):
            continue
        is_property = any(ast.unparse(decorator).endswith("property") for decorator in node.decorator_list)
        if (text.split()[0].rstrip(".,:;") in VERBS.split()) == is_property:
            yield node.lineno, text.splitlines()[0]


@pytest.mark.long  # takes seconds
@pytest.mark.parametrize("folder", FOLDERS)
def test_functions_do_and_properties_are(folder: str) -> None:
    files = [ROOT / folder] if folder.endswith(".py") else sorted((ROOT / folder).rglob("*.py"))
    assert files
    found = [
        f"{file.relative_to(ROOT).as_posix()}:{line}: {text}"
        for file in files
        for line, text in faults(Path(file).read_text(encoding="utf-8"))
    ]
    assert found == []


def test_other_beginnings_are_found() -> None:
    source = """
def area(): "The area of the face."
def clip(): "Clip the interval to the face."
class Face:
    @property
    def width(self): "Return the width."
    @property
    def depth(self): "The depth, m."
"""
    assert list(faults(source)) == [(2, "The area of the face."), (6, "Return the width.")]


def test_long_kernels_have_comments() -> None:
    """Check that every function of 15 lines and more has one; measured 10.4 % of all lines have one."""
    missing, comments, lines = [], 0, 0
    for file in sorted((ROOT / "solver" / "kernels").rglob("*.py")):
        text = file.read_text(encoding="utf-8")
        places = {
            token.start[0]
            for token in generate_tokens(iter(text.splitlines(keepends=True)).__next__)
            if token.type == COMMENT
        }
        comments, lines = comments + len(places), lines + text.count("\n")
        missing += [
            f"{file.relative_to(ROOT).as_posix()}:{node.lineno}: {node.name}"
            for node in ast.walk(ast.parse(text))
            if isinstance(node, ast.FunctionDef) and body_lines(node) >= 15
            if places.isdisjoint(range(node.lineno, (node.end_lineno or 0) + 1))
        ]
    assert missing == []
    assert comments > 0.08 * lines


def body_lines(function: ast.FunctionDef) -> int:
    """Return the number of lines of a function below its docstring."""
    first = function.body[1] if ast.get_docstring(function) and len(function.body) > 1 else function.body[0]
    return (function.end_lineno or 0) - first.lineno + 1
