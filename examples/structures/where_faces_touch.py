"""Three answers to one question: a statue on a pedestal whose faces touch all over, in a rim, or on two feet.

    python examples/structures/where_faces_touch.py [AG ...]

A marble statue of 0.5 x 0.5 x 1.8 m and 486 kg stands on a pedestal of 0.7 x 0.7 x 1.0 m, as `multiblock new` writes
it. Each joint has the damping that is critical as the statue stands on its edge. The motions follow the spectrum of
EN 1998-1 on soil B with AG times g on rock (0.25 unless given), seven of them, each with eight varied statues. Prints a
table: in the plane, then in space under two components.
"""

import argparse
import warnings
from typing import Any

from multiblock import (
    Check,
    Column,
    InputWarning,
    Plan,
    Structure,
    calibrate,
    check,
    housner_restitution,
    restitution,
    spectra,
)

G = 9.80665
WIDTH, RIM, STRIPS = 0.5, 0.083, 6  # m, of the statue; number of strips, of which the outer two are feet
STATUE = {"height": 1.8, "width": WIDTH, "depth": WIDTH, "mass": 486.0}
PEDESTAL = {"height": 1.0, "width": 0.7, "depth": 0.7, "density": 2700.0}
MODULI = (4.286e9, 4.576e9)  # N/m3, of the statue and of the pedestal
PLAN = Plan(joints=False)
FACES = ("whole", "rim", "feet")


def column(where: str) -> Column:
    """Return the statue and its pedestal in a plane."""
    laws: dict[str, dict[str, Any]] = {
        "whole": {},
        "rim": {"rim": RIM},
        "feet": {"section": "strips", "strips": [WIDTH, *[0.0] * (STRIPS - 2), WIDTH]},
    }
    below = {"rim": RIM} if where == "rim" else {}
    statue, pedestal = (
        {**block, "joint": {"stiffness": modulus, "damping": 1e-3, **law}}
        for block, modulus, law in ((STATUE, MODULI[0], laws[where]), (PEDESTAL, MODULI[1], below))
    )
    made = Column.from_dict({"name": where, "material": "marble", "block": [statue, pedestal]})
    return calibrate.with_joints(made, damping=calibrate.column_damping_on_edge(made))


def structure(where: str) -> Structure:
    """Return the statue and its pedestal in space; the feet are two placed joints, which hold as long as the statue
    does not slide.
    """
    flat = column(where)
    if where != "feet":
        return flat.in_space()
    damping = flat.blocks[0].joint.damping
    foot = WIDTH / STRIPS
    between = {"between": ["statue", "pedestal"], "normal": [0.0, 0.0, 1.0], "section": "rectangle"}
    law = {"stiffness": MODULI[0], "damping": damping, "strength": 70e6, "width": foot, "depth": WIDTH}
    joints = [{**between, **law, "at": [side * 0.5 * (WIDTH - foot), 0.0, 1.0]} for side in (-1.0, 1.0)]
    blocks = [
        {"name": "pedestal", "on": "base", **PEDESTAL},
        {"name": "statue", "position": [0.0, 0.0, 1.0], **STATUE},
    ]
    shared = {"stiffness": MODULI[1], "damping": damping, "strength": 70e6}
    return Structure.from_dict({"name": where, "joints": shared, "block": blocks, "joint": joints})


def cells(found: Check) -> list[str]:
    """Return how many varied statues fall, and the factor on the shaking at which the first one falls."""
    margin = f"{found.margin.falls:.2f}" if found.margin is not None else ""
    return [f"{found.verdicts.fallen} of {len(found.verdicts.varied)}", margin]


def main() -> None:
    """Print a table of the three for each acceleration."""
    warnings.simplefilter("ignore", InputWarning)  # of damping: varied values are beyond the usual range
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("ag", nargs="*", type=float, default=[0.25], metavar="AG", help="on rock, in g (0.25)")
    for ag in parser.parse_args().ag:
        target = spectra.eurocode8(ag * G, "B")
        print(f"| a_g = {ag:g} g | restitution | fall, plane | from, times | fall, space | from, times |")
        print("|---|---|---|---|---|---|")
        for where in FACES:
            made = column(where)
            found = [check(model, target=target, plan=PLAN) for model in (made, structure(where))]
            answers = [where, f"{restitution(made):.3f}", *cells(found[0]), *cells(found[1])]
            print(f"| {' | '.join(answers)} |", flush=True)
    print(f"Housner's rigid block: {housner_restitution(column('whole')):.3f}")


if __name__ == "__main__":
    main()
