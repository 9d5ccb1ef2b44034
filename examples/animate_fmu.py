"""Animate the results of an FMU with the blocks inside it: python animate_fmu.py FILE.fmu RESULTS.csv SCENE.glb"""

import sys
import zipfile
from pathlib import Path

import numpy as np

from solver.plotting.scene.gltf import animated

fmu, table, scene = sys.argv[1:]
with zipfile.ZipFile(fmu) as archive:
    blocks = archive.read("resources/scene.glb")
names = Path(table).read_text(encoding="utf-8").partition("\n")[0].replace('"', "").strip().split(",")
rows = np.genfromtxt(table, delimiter=",", skip_header=1)
histories = dict(zip(names, rows.T, strict=True))
Path(scene).write_bytes(animated(blocks, histories["time"], histories))
