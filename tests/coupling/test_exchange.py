"""The text about the exchange, in the manual and inside driven FMUs; and its example of a partner, run as it stands."""

from __future__ import annotations

import importlib
import re
import zipfile
from html import unescape
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from support.child import call
from support.fmus import COLUMNS, LINUX, ROOT, Fmus
from support.inside import driven
from support.lagrange import Reference

from fmu_src.body import ColumnBody
from fmu_src.documentation import pages
from fmu_src.drive import Drive
from fmu_src.exchange import exchange, html
from multiblock import Block, Column, Joint
from solver.models.column.packing import settlements

COLUMN = Column("two", tuple(Block(1.2, 0.7, 0.9, 1800.0, Joint(stiffness=3e8, damping=3e-3)) for _ in range(2)))
SLAB = {"M": 900.0, "K": 6e5, "C": 9e3}  # kg, N/m, N s/m
STEP, STEPS = 1e-3, 400


def ground(t: np.ndarray) -> np.ndarray:
    """Return the acceleration of the ground, m/s2."""
    found: np.ndarray = 2.0 * np.sin(11.0 * t) * np.sin(2.5 * t)
    return found


def text_of(body: ColumnBody) -> str:
    """Return the page inside the FMU of a body, without its tags."""
    page = pages(body, body.table(), "", 1e-3)["documentation/index.html"].decode()
    return unescape(re.sub(r"<[^>]*>", " ", page))


def words(text: str) -> list[str]:
    return re.findall(r"[\w.]+", text)


@pytest.mark.parametrize("drive", ["body", "horizontal"])
def test_the_page_inside_has_the_text_of_the_manual(drive: str) -> None:
    body = ColumnBody(COLUMN, Drive(drive))
    said = words(re.sub(r"```\w+|\| --- .*|[`*|]|^\d\. ", " ", exchange(body.table(), body.drive), flags=re.MULTILINE))
    inside = " ".join(words(text_of(body)))
    assert " ".join(said) in inside
    if drive == "horizontal":
        assert exchange(body.table(), body.drive) == importlib.import_module("docs.tables").exchange_of_column()
    for said_by in ("body.F0x", "base.mtt", "(11 (a - a1) - 5 (a1 - a2)) / (6 h)", "ground ~~~"):
        assert said_by in text_of(body)


def test_the_page_of_the_usual_fmu_has_no_exchange() -> None:
    assert "exchange" not in text_of(ColumnBody(COLUMN)).lower()


def test_the_text_in_html() -> None:
    made = html(
        "One `a<b`\nand **two**.\n\n1. first\n2. second\n\n| x |  |\n| --- | --- |\n| y | z |\n\n```text\n<\n\n-\n```"
    )
    assert made.splitlines() == [
        "<p>One <code>a&lt;b</code>",
        "and <b>two</b>.</p>",
        *("<ol>", "<li>first</li>", "<li>second</li>", "</ol>"),
        *("<table>", "<tr><th>x</th><th></th></tr>", "<tr><td>y</td><td>z</td></tr>", "</table>"),
        *("<pre>&lt;", "", "-</pre>"),
    ]


def as_one() -> np.ndarray:
    """Return the displacements of the top relative to the base, by Lagrange's equations and one integrator."""
    reference, n = Reference.of(COLUMN).on_rotating_base(), COLUMN.n
    rest = np.append(np.zeros(n), -settlements(COLUMN))

    def on_base(x: np.ndarray) -> np.ndarray:
        return np.concatenate([x[:n], [0.0], x[n:], [0.0]])

    def rates(t: float, y: np.ndarray) -> np.ndarray:
        x, v = np.split(y, 2)
        own, forces = reference.with_base(on_base(x[1:]), on_base(v[1:]))
        seen = [0, *range(3, 3 + 2 * n)]
        matrix, force = own[np.ix_(seen, seen)].copy(), forces[seen].copy()
        matrix[0, 0] += SLAB["M"]
        force[0] -= SLAB["K"] * x[0] + SLAB["C"] * v[0]
        a = np.linalg.solve(matrix, force)
        a[0] -= ground(np.array(t))
        return np.concatenate([v, a])

    begin = np.concatenate([[0.0], rest, np.zeros(1 + 2 * n)])
    times = STEP * np.arange(STEPS + 1)
    made = solve_ivp(rates, (0.0, times[-1]), begin, "DOP853", times, rtol=1e-10, atol=1e-13).y.T
    return np.array([reference.tops(on_base(y[1 : 1 + 2 * n]))[0][0] for y in made])


@pytest.mark.long
@pytest.mark.parametrize("options", [(), LINUX], ids=["python", "native"])
def test_the_partner_of_the_text_moves_as_the_system_solved_as_one(options: tuple[str, ...], tmp_path: Path) -> None:
    """Check that the code is taken out of the FMU's own page and run: displacements of the slab, and of the top of the
    column.
    """
    file = tmp_path / "two.toml"
    block = "[[block]]\nheight = 1.2\nwidth = 0.7\ndepth = 0.9\nmass = 1800.0\n"
    file.write_text(f'name = "two"\n{2 * block}[joint]\nstiffness = 3e8\ndamping = 3e-3\n[solver]\ntolerance = 1e-9\n')
    fmu = Fmus.build(file, tmp_path / "two.fmu", "--drive", "horizontal", *options)
    with zipfile.ZipFile(fmu) as archive:
        page = archive.read("documentation/index.html").decode()
    (code,) = re.findall(r"<pre>(def slope.*?)</pre>", page, flags=re.DOTALL)
    given: dict[str, Any] = {**SLAB, "h": STEP, "steps": STEPS, "ag": ground(STEP * np.arange(STEPS + 1)).tolist()}
    tops = np.array(call(driven.example, fmu, unescape(code), given))
    truth = as_one()[1:]
    assert np.max(np.abs(truth)) > 1e-3
    assert np.max(np.abs(tops - truth)) < 5e-5 * np.max(np.abs(truth))  # measured 2.3e-5: the ground within a step


@pytest.mark.long
def test_every_kind_of_fmu_carries_it(tmp_path: Path) -> None:
    file = ROOT / "examples" / "structures" / "trilith.toml"
    kinds = [(file, ()), (file, LINUX), (COLUMNS / "phocas-damped.toml", ("--native", "--fmi", "3"))]
    for k, (model, options) in enumerate(kinds):
        more = ("--platforms", "x86_64-linux") if "3" in options else ()
        fmu = Fmus.build(model, tmp_path / f"{k}.fmu", "--drive", "body", *options, *more)
        with zipfile.ZipFile(fmu) as archive:
            page = archive.read("documentation/index.html").decode()
        assert "The exchange with the bodies at the base" in page
        assert ("<code>base.mtt</code>" in page) == ("columns" in str(model))
        assert "<code>body.F0x</code>" in page
