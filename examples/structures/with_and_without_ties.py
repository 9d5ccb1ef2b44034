"""The effect of the ties of a structure under a recorded motion in three components.

    python examples/structures/with_and_without_ties.py STRUCTURE.toml ALONG ACROSS VERTICAL

The components are scaled to 0.35, 0.30 and 0.20 g. Prints the verdict, the largest motion of a block, the joints that
open longest and slide farthest, and the forces of the ties, with them and without.
"""

import sys
import time
from dataclasses import replace

import numpy as np

from multiblock import Motion, Structure, simulate

G = 9.80665


def shaking(along: str, across: str, vertical: str) -> Motion:
    """Return the three components, scaled."""
    x, y, z = (
        Motion.from_file(path).scaled_to(part * G) for path, part in ((along, 0.35), (across, 0.30), (vertical, 0.20))
    )
    return x.with_across(y).with_vertical(z)


def lines_on(structure: Structure, motion: Motion) -> list[str]:
    """Return the lines on one run."""
    begin = time.process_time()
    response = simulate(structure, motion, output_step=0.01)
    seconds = time.process_time() - begin
    moved = np.sqrt(response.ux**2 + response.uy**2)
    block = structure.names[int(np.argmax(np.max(moved, axis=0)))]
    lines = [
        f"{response.verdict}: {response.reason}; {seconds:.1f} s of the processor",
        f"largest motion: {1e3 * np.max(moved):.0f} mm, block {block}",
    ]
    opened = np.mean(response.contact < 0.5 * response.contact[0], axis=0)  # joints that are open at rest do not count
    for what, values, unit in (
        ("open longest, with less than half of the contact at rest", 100.0 * opened, "% of the time"),
        ("slide farthest", 1e3 * response.peaks["slip"], "mm"),
    ):
        parts = [f"{between(structure, j)} {values[j]:.3g}" for j in np.argsort(-values)[:4]]
        lines.append(f"{what}: {', '.join(parts)} {unit}")
    if structure.ties:
        lines.append(f"ties, largest force: {', '.join(f'{force / 1e3:.0f}' for force in response.peaks['tie'])} kN")
    return lines


def between(structure: Structure, j: int) -> str:
    """Return names of the two bodies of a joint."""
    names = [*structure.names, "base"]
    return f"{names[structure.joints[j].upper]} on {names[structure.joints[j].lower]}"


def main() -> None:
    """Make both runs."""
    file, *records = sys.argv[1:]
    structure, motion = Structure.from_toml(file), shaking(*records)
    for name, made in (("with ties", structure), ("without ties", replace(structure, ties=()))):
        print(name)
        for line in lines_on(made, motion):
            print(f"  {line}")


if __name__ == "__main__":
    main()
