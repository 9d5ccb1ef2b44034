"""Animate the results of an FMU with the blocks inside it: python animate_fmu.py FILE.fmu RESULTS.csv SCENE.glb"""

import sys
import zipfile
from pathlib import Path

import numpy as np

from solver.plotting.scene.gltf import animated

fmu, table, scene = sys.argv[1:]
with zipfile.ZipFile(fmu) as archive:
    blocks = archive.read("resources/scene.glb")
names, *lines = Path(table).read_text(encoding="utf-8").replace('"', "").splitlines()
rows = [line.split(",") for line in lines]
histories = {}
for k, name in enumerate(names.split(",")):
    owner, _, quantity = name.partition(".")
    if name == "time" or owner.startswith("block"):
        values = np.array([row[k].split() for row in rows], dtype=float).T
        if owner == "block":  # an array of FMI 3.0: its numbers with spaces between, in one column
            histories |= {f"block[{i}].{quantity}": value for i, value in enumerate(values, start=1)}
        else:
            histories[name] = values[0]
Path(scene).write_bytes(animated(blocks, histories["time"], histories))
