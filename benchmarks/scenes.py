"""The scenes that are measured: columns under motions, each with its duration."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from solver import Block, Column, Joint, Motion

ROOT = Path(__file__).resolve().parent.parent
RECORDS = ROOT.parent / "shared" / "records"  # not part of the project

G = 9.80665  # m/s2
STIFFNESS = 533 * 9.80665e6  # N/m3, of the joints of the Column of Phocas
HEIGHT, SIDE, MASS = 14.07, 1.56, 81000.0  # m, m, kg: the shaft of the Column of Phocas
DAMPING = 1e-3  # s

FORCED = ((0.02, 2.0), (0.05, 2.0), (0.1, 1.0), (0.1, 0.5))  # g, Hz
RECORDED = (
    ("El Centro", "elcentro-1940-ns.AT2", 20.0),
    ("Arleta", "northridge-1994-arleta-360.AT2", 20.0),
    ("Chi-Chi TCU052-N", "chi-chi-1999-tcu052-n.AT2", 60.0),
)


@dataclass(frozen=True)
class Scene:
    """A column under a motion, from rest, for `duration` s."""

    name: str  # for file names
    title: str
    column: Column
    motion: Motion
    duration: float  # s


def shaft(n: int, damping: float = DAMPING) -> Column:
    """Return the shaft of the Column of Phocas cut into n equal blocks; n = 3 is the column itself. Damping in s."""
    block = Block(HEIGHT / n, SIDE, SIDE, MASS / n, Joint(STIFFNESS, damping))
    return Column(f"shaft_{n}", (block,) * n)


def forced(g: float, frequency: float, duration: float = 20.0, n: int = 3, damping: float = DAMPING) -> Scene:
    """Return the shaft in n blocks under g times gravity at `frequency` Hz."""
    subject = "Phocas" if n == 3 else "1 block" if n == 1 else f"{n} blocks"
    if not damping:
        subject += ", undamped"
    title = f"{subject}, {g:g} g {frequency:g} Hz"
    name = title.lower().replace(",", "").replace(" ", "-")
    return Scene(name, title, shaft(n, damping), Motion.harmonic(g * G, frequency, duration), duration)


@cache
def harmonic() -> tuple[Scene, ...]:
    """Return the four scenes in which integrators are compared first: from hardly opening to nearly falling."""
    return tuple(forced(g, frequency) for g, frequency in FORCED)


@cache
def recorded() -> tuple[tuple[Scene, ...], dict[str, str]]:
    """Return Phocas under recorded motions; records that are not on this machine, with the reason."""
    found: list[Scene] = []
    absent: dict[str, str] = {}
    for label, file, duration in RECORDED:
        title = f"Phocas, {label}"
        path = RECORDS / file
        if path.is_file():
            name = title.lower().replace(",", "").replace(" ", "-")
            found.append(Scene(name, title, shaft(3), Motion.from_at2(path), duration))
        else:
            absent[title] = f"no record {path}"
    return tuple(found), absent


@cache
def others() -> tuple[Scene, ...]:
    """Return all joints in contact throughout; no damping; other numbers of blocks."""
    return (
        forced(0.005, 2.0),
        forced(0.05, 3.0, 5.0, damping=0.0),
        forced(0.1, 1.0, n=1),
        forced(0.1, 1.0, n=10),
        forced(0.1, 1.0, 2.0, n=50),
        forced(0.1, 1.0, 1.0, n=200),
    )


@cache
def falling() -> Scene:
    """Return a scene that overturns without a record; for the verdict only."""
    return forced(0.1, 0.25)


@cache
def burst() -> Scene:
    """Return fifteen seconds of silence, five of motion, twenty of silence, as in records; only for skipped
    intervals.
    """
    time = 0.01 * np.arange(4001)
    inside = (time > 15.0) & (time < 20.0)
    ax = np.where(inside, 0.02 * G * np.sin(4.0 * math.pi * time), 0.0)
    return Scene("burst", "Phocas, 5 s of 0.02 g 2 Hz in 40 s", shaft(3), Motion.from_samples(0.01, ax), 40.0)


def scenes() -> tuple[tuple[Scene, ...], dict[str, str]]:
    """Return all scenes, and those not available, with the reason."""
    found, absent = recorded()
    return (*others()[:1], *harmonic(), *found, *others()[1:]), absent
