"""Draw docs/images/round-in-space.png: how often round and square columns overturn, under one and two components.

Three blocks of the size of the Column of Phocas under filtered noise: `python docs/round_in_space.py`, some minutes.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from multiblock import Motion, Structure, simulate, wavelets

G = 9.80665
LEVELS = (0.4, 0.6, 0.8, 1.0, 1.2)  # g, of the component along x; that across has 0.85 of it
RECORDS = 16
SECTIONS = {"round": {"shape": "drum", "diameter": 1.56}, "square": {"width": 1.56, "depth": 1.56}}
IMAGE = Path(__file__).parent / "images" / "round-in-space.png"


def column(section: str) -> Structure:
    """Three blocks with joints as of marble, damped."""
    own = {"height": 4.69, "density": 2365.0, **SECTIONS[section]}
    block = {"name": "b", "repeat": 3, "on": "base", **own}
    law = {"stiffness": 5.227e9, "damping": 2e-3, "friction": 0.7}
    return Structure.from_dict({"name": section, "joints": law, "block": [block], "solver": {"tolerance": 1e-4}})


def motion(level: float, seed: int, two: bool) -> Motion:
    """8 s of noise, of one component or of two that are independent."""
    along, across = (wavelets.filtered_noise(level * G, 1.5, 8.0, seed + k) for k in (0, 1000))
    return along.with_across(across.scaled(0.85)) if two else along


def main() -> None:
    """Run all and draw."""
    figure = Figure(figsize=(6.4, 4.0), layout="constrained")
    axes = figure.add_subplot()
    for section, colour in (("round", "C0"), ("square", "C1")):
        structure = column(section).with_settings(without=("peaks",))
        for two, line in ((False, "o--"), (True, "s-")):
            shares = []
            for level in LEVELS:
                runs = [simulate(structure, motion(level, seed, two), settle=5.0) for seed in range(RECORDS)]
                shares.append(float(np.mean([run.overturned for run in runs])))
            print(section, 1 + two, shares, flush=True)
            label = f"{section}, {'two components' if two else 'one component'}"
            axes.plot(LEVELS, shares, line, color=colour, label=label)
    axes.set_xlabel("largest acceleration along x (g)")
    axes.set_ylabel(f"share of {RECORDS} runs that overturn")
    axes.grid(alpha=0.3)
    axes.legend()
    figure.savefig(IMAGE, dpi=130)


if __name__ == "__main__":
    main()
