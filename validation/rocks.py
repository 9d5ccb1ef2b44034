"""Reader of the shaking-table tests of two granite rocks: outcomes, motions, verdicts of the distinct elements."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from multiblock import InputError, Motion

from .case import AbsentError, data_folder
from .rigid_block import Flags, FloatArray

REPOSITORY = "virtual_shake_robot_pybullet"
ADVICE = f"git clone https://github.com/ZhiangChen/{REPOSITORY} (1 GB; its data carry no licence of their own)"
FOLDER = Path("data") / "Shake_Table_Response"
STILL = 200  # samples before the table moves
SAMPLE = 1.25e-3  # s
G = 9.80665  # m/s2
TESTS = {"specimen 1": 1, "specimen 2": 2}  # columns of the table
ELEMENTS = {"specimen 1": slice(3, 8), "specimen 2": slice(8, 16)}  # distinct elements, one column a stiffness


@dataclass(frozen=True)
class Tests:
    """Tests that have a recorded table motion, m of them."""

    numbers: NDArray[np.int64]
    motions: list[Motion]
    pgv: FloatArray  # m/s
    fallen: dict[str, Flags]  # of each specimen, (m,)
    elements: dict[str, Flags]  # distinct elements, (settings, m)


def read(data: Path | None) -> Tests:
    """Return all tests of the repository.

    Raises AbsentError without it or without openpyxl, InputError for wrong files.
    """
    folder = data_folder(data, REPOSITORY, ADVICE) / FOLDER
    table = outcomes(folder / "Results_Granite.xlsx")
    files = {int(row[0]): folder / f"Test{int(row[0]):03d}.txt" for row in table}
    kept = np.array([files[int(row[0])].is_file() and files[int(row[0])].stat().st_size > 0 for row in table])
    if not kept.any():
        raise InputError(f"{folder}: has none of the files Test011.txt to Test{max(files):03d}.txt")
    table = table[kept]
    accelerations = [acceleration(files[int(row[0])]) for row in table]
    return Tests(
        table[:, 0].astype(np.int64),
        [Motion.from_samples(SAMPLE, ax) for ax in accelerations],
        np.array([peak_velocity(ax) for ax in accelerations]),
        {name: table[:, column] == 1.0 for name, column in TESTS.items()},
        {name: table[:, columns].T == 1.0 for name, columns in ELEMENTS.items()},
    )


def outcomes(path: Path) -> FloatArray:
    """Test number, outcome (1 overturned) of both specimens and of the distinct elements, a row a test."""
    try:
        import openpyxl
    except ImportError as absent:
        raise AbsentError('needs openpyxl: pip install -e ".[validation]"') from absent
    if not path.is_file():
        raise InputError(f"{path}: no such file, though the folder of the data is there")
    sheet = openpyxl.load_workbook(path, read_only=True, data_only=True).worksheets[0]
    rows = [row[:16] for row in sheet.iter_rows(min_row=2, values_only=True) if row[0] is not None]
    return np.array(rows, dtype=np.float64)


def acceleration(path: Path) -> FloatArray:
    """Return the acceleration of the table, m/s2: the second column, in g, less its mean before the table moves."""
    try:
        time, ax = np.loadtxt(path, skiprows=1, usecols=(0, 1), unpack=True)
    except (ValueError, IndexError) as wrong:
        raise InputError(
            f"{path}: must have a header and rows of numbers, time (s) and acceleration (g) first"
        ) from wrong
    if abs(float(time[1] - time[0]) - SAMPLE) > 1e-9:
        raise InputError(f"{path}: samples are {time[1] - time[0]:g} s apart, must be {SAMPLE:g}")
    found: FloatArray = G * (ax - np.mean(ax[:STILL]))
    return found


def peak_velocity(ax: FloatArray) -> float:
    """Return the peak ground velocity, m/s; a straight line is taken off the velocity, which sensors make drift."""
    velocity = SAMPLE * np.concatenate([[0.0], np.cumsum(0.5 * (ax[1:] + ax[:-1]))])
    time = np.linspace(-1.0, 1.0, len(velocity))
    return float(np.max(np.abs(velocity - np.polyval(np.polyfit(time, velocity, 1), time))))


def scan_of(data: Path | None, specimen: str) -> Path:
    """Return the file of the scan of a rock. Raises AbsentError without the data."""
    number = TESTS[specimen]
    return data_folder(data, REPOSITORY, ADVICE) / "data" / f"SP{number}_PBRmodel" / f"SP{number}.obj"
