"""The exchange between a driven FMU and the bodies at its base, as text for the manual and for the page inside the FMU.

Needed by the builder only. The text is Markdown in the few forms that `html` supports; the manual includes it
unchanged.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from html import escape
from typing import NamedTuple

from solver.kernels.layout.spaces import SLOPES

from .drive import Drive, Idle, idle
from .model_description3 import SPLIT
from .variables import Variable

SAID_OF_ITSELF = {  # outputs that the partner needs
    "column": rf"base\.({SPLIT})",
    "structure": r"base\.F[xyz]",
    "turning": r"base\.(F[xyz]|M[xy])",
}

SKETCH = """\
    z ^                   {from_fmu}
      |     +-------+     -------------------------------------------------->
      +-->  | this  |  R                                                        partner
        x   | FMU   |     <--------------------------------------------------
            +-------+     {from_body}
    base ======(o)=======  --> a    R = {reaction}, of this FMU on the base
          |  partner  |             M a = F0 + R
          +-----------+             F0, M: of the partner
    ground ~~~~~~~~~~~~~~  -->      moves the partner alone"""

EQUATIONS = {
    ("column", "body"): """\
(Mxx + mxx) ax + (Mxz + mxz) az + (Mxt + mxt) alpha = F0x + R0x
(Mxz + mxz) ax + (Mzz + mzz) az + (Mzt + mzt) alpha = F0z + R0z
(Mxt + mxt) ax + (Mzt + mzt) az + (Mtt + mtt) alpha = F0m + R0m""",
    ("column", "horizontal"): """\
(Mxx + mxx) ax + (Mxz + mxz) base.az + (Mxt + mxt) base.alpha = F0x + R0x""",
    ("structure", "body"): """\
M ax = F0x + Fx        M ay = F0y + Fy        M az = F0z + Fz""",
    ("structure", "horizontal"): """\
M ax = F0x + Fx        M ay = F0y + Fy""",
    ("turning", "body"): """\
M ax + Mxry alpha_y = F0x + Fx        Mxry ax + Jyy alpha_y + Jxy alpha_x = F0my + My
M ay + Myrx alpha_x = F0y + Fy        Myrx ay + Jxx alpha_x + Jxy alpha_y = F0mx + Mx
M az                = F0z + Fz""",
    ("turning", "horizontal"): """\
M ax + Mxry base.alpha_y = F0x + Fx        M ay + Myrx base.alpha_x = F0y + Fy""",
}
SLOPE_RULES = {
    "held": ("0", "1"),
    "line": ("(a - a1) / h", "2"),
    "parabola": ("(11 (a - a1) - 5 (a1 - a2)) / (6 h)", "3"),
}
# run by tests/coupling/test_exchange.py
PARTNER = """\
def slope(a, before, h):  # base.slope = parabola
    if not before:
        return 0.0
    line = (a - before[-1]) / h
    return line if len(before) < 2 else (11 * line - 5 * (before[-1] - before[-2]) / h) / 6

u, v, before = 0.0, 0.0, []  # m, m/s: slab relative to the ground; accelerations of the steps before
for k in range(steps):
    {get}
    F0x = -K * u - C * v  # N: all that acts on the slab but this FMU and the inertia
    fmu.set({set})
    a = (F0x + R0x) / (M + mxx)  # m/s2, of the base; the FMU finds the same
    j = slope(a, before, h)
    before.append(a)
    fmu.step(k * h, h)
    a, j = a - ag[k], j - (ag[k + 1] - ag[k]) / h  # relative to the ground, whose acceleration is ag
    u, v = u + h * v + h**2 * a / 2 + h**3 * j / 6, v + h * a + h**2 * j / 2"""
GET = {
    "column": 'R0x, mxx = fmu.get("base.R0x", "base.mxx")  # N, kg: at time k h, before anything is set',
    "structure": 'R0x, mxx = *fmu.get("base.Fx"), 0.0  # N, kg: at time k h, before anything is set',
}
SET = {"column": '{"body.F0x": F0x, "body.Mxx": M}', "structure": '{"body.F0x": F0x, "body.M": M}'}

# limit of the step: of a column, which sends a mass, and of a structure, whose mass at its base is 0
STEP_OF_COLUMN = "Where an acceleration of the base changes its sign at every step and grows, a warning says so."
STEP_OF_STRUCTURE = (
    "Stable are steps up to 2 / c (held), 1 / c (line) or 0.55 / c (parabola) with c = C (1 / M + 1 / m): C is the sum "
    "of the dashpots along the joints on the base in N s/m, m the mass that these joints move at once, about a quarter "
    "of a slender block that stands on one."
)

TEXT = """\
Bodies at the base of this FMU move it: isolators, soil, a building, a vehicle. Once per step this FMU sends {said}, and
its partner a force F0 and a mass M. Each follows from the state of its side alone. Both sides solve the same equation
for the acceleration a of the base, and move the base by it. So no iteration is needed{mass}.

```text
{sketch}
```

{signals}

F0 is the force with which the partner would act on the base if the base did not accelerate. Forces act on the base and
are positive {signs}. a is absolute: a partner whose displacements count from the ground subtracts the acceleration of
the ground. Further bodies at the same base, also a further column,
are `body2` and so on (`--bodies`): F0 and M are the sums over all of them.

**In each step, from t to t + h:**

1. get {out} of this FMU, and F0 and M of the partner: their values at t;
2. set {into} of this FMU, and the partner's inputs;
3. make the step of this FMU and that of the partner, in any order or in parallel. Between 2 and 3 no output is read.

**The acceleration within the step** is a + j (t' - t), on both sides. The parameter `base.slope` says how j follows
from a, from the accelerations a1 and a2 of the last two steps, and from the length h of the last step. The partner has
to use the same rule:

{slopes}

The first step is held and the second one a line, as is every step after two steps of different lengths.

**A partner must**

1. send F0 and M of time t, neither extrapolated nor one step old;
2. exchange at every step, with the same t and h as this FMU;
3. use the same slope;
4. have a mass: a step under forces without a mass is discarded{unless};
5. take steps that resolve the vibration of both sides together: halve the step and compare. {step}

**An example**: a slab of mass M on a spring K and a dashpot C, along x{alone}:

```python
{partner}
```

{idle}"""


class Exchange(NamedTuple):
    """The exchanged variables of a kind of model; `words`: values of `base.drive` with bodies at the base."""

    kind: str
    out: list[Variable]
    into: list[Variable]
    words: list[str]


def exchanged(table: Sequence[Variable], drive: Drive) -> Exchange:
    """Return the variables that an FMU exchanges with the first body at its base."""
    names = {variable.name for variable in table}
    kind = "column" if "base.mxx" in names else "turning" if "base.theta_x" in names else "structure"
    out = [item for item in table if item.causality == "output" and re.fullmatch(SAID_OF_ITSELF[kind], item.name)]
    into = [item for item in table if item.name.startswith("body.")]
    return Exchange(kind, out, into, [word for word in drive.words if word != "acceleration"])


def signals(table: Sequence[Variable], drive: Drive) -> str:
    """Return a table of the exchanged signals, and the equations that both sides solve, as Markdown."""
    kind, out, into, words = exchanged(table, drive)
    ways = ("to the partner", out), ("from the partner", into)
    rows = [[way, f"`{item.name}`", item.unit, item.description] for way, items in ways for item in items]
    solved = [f"With `base.drive` = `{word}` both solve\n\n```text\n{EQUATIONS[kind, word]}\n```" for word in words]
    return "\n\n".join([_rows(["direction", "name", "unit", "meaning"], rows), *solved])


def exchange(table: Sequence[Variable], drive: Drive) -> str:
    """Return the text on the exchange of an FMU with these variables, whose base is driven, as Markdown."""
    kind, out, into, words = exchanged(table, drive)
    # the text differs between column, structure, and structure whose base turns
    is_column, turns = kind == "column", kind == "turning"
    own = "column" if is_column else "structure"
    partner = PARTNER.replace("{get}", GET[own]).replace("{set}", SET[own])
    return TEXT.format(
        said="its reaction R0 at the base and the mass m that it opposes to an acceleration there"
        if is_column
        else "its reaction R at the base",
        sketch=SKETCH.format(
            from_fmu=_listed(out),
            from_body=_listed(into),
            reaction="R0 - m a" if is_column else "Fx, Fy, Fz" + (", Mx, My" if turns else ""),
        ),
        signals=signals(table, drive),
        signs="to +x and up, moments clockwise" if is_column else "to +x, +y and up, moments about +x and +y",
        out=_some(out),
        into=_some(into),
        unless=", unless the column is driven horizontally, where its own mass suffices"
        if is_column and "horizontal" in words
        else "",
        mass=", and the partner may have any mass" if is_column else "; a light partner needs short steps",
        step=STEP_OF_COLUMN if is_column else STEP_OF_STRUCTURE,
        slopes=_rows(["base.slope", "j", "order"], [[f"`{word}`", *SLOPE_RULES[word]] for word in SLOPES]),
        alone="" if "horizontal" in words else " (along z and for the rotation likewise: F0z has to bear the weight)",
        partner=partner,
        idle=_idle(table, drive.words),
    )


def _listed(items: Sequence[Variable]) -> str:
    """Return the first four and the last of a list of names."""
    names = [item.name for item in items]
    return ", ".join(names) if len(names) < 5 else f"{', '.join(names[:4])} ... {names[-1]}"


def _some(items: Sequence[Variable]) -> str:
    names = [f"`{item.name}`" for item in items]
    return f"{names[0]} ... {names[-1]}"


def _rows(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    return "\n".join(f"| {' | '.join(line)} |" for line in (head, ["---"] * len(head), *rows))


def _idle(table: Sequence[Variable], words: Sequence[str]) -> str:
    """Return sentences on the inputs that have no effect."""
    lines = []
    inputs = [item.name for item in table if item.causality == "input" and not re.match(r"body\d", item.name)]
    for word in words:
        ever = [f"`{name}`" for name in inputs if idle(word, name) is Idle.EVER]
        later = [f"`{name}`" for name in inputs if idle(word, name) is Idle.LATER]
        line = f"With `base.drive` = `{word}` these inputs do nothing: {', '.join(ever)}"
        lines.append(line + (f"; after the first exchange also {', '.join(later)}." if later else "."))
    return " ".join([*lines, "A warning says so the first time that the value of one of them changes."])


def html(markdown: str) -> str:
    """Return the HTML of Markdown that has paragraphs, numbered lists, tables and fenced code only."""
    parts = re.split(r"```\w+\n(.*?)\n```", markdown, flags=re.DOTALL)  # every second one is code
    texts = [[f"<pre>{escape(part)}</pre>"] if k % 2 else _blocks(part) for k, part in enumerate(parts)]
    return "\n".join(block for text in texts for block in text)


def _blocks(text: str) -> list[str]:
    return [_block(block) for block in text.strip().split("\n\n") if block]


def _block(block: str) -> str:
    lines = block.splitlines()
    if lines[0].startswith("|"):
        cells = [[_inline(cell) for cell in line[2:-2].split(" | ")] for line in lines if "| ---" not in line]
        rows = [
            f"<tr>{''.join(f'<{tag}>{cell}</{tag}>' for cell in row)}</tr>"
            for tag, row in zip(["th", *["td"] * len(cells)], cells, strict=False)
        ]
        return "<table>\n" + "\n".join(rows) + "\n</table>"
    if lines[0].startswith("1. "):
        items = re.split(r"^\d+\. ", block, flags=re.MULTILINE)[1:]
        return "<ol>\n" + "\n".join(f"<li>{_inline(item.strip())}</li>" for item in items) + "\n</ol>"
    return f"<p>{_inline(block)}</p>"


def _inline(text: str) -> str:
    text = re.sub(r"`([^`]+)`", r"<code>\1</code>", escape(text, quote=False))
    return re.sub(r"\*\*([^*]+)\*\*", r"<b>\1</b>", text)
