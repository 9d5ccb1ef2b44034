"""The native FMU as source code, for hosts that compile it: sources/ and its description.

The layer of C is that of the libraries. The kernels come as assembly, for every processor and object format for which
libraries are built, inside one C file: a compiler that supports GNU's asm (gcc, clang, zig) compiles it. All names that
the linker sees contain the name of the FMU, so that several can be linked into one program; with
FMI2_OVERRIDE_FUNCTION_PREFIX (or FMI3_...) defined the functions of the standard have their plain names.
"""

from __future__ import annotations

import re
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement, tostring

from solver.kernels.machine.packaging import PREFIX, object_code
from solver.kernels.machine.zig import LINUX, LINUX_ARM, MACOS, MACOS_ARM, WINDOWS, Target

from .library import FACES, OWN_HEADERS, headers, sources

# preprocessor condition of each target
CONDITIONS: dict[Target, str] = {
    LINUX: "defined __x86_64__ && defined __ELF__",
    LINUX_ARM: "defined __aarch64__ && defined __ELF__",
    WINDOWS: "defined __x86_64__ && defined _WIN32",
    MACOS: "defined __x86_64__ && defined __APPLE__",
    MACOS_ARM: "defined __aarch64__ && defined __APPLE__",
}
FMI_HEADERS = {
    2: ("fmi2Functions.h", "fmi2FunctionTypes.h", "fmi2TypesPlatform.h"),
    3: ("fmi3Functions.h", "fmi3FunctionTypes.h", "fmi3PlatformTypes.h"),
}
WINDOWS_FEATURES = re.compile(r"^\s*\.def\s+@feat\.00;\n(?:.*\n)*?\s*\.endef\n|^.*@feat\.00.*\n", re.MULTILINE)
NO_PREFIX = "#define fmi2FullName(name) name\n"
OWN_PREFIX = """#ifdef FMI2_FUNCTION_PREFIX
#define fmi2Paste(a, b) a##b
#define fmi2PasteB(a, b) fmi2Paste(a, b)
#define fmi2FullName(name) fmi2PasteB(FMI2_FUNCTION_PREFIX, name)
#else
#define fmi2FullName(name) name
#endif
"""


def compiled_files(name: str) -> list[str]:
    """Return the names of the files to compile and link, which include all others in sources/."""
    return [f"{name}_core.c", f"{name}_fmi.c", f"{name}_kernels.c"]


def source_files(name: str, generated: dict[str, str], group: str, fmi: int) -> dict[str, bytes]:
    """Return the files of sources/ by path in the FMU with the model identifier `name`.

    `generated` has the texts of contract.h and table.h by name, `group` the kernels.
    """
    own = f"{name}_{PREFIX}"
    core, face = sources(fmi)
    texts = {path.name: path.read_text(encoding="utf-8") for path in (core, face, *OWN_HEADERS)}
    texts |= {file: re.sub(rf"\b{PREFIX}(?=\w)", own, text) for file, text in generated.items()}
    texts |= {file: (headers() / file).read_text(encoding="utf-8") for file in FMI_HEADERS[fmi]}
    for file in FMI_HEADERS[fmi]:  # FMPy's header of FMI 2.0 supports no prefix
        texts[file] = texts[file].replace(NO_PREFIX, OWN_PREFIX)
    calls = sorted(set(re.findall(r"\bcore_\w+", re.sub(r"/\*.*?\*/", "", texts["core.h"], flags=re.DOTALL))))
    texts["names.h"] = "".join(f"#define {call} {name}_{call}\n" for call in calls)
    core_unit, face_unit, kernels_unit = compiled_files(name)
    texts[core_unit] = f'#include "names.h"\n#include "{core.name}"\n'
    prefix = f"#ifndef FMI{fmi}_OVERRIDE_FUNCTION_PREFIX\n#define FMI{fmi}_FUNCTION_PREFIX {name}_\n#endif\n"
    texts[face_unit] = f'#include "names.h"\n{prefix}#include "{FACES[fmi]}"\n'
    codes = object_code(group, CONDITIONS, ".s")
    texts[kernels_unit] = kernels_text(dict(zip(CONDITIONS, (code.decode() for code in codes), strict=True)), own)
    return {f"sources/{file}": text.encode() for file, text in texts.items()}


def kernels_text(assembly: dict[Target, str], own: str) -> str:
    """Return one C file with the assembly of every target."""
    lines = ["/* Made by build_fmu.py; not to be edited. The kernels as assembly. */"]
    for k, (target, text) in enumerate(assembly.items()):
        lines.append(f"#{'elif' if k else 'if'} {CONDITIONS[target]}")
        text = WINDOWS_FEATURES.sub("", text)  # the compiler of the surrounding C emits them
        text += "\n\t.text\n"  # section in which that compiler continues; the assembly ends in another one
        rows = [line for line in re.sub(rf"\b(_?){PREFIX}(?=\w)", rf"\1{own}", text).splitlines() if line.strip()]
        lines += ["__asm__(", *(f'    "{_escaped(row)}\\n"' for row in rows), ");"]
    lines += ["#else", '#error "there are no kernels for this processor and object format"', "#endif", ""]
    return "\n".join(lines)


def _escaped(text: str) -> str:
    return text.replace("\\", "\\\\").replace('"', '\\"').replace("\t", " ")


def describe_sources(root: Element, name: str, fmi: int) -> dict[str, bytes]:
    """Add the sources to the model description of FMI 2.0; for FMI 3.0 return sources/buildDescription.xml."""
    if fmi == 2:
        listed = Element("SourceFiles")
        interface = root.find("CoSimulation")
        assert interface is not None
        interface.insert(0, listed)
        for file in compiled_files(name):
            SubElement(listed, "File", name=file)
        return {}
    description = Element("fmiBuildDescription", fmiVersion="3.0")
    configuration = SubElement(description, "BuildConfiguration", modelIdentifier=name)
    files = SubElement(configuration, "SourceFileSet", language="C11")
    for file in compiled_files(name):
        SubElement(files, "SourceFile", name=file)
    text = b'<?xml version="1.0" encoding="UTF-8"?>\n' + tostring(description)
    return {str(Path("sources") / "buildDescription.xml"): text}
