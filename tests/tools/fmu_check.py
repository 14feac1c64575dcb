"""The FMUs before checkers of others; each checker also has to find fault with a spoiled FMU.

VDMCheck 2 (INTO-CPS: the rules of FMI 2 as a formal model) comes from Maven Central, at the
versions and SHA-256 below. The others are published as files of GitHub releases and are run where
their place is given. Nothing is built here. A checker that cannot be had is said to be left out.
"""

from __future__ import annotations

import argparse
import csv
import hashlib
import re
import shutil
import subprocess
import sys
import tempfile
import zipfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from fmpy import read_model_description, simulate_fmu
from fmpy.validation import validate_fmu

STEP_S, STOP_S = 0.01, 8.0
PLUGIN = "org.apache.maven.plugins:maven-dependency-plugin:3.6.1:copy"
JARS = {
    "dk.au.ece.vdmj:vdmj:4.5.0": (
        "a7d9e2f9cbbc31ca81caccb9d3ca258ae7417582efa82ab48f4a0a35e56286ce"
    ),
    "dk.au.ece.vdmj:annotations:4.5.0": (
        "e92636eee07370a8677aa90fb42b0dff4a2b546f4a3413701933f591404b4ae1"
    ),
    "org.into-cps.vdmcheck:fmuReader:1.1.3": (
        "8b3de7857441d1ef6a2d64764d65ed84026c2c023ec5f86380107ccdfdd2a901"
    ),
    "org.into-cps.vdmcheck:xsd2vdm:1.1.3": (
        "4eb6ecaa3b3825128b35b310591c111003c97d710bd74e9e9da04d4d6f33576b"
    ),
    "org.into-cps.vdmcheck.fmi2:rule-model:1.1.3": (
        "df8dc1c6b8b1686a0a78fa9d51f480d87c51ff26415c75dfb90743178ae026ea"
    ),
    "org.into-cps.vdmcheck.fmi2:vdmcheck2:1.1.3": (
        "45baf392a6af374cdb8f32544de10779a31659b90c4caeca17082a6f0de5acea"
    ),
}


class LeftOutError(Exception):
    """This checker cannot be had on this machine."""


Look = Callable[[Path], list[str]]
"""What a checker says against an FMU."""


@dataclass(frozen=True)
class Checker:
    """Somebody else's program, and the versions of FMI that it knows."""

    name: str
    standards: str
    make: Callable[[], Look]


def _ran(*words: str | Path, folder: Path | None = None) -> tuple[int, list[str]]:
    done = subprocess.run(
        [str(word) for word in words], capture_output=True, text=True, cwd=folder, timeout=600,
        check=False,
    )  # fmt: skip
    return done.returncode, (done.stdout + done.stderr).splitlines()


def fmpy(fmu: Path) -> list[str]:
    """What FMPy's validation says, a broken instance included."""
    try:
        return [*validate_fmu(str(fmu)), *([] if len(_simulated(fmu, _inputs(fmu))) else ["empty"])]
    except Exception as error:  # FMPy raises bare exceptions
        return [str(error)]


def vdmcheck2(cache: Path) -> Look:
    """VDMCheck 2 with its jars in `cache`, from Maven Central where they are not there yet."""
    for program in ("java", "mvn"):
        if not shutil.which(program):
            raise LeftOutError(f"no {program} here (Debian: default-jre-headless, maven)")
    jars = [_jar(artifact, digest, cache) for artifact, digest in JARS.items()]
    rules = cache / "rules"
    for jar in jars[-2:]:
        with zipfile.ZipFile(jar) as archive:
            wanted = ("fmi2-rule-model/", "fmi2schema/")
            archive.extractall(rules, [n for n in archive.namelist() if n.startswith(wanted)])
    chapters = sorted((rules / "fmi2-rule-model" / "Rules").glob("*.adoc"))

    def look(fmu: Path) -> list[str]:
        _, lines = _ran(
            "java", "-Xmx1g", "-Dvdmj.parser.merge_comments=true", "-Dfmureader.noschema=true",
            "-Dfmureader.xsd=fmi2schema/fmi2.xsd", "-cp", ":".join(map(str, jars[:4])),
            "com.fujitsu.vdmj.VDMJ", "-vdmsl", "-q", "-annotations", "-e",
            "isValidFMIConfigurations(modelDescription, buildDescription, terminalsAndIcons)",
            "fmi2-rule-model", *chapters, fmu, folder=rules,
        )  # fmt: skip
        return [] if lines == ["true"] else lines or ["no answer"]

    return look


def _jar(artifact: str, digest: str, cache: Path) -> Path:
    group, name, version = artifact.split(":")
    jar = cache / f"{group}-{name}-{version}.jar"
    if not jar.exists():
        with tempfile.TemporaryDirectory(dir=cache) as folder:
            words = ["-q", "-B", PLUGIN, f"-Dartifact={artifact}", f"-DoutputDirectory={folder}"]
            status, lines = _ran("mvn", *words, folder=cache)
            if status:
                said = next((line for line in lines if "ERROR" in line), "no reason given")
                raise LeftOutError(f"Maven Central does not give {artifact}: {said}")
            (Path(folder) / f"{name}-{version}.jar").rename(jar)
    found = hashlib.sha256(jar.read_bytes()).hexdigest()
    if found != digest:
        raise SystemExit(f"{jar}: SHA-256 is {found}, not {digest}; remove it")
    return jar


def vdmcheck3(script: str) -> Look:
    """`VDMCheck3.sh` of an unpacked release."""
    program = _found(
        script, "VDMCHECK3", "VDMCheck3.sh", "INTO-CPS-Association/FMI-VDM-Model 1.1.3"
    )

    def look(fmu: Path) -> list[str]:
        status, lines = _ran("bash", program, fmu)
        return [] if status == 0 and lines == ["No errors found."] else lines or ["no answer"]

    return look


def fmucheck(path: str, inputs: Path) -> Look:
    """The FMI association's checker of FMI 1 and 2, inputs fed."""
    program = _found(path, "FMUCHECK", "fmuCheck", "modelica-tools/FMUComplianceChecker 2.0.4")

    def look(fmu: Path) -> list[str]:
        written = inputs / f"{fmu.stem}.fmucheck.csv"
        words = ["-l", "5", "-h", str(STEP_S), "-s", str(STOP_S), "-n", "0"]
        drive = _input_file(fmu, inputs)
        status, lines = _ran(program, *words, "-i", drive, "-o", written, fmu)
        bad = [line for line in lines if re.match(r"\[(WARNING|ERROR|FATAL)\]", line)]
        totals = [" ".join(line.split()) for line in lines[-5:]]
        if status == 0 and not bad and {"0 Warning(s)", "0 Error(s)"} <= set(totals):
            return _unlike_fmpy(fmu, written)
        return bad or [f"exit {status}", *totals]

    return look


def fmusim(path: str, inputs: Path) -> Look:
    """The simulator of the reference FMUs, inputs fed; its results beside FMPy's."""
    program = _found(path, "FMUSIM", "fmusim", "modelica/Reference-FMUs, up to 0.0.39")

    def look(fmu: Path) -> list[str]:
        written = inputs / f"{fmu.stem}.fmusim.csv"
        status, lines = _ran(
            program, "--interface-type", "cs", "--start-time", "0", "--stop-time", str(STOP_S),
            "--output-interval", str(STEP_S), "--logging-on", "--input-file",
            _input_file(fmu, inputs), "--output-file", written, fmu,
        )  # fmt: skip
        return _unlike_fmpy(fmu, written) if status == 0 else lines or [f"exit {status}"]

    return look


def _found(path: str, variable: str, program: str, home: str) -> Path:
    if not path:
        raise LeftOutError(f"set {variable}=.../{program} ({home} on GitHub)")
    if not Path(path).is_file():
        raise SystemExit(f"{variable}={path}: no such program")
    return Path(path).resolve()


def _inputs(fmu: Path) -> np.ndarray:
    """A swerve at 27 m/s, sines in the other motions, forces 0: each input at each step."""
    time = np.arange(round(STOP_S / STEP_S) + 1) * STEP_S
    columns = {"time": time}
    for variable in read_model_description(str(fmu), validate=False).modelVariables:
        if variable.causality != "input":
            continue
        if variable.name in ("speed", "target_speed"):
            columns[variable.name] = np.full(len(time), 27.0)
        elif variable.name == "steering_wheel_angle":
            columns[variable.name] = 0.3 * np.sin(np.pi * time) * (time < 2.0)
        elif variable.name.endswith(("yaw_rate", "lateral_acceleration")):
            columns[variable.name] = 0.1 * np.exp(-0.1 * time) * np.sin(4.0 * time)
        else:
            columns[variable.name] = np.zeros(len(time))
    kind = [(name, float) for name in columns]
    return np.array(list(zip(*columns.values(), strict=True)), dtype=kind)


def _input_file(fmu: Path, folder: Path) -> Path:
    rows = _inputs(fmu)
    path = folder / f"{fmu.stem}.in.csv"
    with path.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream, quoting=csv.QUOTE_NONNUMERIC)
        writer.writerow(rows.dtype.names or ())
        writer.writerows(rows.tolist())
    return path


def _simulated(fmu: Path, given: np.ndarray) -> np.ndarray:
    rows: np.ndarray = simulate_fmu(
        str(fmu), validate=False, start_time=0.0, stop_time=STOP_S, step_size=STEP_S,
        output_interval=STEP_S, input=given,
    )  # fmt: skip
    return rows


def _unlike_fmpy(fmu: Path, written: Path) -> list[str]:
    """Outputs that are not, at each step within 1e-9, what FMPy gets of the same inputs."""
    ours = _simulated(fmu, _inputs(fmu))
    theirs = np.genfromtxt(written, delimiter=",", names=True, deletechars="", replace_space=" ")
    if len(theirs) != len(ours):
        return [f"{len(theirs)} rows, FMPy {len(ours)}"]
    outputs = [name for name in ours.dtype.names or () if name != "time"]
    missing = [name for name in outputs if name not in (theirs.dtype.names or ())]
    if missing:
        return [f"no column {name}" for name in missing]
    return [
        f"{name}: {np.max(np.abs(theirs[name] - ours[name])):.3g} beside FMPy"
        for name in outputs
        if not np.allclose(theirs[name], ours[name], rtol=1e-9, atol=1e-9)
    ]


def spoiled(fmu: Path, folder: Path) -> Path:
    """The same FMU with a wrong token and an output missing from its structure."""
    target = folder / f"spoiled_{fmu.name}"
    with zipfile.ZipFile(fmu) as old, zipfile.ZipFile(target, "w") as new:
        for item in old.infolist():
            content = old.read(item)
            if item.filename == "modelDescription.xml":
                text = content.decode()
                text, tokens = re.subn(
                    r'(guid|instantiationToken)="\w{4}', r'\1="0000', text, count=1
                )
                pattern = r"<Outputs>\s*<Unknown[^>]*/>|(?<=<ModelStructure>)\s*<Output [^>]*/>"
                text, outputs = re.subn(
                    pattern, lambda m: "<Outputs>" * m[0].startswith("<Outputs>"), text, count=1
                )
                if tokens != 1 or outputs != 1:
                    raise SystemExit(f"{fmu}: nothing to spoil in its modelDescription.xml")
                content = text.encode()
            new.writestr(item, content)
    return target


def main() -> int:
    """Ask each checker; 1 where one finds fault with an FMU or none with a spoiled one."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("fmus", type=Path, nargs="+")
    parser.add_argument("--cache", type=Path, required=True)
    for name in ("vdmcheck3", "fmucheck", "fmusim"):
        parser.add_argument(f"--{name}", default="")
    args = parser.parse_args()
    cache = args.cache.resolve()
    cache.mkdir(parents=True, exist_ok=True)
    wrong, left_out = 0, 0
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        checkers = [
            Checker("FMPy", "23", lambda: fmpy),
            Checker("VDMCheck 2", "2", lambda: vdmcheck2(cache)),
            Checker("VDMCheck 3", "3", lambda: vdmcheck3(args.vdmcheck3)),
            Checker("FMU Compliance Checker", "2", lambda: fmucheck(args.fmucheck, folder)),
            Checker("fmusim", "23", lambda: fmusim(args.fmusim, folder)),
        ]
        for checker in checkers:
            try:
                look = checker.make()
            except LeftOutError as reason:
                print(f"{checker.name}: LEFT OUT: {reason}")
                left_out += 1
                continue
            for fmu in args.fmus:
                if fmu.stem[-1] in checker.standards:
                    wrong += ask(checker.name, look, fmu.resolve(), folder)
    print(f"{len(checkers) - left_out} checkers asked, {left_out} left out, {wrong} faults")
    return 1 if wrong else 0


def ask(name: str, look: Look, fmu: Path, folder: Path) -> int:
    """One checker, one FMU and its spoiled twin: how many of the two answers are wrong."""
    found, blind = look(fmu), not look(spoiled(fmu, folder))
    print(f"{name}: {fmu.name}: {f'{len(found)} complaints' if found else 'clean'}", flush=True)
    for line in found:
        print(f"    {line}")
    if blind:
        print(f"{name}: finds nothing wrong with a spoiled {fmu.name}")
    return bool(found) + blind


if __name__ == "__main__":
    sys.exit(main())
