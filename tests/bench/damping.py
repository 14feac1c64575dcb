"""``make bench-damping``: swaywatch damping beside other people's methods, on the same windows.

1. Measured: the pushes of the riderless bicycle (TU Delft) in windows cut by its authors. The
   reference of a push is the mean of the hand fits of the *other* pushes at its speed and
   controller, so no method is judged by the push itself. The pushes differ among themselves; the
   row "hand fit" says by how much, and no method can come far below it.
2. Simulated: one mode under process noise, hit four times; there the truth is known.

Intervals are those of 95 % that a method states; in the first table the uncertainty of the
reference is added. Time is of the processor per window, without reading.
"""

from __future__ import annotations

import argparse
import csv
import math
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from damping_methods import NOTHING, Array, Swing, on_windows, ssi, ssi_whole
from scipy import signal

from swaywatch.damping.data import Choice, DampingRun, load_runs
from swaywatch.damping.find import Event, Found, SwingWindow, find
from swaywatch.damping.intervals import Point, point_of, points_of
from swaywatch.damping.window import Estimator, Line

BAND = (0.2, 10.0)
OWN, HERE = "swaywatch damping, windows its own", "swaywatch damping"
NEAR_S = 0.5
"""A window that is found belongs to a push whose own begins within this."""


@dataclass
class Row:
    """What a method said: errors of the damping ratio, whether its intervals held, seconds."""

    error: list[float] = field(default_factory=list)
    held: list[bool] = field(default_factory=list)
    frequency: list[float] = field(default_factory=list)
    missing: int = 0
    seconds: list[float] = field(default_factory=list)
    errors_per_place: dict[object, list[float]] = field(default_factory=dict)

    def add(
        self, swing: Swing, truth: float, frequency_hz: float, uncertainty: float, half: float,
        place: object,
    ) -> None:  # fmt: skip
        """One window; `half`: of the stated 95 % interval, NaN where none is stated."""
        if not math.isfinite(swing.damping_ratio):
            self.missing += 1
            return
        off = swing.damping_ratio - truth
        self.error.append(off)
        self.errors_per_place.setdefault(place, []).append(off)
        self.frequency.append(swing.frequency_hz / frequency_hz - 1.0)
        if math.isfinite(half):
            self.held.append(abs(off) <= math.hypot(half, uncertainty))

    def cells(self) -> list[str]:
        """Cells of the table."""
        if not self.error:
            return ["-"] * 6
        error = np.array(self.error)
        bias = [float(np.mean(own)) for own in self.errors_per_place.values()]
        held = coverage(self)
        spent = f"{1e3 * np.median(self.seconds):.2g}" if self.seconds else "-"
        return [
            f"{np.median(np.abs(error)):.3f}",
            f"{math.sqrt(float(np.mean(error**2))):.3f}",
            f"{math.sqrt(float(np.mean(np.square(bias)))):.3f}",
            f"{100 * np.median(np.abs(self.frequency)):.1f} %",
            held,
            f"{self.missing}",
            spent,
        ]


def coverage(row: Row) -> str:
    """How many of a method's intervals hold."""
    if not row.held:
        return "none stated"
    return f"{100 * np.mean(row.held):.0f} % of {len(row.held)}"


HEADS = (
    "method", "error of the damping ratio, median", "RMS", "RMS of the means",
    "error of the frequency, median",
    "95 % intervals with the true value", "no answer", "ms a window",
)  # fmt: skip


def table(title: str, rows: dict[str, Row], note: str) -> str:
    """Markdown."""
    lines = [title, "", "| " + " | ".join(HEADS) + " |", "|" + "---|" * len(HEADS)]
    lines += [f"| {name} | " + " | ".join(row.cells()) + " |" for name, row in rows.items()]
    return "\n".join([*lines, "", note, ""])


def clocked(row: Row, call: Callable[[], Swing]) -> Swing:
    """A method's answer and its time; what a method cannot do is no answer."""
    begin = time.process_time()
    try:
        swing = call()
    except (np.linalg.LinAlgError, ValueError, IndexError):
        swing = NOTHING
    row.seconds.append(time.process_time() - begin)
    return swing


def given(
    found: Found, estimator: Estimator, start_s: float, end_s: float, about_hz: float
) -> Point | None:
    """Our estimate, with its uncertainty, of a window that somebody else has cut."""

    def line(first: float, last: float) -> Line | None:
        rows = found.run.rows(first, last)
        value = found.run.value[rows]
        return estimator.line(
            value, found.run.time_s[rows.start], found.run.step_s, about_hz, level=True
        )

    middle = line(start_s, end_s)
    if middle is None or not BAND[0] <= middle.frequency_hz <= BAND[1]:
        return None
    length = end_s - start_s
    beside = [line(start_s, start_s + length * times) for times in (0.85, 1.15)]
    window = SwingWindow(middle, tuple(one for one in beside if one is not None), None, math.nan)
    return point_of(found, Event(start_s, 1.0, (window,)), window, 1)


def said(point: Point | None) -> tuple[Swing, float]:
    """A point as a swing, and the half-width of its interval."""
    if point is None:
        return NOTHING, math.nan
    ratio = point.damping_ratio
    return Swing(point.frequency_hz.value, ratio.value, ratio.error), ratio.half


@dataclass(frozen=True)
class Cut:
    """A window with the reference of its damping ratio, and that one's standard error."""

    start_s: float
    end_s: float
    ratio: float
    frequency_hz: float
    uncertainty: float


def judge(
    rows: dict[str, Row], run: DampingRun, cuts: Sequence[Cut], place: object, estimator: Estimator
) -> None:
    """Every method on every window of a run of one channel."""
    begin = time.process_time()
    found = find(run, BAND, estimator)
    points = points_of(found)
    spent = time.process_time() - begin
    methods = on_windows()
    for cut in cuts:
        own = rows.setdefault(OWN, Row())
        near = [p for p in points if abs(p.start_s - cut.start_s) < NEAR_S / cut.frequency_hz]
        swing, half = said(near[0] if near else None)
        own.add(swing, cut.ratio, cut.frequency_hz, 1.96 * cut.uncertainty, half, place)
        own.seconds.append(spent / max(1, len(points)))
        here = rows.setdefault(HERE, Row())
        begin = time.process_time()
        point = given(found, estimator, cut.start_s, cut.end_s, found.frequency_hz)
        here.seconds.append(time.process_time() - begin)
        swing, half = said(point)
        here.add(swing, cut.ratio, cut.frequency_hz, 1.96 * cut.uncertainty, half, place)
        x = run.value[run.rows(cut.start_s, cut.end_s), 0] - np.median(run.value[:, 0])
        for name, method in methods.items():
            row = rows.setdefault(name, Row())
            swing = clocked(row, lambda method=method, x=x: method(x, run.step_s))
            row.add(
                swing,
                cut.ratio,
                cut.frequency_hz,
                1.96 * cut.uncertainty,
                1.96 * swing.error,
                place,
            )
    if ssi is not None and cuts:
        row = rows.setdefault("SSI (pyOMA2), whole recording", Row())
        about = float(np.mean([cut.frequency_hz for cut in cuts]))
        swing = clocked(row, lambda: ssi_whole(run.value[:, 0], run.step_s, about))
        ratio = float(np.mean([cut.ratio for cut in cuts]))
        uncertainty = 1.96 * float(np.mean([cut.uncertainty for cut in cuts]))
        row.add(swing, ratio, about, uncertainty, 1.96 * swing.error, place)


def on_pushes(folder: Path) -> tuple[dict[str, Row], int]:
    """Every method on the bicycle's pushes, and how many these are."""
    with (folder / "segments_and_fits.csv").open(encoding="utf-8") as file:
        pushes = [row for row in csv.DictReader(file) if float(row["v_mps"]) >= 2.0]
    rows: dict[str, Row] = {"hand fit (least squares)": Row()}
    estimator = Estimator()
    for place in sorted({(p["mode"], float(p["v_mps"])) for p in pushes}):
        here = [p for p in pushes if (p["mode"], float(p["v_mps"])) == place]
        zeta = np.array([float(p["zeta"]) for p in here])
        frequency = np.array([float(p["f"]) for p in here])
        cuts = []
        for k, push in enumerate(here):
            others = np.delete(zeta, k)
            uncertainty = float(others.std(ddof=1)) / math.sqrt(len(others))
            start, stop = sorted((int(push["start"]) / 100, int(push["stop"]) / 100))
            # a window of rows start..stop-1
            cut = Cut(
                start,
                stop - 0.01,
                float(others.mean()),
                float(np.delete(frequency, k).mean()),
                uncertainty,
            )
            cuts.append(cut)
            hand = Swing(float(frequency[k]), float(zeta[k]))
            rows["hand fit (least squares)"].add(
                hand, cut.ratio, cut.frequency_hz, 0.0, math.nan, place
            )
        name = f"{place[0]}_{place[1] * 3.6:g}kph.parquet"
        (run,) = load_runs([folder / name], Choice(("lean_rate",), (), "speed"))
        judge(rows, run, cuts, place, estimator)
    return rows, len(pushes)


def measured(folder: Path) -> str:
    """The bicycle."""
    rows, pushes = on_pushes(folder)
    return table(
        f"**`make bench-damping`, measured**: {pushes} pushes of a riderless bicycle "
        "(TU Delft), 2 to 5 m/s, damping ratio 0.40 to 0.19, windows of 1 s (0.9 to 1.3 swings) "
        "cut by the authors",
        rows,
        "Reference of a push: mean of the hand fits of the other pushes at its speed and "
        "controller, so the pushes' own scatter is in every row; it is least squares on the same "
        "windows, which favours least-squares methods. RMS of the means: of the 14 places. One "
        "channel (lean rate), offset removed by the recording's median; pyOMA2 on a whole "
        "recording is one answer for each.",
    )  # fmt: skip


def mode(
    rng: np.random.Generator, frequency_hz: float, ratio: float, rate_hz: float, share: float
) -> tuple[Array, Array]:
    """Rate of a mode under process noise, hit four times; the times of the hits."""
    omega = 2 * math.pi * frequency_hz / math.sqrt(1 - ratio**2)
    cycles = 16 if ratio > 0.1 else 40
    rows = int(5 * cycles / frequency_hz * rate_hz)
    a = np.array([[0.0, 1.0], [-(omega**2), -2 * ratio * omega]])
    dense = signal.cont2discrete(
        (a, np.array([[0.0], [1.0]]), np.eye(2)[1:], np.zeros((1, 1))), 1 / rate_hz
    )
    system = (*dense[:4], 1 / rate_hz)
    _, ambient, _ = signal.dlsim(system, rng.normal(0.0, 1.0, rows))
    force = np.zeros(rows)
    hits = (np.arange(1, 5) * cycles / frequency_hz * rate_hz).astype(int)
    force[hits] = 1.0
    _, free, _ = signal.dlsim(system, force)
    value = free / np.abs(free).max() + ambient * share / ambient.std()
    return np.asarray(value + rng.normal(0.0, 0.003, value.shape) + 0.5), hits / rate_hz


def simulated(count: int) -> str:
    """Modes of known damping."""
    rng = np.random.default_rng(20261122)
    rows: dict[str, Row] = {}
    estimator = Estimator()
    for _ in range(count):
        frequency = float(np.exp(rng.uniform(math.log(0.4), math.log(4.0))))
        ratio = float(rng.choice([0.03, 0.1, 0.2, 0.3]))
        share = float(rng.choice([0.02, 0.05]))
        rate = 80.0 * frequency
        value, hits = mode(rng, frequency, ratio, rate, share)
        names = np.arange(len(value)) / rate
        run = DampingRun(
            "run", Path("run.csv"), names, 1 / rate, ("rate",), ("",), value,
            np.ones(len(value), dtype=np.bool_), (), np.zeros((len(value), 0)), None, "", "",
        )  # fmt: skip
        # from a hit to two time constants behind it, three swings at most, one at least
        length = min(3.0, max(1.0, 2.0 / (2 * math.pi * ratio))) / frequency
        cuts = [Cut(hit + 1 / rate, hit + length, ratio, frequency, 0.0) for hit in hits]
        judge(rows, run, cuts, (ratio, share), estimator)
    return table(
        f"### Simulated: {4 * count} pushes of a mode of 0.4 to 4 Hz, damping ratio 0.03 to "
        "0.3, under process noise of 2 or 5 % of the swing; windows of two time constants, 1 to 3 "
        "swings",
        rows,
        "Reference: the truth. RMS of the means: of the 8 kinds (4 damping ratios, 2 noises).",
    )  # fmt: skip


def main() -> int:
    """Write the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--bicycle", type=Path, help="folder of the bicycle's recordings")
    parser.add_argument("--simulated", type=int, default=60, help="modes (default: %(default)s)")
    parser.add_argument("--report", type=Path, required=True)
    args = parser.parse_args()
    parts = []
    if args.bicycle is not None and (args.bicycle / "segments_and_fits.csv").is_file():
        parts.append(measured(args.bicycle))
    else:
        print(
            "bench-damping: no recordings of the bicycle here, only what is simulated",
            file=sys.stderr,
        )
    if ssi is None:
        print("bench-damping: no pyOMA2 here, left out", file=sys.stderr)
    parts.append(simulated(args.simulated))
    args.report.parent.mkdir(parents=True, exist_ok=True)
    args.report.write_text("\n".join(parts), encoding="utf-8")
    print(args.report.read_text(encoding="utf-8"))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
