"""Mutated recordings, DBCs and TOMLs: each must end in a result or in one named error.

``python fuzz_recordings.py --seconds 600 --seed 1 --out DIR`` runs for so long and keeps whatever
ended otherwise, took more than 10 s or more than 1 GB. The quick test runs a fixed few.
"""

from __future__ import annotations

import argparse
import faulthandler
import re
import resource
import signal
import sys
import tempfile
import time
import traceback
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import numpy as np

from swaywatch.drive import load_drives, load_signals
from swaywatch.errors import SwaywatchError
from swaywatch.recording import Series, read_recording, write_recording
from swaywatch.recording.dbc import Database
from swaywatch.vehicle_file import load_vehicle

PRACTICE = Path(__file__).resolve().parent.parent / "data" / "practice"
LIMIT_S = 10
"""Processor time of a file, the same on a busy machine;"""
WAIT_S = 30 * LIMIT_S
"""or it waits for something."""
LIMIT_BYTES = 1 << 30
EXTREMES = (0, 1, 0x7F, 0x80, 0xFF, 0x7FFF, 0xFFFF, 0x7FFFFFFF, 0xFFFFFFFF, 1 << 40, (1 << 64) - 1)
WORDS = (
    b"nan", b"inf", b"-1", b"1e400", b"9" * 400, b"", b"\0", b"\xff\xfe", b"[" * 200, b'"', b";",
    b"1e155", b"#", b"true", b"2026-01-01T00:00:00", b",,,,", b" " * 3000, b"-9223372036854775809",
)  # fmt: skip
NUMBER = re.compile(rb"\d+(\.\d+)?")


class TooSlowError(BaseException):
    """A file took longer than it may; no reader takes it for damage of the file."""


def seeds(folder: Path) -> dict[str, bytes]:
    """Whole files of every kind, by name."""
    frames = read_recording(PRACTICE / "p01" / "run1.blf").frames
    assert frames is not None
    frames = frames.take(slice(0, 400))
    drive = load_drives([PRACTICE / "p01" / "run1.blf"], PRACTICE / "p01" / "signals.toml")[0]
    signals = {}
    for name in ("speed", "car_yaw_rate", "trailer_yaw_rate"):
        channel = drive.channels[name]
        stamps = 10**18 + (channel.time_s[:100] * 1e9).astype(np.int64)
        signals[name] = Series(stamps, channel.value[:100], channel.unit)
    for suffix in (".blf", ".asc", ".log", ".trc", ".mf4", ".csv", ".parquet"):
        write_recording(folder / f"frames{suffix}", frames)
    for suffix in (".mf4", ".csv", ".parquet"):
        write_recording(folder / f"signals{suffix}", signals)
    found = {path.name: path.read_bytes() for path in sorted(folder.iterdir())}
    found["measurement.dbc"] = (PRACTICE / "measurement.dbc").read_bytes()
    for name in ("signals.toml", "vehicle.toml"):
        found[name] = (PRACTICE / "p01" / name).read_bytes()
    return found


def mutated(data: bytes, rng: np.random.Generator) -> bytes:
    """The file with one to four things changed."""
    changed = bytearray(data)
    for _ in range(int(rng.integers(1, 5))):
        size = max(len(changed), 1)
        at, length = int(rng.integers(size)), int(rng.integers(1, 40))
        head = int(rng.integers(min(size, 400)))  # heads hold the sizes
        at = head if rng.random() < 0.4 else at
        kind = int(rng.integers(8))
        if kind == 0 and changed:
            changed[at] ^= 1 << int(rng.integers(8))
        elif kind == 1 and changed:
            changed[at] = int(rng.integers(256))
        elif kind == 2:
            del changed[at : at + length]
        elif kind == 3:
            changed[at:at] = changed[at : at + length] * int(rng.integers(1, 50))
        elif kind == 4:
            width = int(rng.choice(np.array([1, 2, 4, 8])))
            value = int(EXTREMES[int(rng.integers(len(EXTREMES)))]) % (1 << (8 * width))
            changed[at : at + width] = value.to_bytes(width, "little")
        elif kind == 5:
            changed = changed[:at]
        elif kind == 6:
            changed[at:at] = WORDS[int(rng.integers(len(WORDS)))]
        else:
            numbers = list(NUMBER.finditer(bytes(changed[:100_000])))
            if numbers:
                match = numbers[int(rng.integers(len(numbers)))]
                changed[match.start() : match.end()] = WORDS[int(rng.integers(len(WORDS)))]
    return bytes(changed)


def user_of(name: str, folder: Path) -> Callable[[Path], object]:
    """What the package does with a file of this name."""
    if name.endswith(".dbc"):
        frames = read_recording(PRACTICE / "p01" / "run1.blf").frames
        assert frames is not None
        some = frames.take(slice(0, 400))
        rows = np.arange(len(some))

        def decode(path: Path) -> object:
            base = Database([path])
            for signal in base.signal_names[:40]:
                pair = base.find(signal)
                if pair is not None:
                    base.decode(some, rows, *pair)
            return base

        return decode
    if name == "vehicle.toml":
        return load_vehicle
    if name == "signals.toml":
        return load_signals
    signals = folder / "roles.toml"
    if not signals.exists():
        dbc = PRACTICE / "measurement.dbc"
        roles = (PRACTICE / "p01" / "signals.toml").read_text()
        signals.write_text(re.sub(r"(?m)^dbc = .*$", f"dbc = '{dbc}'", roles))
        named = 'speed = "speed"\ncar_yaw_rate = "car_yaw_rate"\n'
        (folder / "names.toml").write_text(f"[signals]\n{named}")
    chosen = folder / ("names.toml" if name.startswith("signals") else "roles.toml")
    return lambda path: load_drives([path], chosen)


def run_one(path: Path, use: Callable[[Path], object]) -> str:
    """``result``, ``refused``, or what went wrong."""
    try:
        use(path)
    except SwaywatchError as error:
        return "refused" if str(error).strip() else "an error without words"
    except TooSlowError:
        return "too slow"
    except MemoryError:
        return "too much memory"
    except RecursionError:
        return "RecursionError"
    except Exception:  # what this is about
        return traceback.format_exc()
    return "result"


def fuzz(
    seconds: float, count: int, seed: int, out: Path | None
) -> tuple[Counter[str], list[tuple[str, str]]]:
    """Run until one of both limits; how each kind ended, and the findings."""
    ended: Counter[str] = Counter()
    findings: list[tuple[str, str]] = []
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        (folder / "seeds").mkdir()
        whole = seeds(folder / "seeds")
        uses = {name: user_of(name, folder) for name in whole}
        start, number = time.monotonic(), 0
        while time.monotonic() - start < seconds and number < count:
            rng = np.random.default_rng((seed, number))
            name = list(whole)[number % len(whole)]
            path = folder / name
            path.write_bytes(mutated(whole[name], rng))
            kept = None if out is None else out / f"{seed}-{number}-{name}"
            if kept is not None:  # before it is used: it may end the interpreter
                kept.parent.mkdir(parents=True, exist_ok=True)
                kept.write_bytes(path.read_bytes())
            said = guarded(path, uses[name])
            ended[f"{name}: {said if said in ('result', 'refused') else 'FOUND'}"] += 1
            if said not in ("result", "refused"):
                findings.append((f"{name} {seed} {number}", said))
            elif kept is not None:
                kept.unlink()
            number += 1
    return ended, findings


def guarded(path: Path, use: Callable[[Path], object]) -> str:
    """As :func:`run_one`, with the limits on time and on memory newly taken."""

    def late(*_: object) -> None:
        raise TooSlowError

    before = [(kind, signal.signal(kind, late)) for kind in (signal.SIGPROF, signal.SIGALRM)]
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    signal.setitimer(signal.ITIMER_PROF, LIMIT_S)
    signal.alarm(WAIT_S)
    try:
        said = run_one(path, use)
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.alarm(0)
        for kind, handler in before:
            signal.signal(kind, handler)
    grown = 1024 * (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - peak)
    return said if grown < LIMIT_BYTES else f"{said}, {grown >> 20} MB"


def main() -> int:
    """Run for a time; exit code 1 where something was found."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=600.0)
    parser.add_argument("--count", type=int, default=10**9)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=Path, default=Path("build/fuzz/fuzz_recordings"))
    args = parser.parse_args()
    faulthandler.enable()
    ended, findings = fuzz(args.seconds, args.count, args.seed, args.out)
    for name, count in sorted(ended.items()):
        print(f"{count:7d}  {name}")
    kinds = Counter(said.strip().splitlines()[-1] for _, said in findings)
    for said, count in kinds.most_common():
        print(f"FOUND {count} times: {said}")
    for name, said in findings[:20]:
        print(f"--- {name}\n{said}")
    print(f"{sum(ended.values())} files, {len(findings)} findings, seed {args.seed}")
    return 1 if findings else 0


if __name__ == "__main__":
    sys.exit(main())
