"""Build the FMUs of a coupled system: the column, and the partners of this folder.

    python examples/coupling/build.py [COLUMN.toml] [-o FOLDER]

Writes column.fmu, isolator.fmu and soil.fmu, and isolated.ssp, which connects the first two for masters that open SSP.
"""

from __future__ import annotations

import argparse
import hashlib
import importlib
import sys
import tempfile
import uuid
import zipfile
from pathlib import Path

from pythonfmu import FmuBuilder

from build_fmu import build_fmu, repack
from fmu_src import host

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
PARTNERS = {"isolator": "Isolator", "soil": "Soil"}
DEFAULT_COLUMN = ROOT / "examples" / "columns" / "phocas-damped.toml"
SCRIPT = '''"""Entry of the FMU."""

from {package}.{module} import {base}


class Slave({base}):
    """The slave of this FMU; the wrapper wants a class of this script's own."""

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
'''
SPLIT = ("R0x", "R0z", "mxx", "mxz")  # what the isolator takes
MOTION = ("ax", "az", "jx", "jz")  # and gives
SSD = """<?xml version="1.0" encoding="UTF-8"?>
<ssd:SystemStructureDescription xmlns:ssd="http://ssp-standard.org/SSP1/SystemStructureDescription"
    xmlns:ssc="http://ssp-standard.org/SSP1/SystemStructureCommon" name="isolated" version="1.0">
  <ssd:System name="isolated">
    <ssd:Connectors>
{ground}
    </ssd:Connectors>
    <ssd:Elements>
{components}
    </ssd:Elements>
    <ssd:Connections>
{connections}
    </ssd:Connections>
  </ssd:System>
  <ssd:DefaultExperiment startTime="0.0" stopTime="10.0"/>
</ssd:SystemStructureDescription>
"""


def build_partner(module: str, output: Path) -> Path:
    """Build the FMU of isolator.py or soil.py; its code goes by a name that ends in the hash of its content."""
    files = {"__init__.py": "", "host.py": Path(host.__file__).read_text(encoding="utf-8")}
    files |= {f"{name}.py": (HERE / f"{name}.py").read_text(encoding="utf-8") for name in ("partner", module)}
    identity = hashlib.sha256("\0".join(files.values()).encode()).hexdigest()
    package = f"{module}_{identity[:16]}"
    with tempfile.TemporaryDirectory(prefix="build_partner_") as folder:
        stage = Path(folder)
        (stage / package).mkdir()
        for name, text in files.items():
            (stage / package / name).write_text(text, encoding="utf-8")
        script = stage / f"slave_{identity[:16]}.py"
        script.write_text(SCRIPT.format(package=package, module=module, base=PARTNERS[module]), encoding="utf-8")
        guid = stage / "guid.txt"
        guid.write_text(f"{{{uuid.uuid5(uuid.NAMESPACE_OID, identity)}}}", encoding="utf-8")
        sys.path.insert(0, folder)
        importlib.invalidate_caches()
        try:
            built = FmuBuilder.build_FMU(script, dest=stage / "built.fmu", project_files=[stage / package, guid])
        finally:
            sys.path[:] = [entry for entry in sys.path if not entry.startswith(folder)]
        output.parent.mkdir(parents=True, exist_ok=True)
        repack(Path(built), output, {})
    return output


def build_ssp(column: Path, isolator: Path, output: Path) -> Path:
    """Put column and isolator into one SSP, R0 and the effective mass one way, acceleration and slope the other."""
    pairs = [("column", f"base.{name}", "isolator", f"column.{name}") for name in SPLIT]
    pairs += [("isolator", f"base.{name}", "column", f"base.{name}") for name in MOTION]
    pairs += [("", f"ground.{name}", "isolator", f"ground.{name}") for name in MOTION]

    def connector(name: str, kind: str) -> str:
        return f'        <ssd:Connector name="{name}" kind="{kind}"><ssc:Real/></ssd:Connector>'

    components = []
    for part in ("column", "isolator"):
        ports = [connector(name, "output") for source, name, _, _ in pairs if source == part]
        ports += [connector(name, "input") for _, _, target, name in pairs if target == part]
        head = (
            f'      <ssd:Component name="{part}" type="application/x-fmu-sharedlibrary" source="resources/{part}.fmu">'
        )
        components += [head, "      <ssd:Connectors>", *ports, "      </ssd:Connectors>", "      </ssd:Component>"]
    connections = []
    for source, start, target, end in pairs:
        element = f'startElement="{source}" ' if source else ""
        connections.append(
            f'      <ssd:Connection {element}startConnector="{start}" endElement="{target}" endConnector="{end}"/>'
        )
    ground = [connector(f"ground.{name}", "input") for name in MOTION]
    text = SSD.format(ground="\n".join(ground), components="\n".join(components), connections="\n".join(connections))
    with zipfile.ZipFile(output, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("SystemStructure.ssd", text)
        archive.write(column, "resources/column.fmu")
        archive.write(isolator, "resources/isolator.fmu")
    return output


def build_all(folder: Path, column: Path = DEFAULT_COLUMN) -> dict[str, Path]:
    """Build everything into a folder; paths by name."""
    folder.mkdir(parents=True, exist_ok=True)
    made = {"column": build_fmu(column, folder / "column.fmu")}
    made |= {name: build_partner(name, folder / f"{name}.fmu") for name in PARTNERS}
    made["ssp"] = build_ssp(made["column"], made["isolator"], folder / "isolated.ssp")
    return made


def main() -> int:
    """Run the command line."""
    parser = argparse.ArgumentParser(description="Build column.fmu, isolator.fmu, soil.fmu and isolated.ssp.")
    parser.add_argument("column", nargs="?", type=Path, default=DEFAULT_COLUMN, help="TOML file (default: %(default)s)")
    parser.add_argument("-o", "--output-folder", type=Path, default=Path("results"))
    options = parser.parse_args()
    for path in build_all(options.output_folder, options.column).values():
        print(path)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
