#!/usr/bin/env python3
"""make_fmu.py VERSION MODEL HEADERS LIST OUT ARGUMENTS...: a model as an FMU of FMI 2 or 3.

`VERSION` is 2 or 3, `MODEL` core or plant, `HEADERS` a folder with the standard's headers, `LIST`
what fmu_list prints, `OUT` the .fmu to write, `ARGUMENTS` the model's sources, objects and options
for the compiler, which CC names. The standard wants every function to be there: what port/fmi does
not implement becomes a stub that answers with an error, made from the header's own declaration.
"""

from __future__ import annotations

import hashlib
import os
import re
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path
from xml.etree import ElementTree as Xml

HERE = Path(__file__).resolve().parent
MODELS = {
    "core": ("swaywatch", "How far a car-trailer combination is from yaw instability"),
    "plant": ("swaywatch_plant", "A car with a trailer, both rolling on springs"),
}
"""Name and description."""
PLATFORM = {"2": "linux64", "3": "x86_64-linux"}
UNITS = {
    "rad": {"rad": 1}, "m/s": {"m": 1, "s": -1}, "rad/s": {"rad": 1, "s": -1},
    "m/s2": {"m": 1, "s": -2}, "N": {"kg": 1, "m": 1, "s": -2}, "kg": {"kg": 1},
    "kg.m2": {"kg": 1, "m": 2}, "m": {"m": 1}, "s": {"s": 1}, "Hz": {"s": -1}, "1/s": {"s": -1},
    "N/rad": {"kg": 1, "m": 1, "s": -2, "rad": -1}, "m2": {"m": 2}, "rad/s2": {"rad": 1, "s": -2},
    "N.m": {"kg": 1, "m": 2, "s": -2}, "N.m/rad": {"kg": 1, "m": 2, "s": -2, "rad": -1},
    "N.m.s/rad": {"kg": 1, "m": 2, "s": -1, "rad": -1},
}  # fmt: skip


def stubs(version: str, headers: Path) -> str:
    """C of the functions that are declared and not implemented."""
    done = set(re.findall(rf"\b(fmi{version}\w+)\(", (HERE / f"fmu_fmi{version}.c").read_text()))
    text = (headers / f"fmi{version}FunctionTypes.h").read_text()
    text = re.sub(r"/\*.*?\*/|//[^\n]*", "", text, flags=re.DOTALL)
    out = f'#include "fmi{version}Functions.h"\n'
    pattern = rf"typedef\s+([\w ]+\*?)\s*(fmi{version}\w+)TYPE\s*\(([^;]*)\)\s*;"
    for result, name, parameters in re.findall(pattern, text):
        if name in done:
            continue
        named = []
        for i, parameter in enumerate(parameters.split(",")):
            kind, array = re.match(r"\s*(.*?)\s*(\[\])?\s*$", parameter, re.DOTALL).groups()  # type: ignore[union-attr]
            kind = re.sub(r"(?<=[\s*])\w+$", "", kind).strip() if len(kind.split()) > 1 else kind
            kind = kind if kind not in ("const", "") else parameter.replace("[]", "").strip()
            named.append(f"{kind} a{i}{array or ''}")
        ignored = " ".join(f"(void)a{i};" for i in range(len(named)))
        answer = "0" if result.strip() in (f"fmi{version}Instance",) else f"fmi{version}Error"
        out += f"{result} {name}({', '.join(named)})\n{{\n    {ignored} return {answer};\n}}\n"
    return out


def _units(parent: Xml.Element, names: set[str]) -> None:
    definitions = Xml.SubElement(parent, "UnitDefinitions")
    for name in sorted(names - {"-"}):
        unit = Xml.SubElement(definitions, "Unit", name=name)
        Xml.SubElement(unit, "BaseUnit", {k: str(v) for k, v in UNITS[name].items()})


def _variable(parent: Xml.Element, version: str, model: str, row: list[str]) -> None:
    kind, reference, name, unit, start = row
    entry = {"name": name, "valueReference": reference, "causality": kind}
    of_outputs = "continuous" if model == "plant" else "discrete"
    entry["variability"] = {"parameter": "fixed", "input": "continuous"}.get(kind, of_outputs)
    typed = {} if unit == "-" else {"unit": unit}
    if kind != "output":
        typed["start"] = start
    if version == "3":
        Xml.SubElement(parent, "Float64", {**entry, **typed})
        return
    if kind == "parameter":
        entry["initial"] = "exact"
    Xml.SubElement(Xml.SubElement(parent, "ScalarVariable", entry), "Real", typed)


def _structure(parent: Xml.Element, version: str, rows: list[list[str]]) -> None:
    structure = Xml.SubElement(parent, "ModelStructure")
    outputs = [(n, row[1]) for n, row in enumerate(rows, 1) if row[0] == "output"]
    for tag in ("Output", "InitialUnknown"):
        listed = Xml.SubElement(structure, f"{tag}s") if version == "2" else structure
        for number, reference in outputs:
            if version == "2":
                Xml.SubElement(listed, "Unknown", index=str(number))
            else:
                Xml.SubElement(listed, tag, valueReference=reference)


def description(version: str, model: str, rows: list[list[str]], token: str) -> bytes:
    """modelDescription.xml."""
    name, words = MODELS[model]
    root = Xml.Element(
        "fmiModelDescription", fmiVersion={"2": "2.0", "3": "3.0"}[version], modelName=name,
        description=words,
        **{"guid" if version == "2" else "instantiationToken": token},
    )  # fmt: skip
    Xml.SubElement(
        root, "CoSimulation", modelIdentifier=name, canHandleVariableCommunicationStepSize="true"
    )
    _units(root, {row[3] for row in rows})
    Xml.SubElement(root, "DefaultExperiment", startTime="0", stepSize="0.01")
    variables = Xml.SubElement(root, "ModelVariables")
    if version == "3":
        Xml.SubElement(
            variables, "Float64", name="time", valueReference="0", causality="independent",
            variability="continuous",
        )  # fmt: skip
    for row in rows:
        _variable(variables, version, model, row)
    _structure(root, version, rows)
    Xml.indent(root)
    return Xml.tostring(root, encoding="UTF-8", xml_declaration=True)


def main(version: str, model: str, headers: str, listing: str, out: str, *given: str) -> None:
    """Compile, describe, pack."""
    name = MODELS[model][0]
    rows = [line.split() for line in Path(listing).read_text().splitlines()]
    own = HERE / f"fmu_fmi{version}.c"
    sources = [own, *(Path(g) for g in given if g.endswith(".c"))]
    token = hashlib.sha256(
        Path(listing).read_bytes() + b"".join(s.read_bytes() for s in sources)
    ).hexdigest()[:32]
    with tempfile.TemporaryDirectory() as folder:
        stub, binary = Path(folder) / "stubs.c", Path(folder) / f"{name}.so"
        stub.write_text(stubs(version, Path(headers)))
        subprocess.run(
            [os.environ.get("CC", "gcc"), "-std=c99", "-O2", "-Wall", "-Wextra", "-Werror", "-fPIC",
             "-shared", "-isystem", headers, f"-I{HERE}", f'-DFMU_TOKEN="{token}"',
             str(own), str(stub), *given, "-lm", "-Wl,-Bsymbolic", "-o", str(binary)],
            check=True,
        )  # fmt: skip
        with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as packed:
            text = description(version, model, rows, token)
            packed.writestr("modelDescription.xml", text)
            packed.write(binary, f"binaries/{PLATFORM[version]}/{name}.so")
            packed.write(HERE.parents[1] / "LICENSE", "documentation/licenses/license.txt")


if __name__ == "__main__":
    if len(sys.argv) < 7 or sys.argv[1] not in PLATFORM or sys.argv[2] not in MODELS:
        sys.exit(__doc__)
    main(*sys.argv[1:])
