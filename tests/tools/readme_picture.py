"""The picture at the top of the README: ``make readme-picture``.

Left a simulated drive through the critical speed as the ECU sees it, right the repository's
recording p03 (made by a simulator that is not ours) before and after its diagnosis. Everything
drawn is computed here by the commands' own functions; nothing is drawn by hand.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from swaywatch.analysis import DriveResult, analyze, found_critical
from swaywatch.cli import main as swaywatch
from swaywatch.diagnose import engine
from swaywatch.diagnose.report import page
from swaywatch.report.figures import ALARM_COLOUR, BLUE, GREY, RED

ROOT = Path(__file__).resolve().parents[2]
CASE = ROOT / "tests/data/practice/p03"
SCENARIO = ROOT / "tests/data/scenarios/through_critical.toml"
DRIVEN = ROOT / "tests/data/practice/p01/vehicle.toml"
KMH, DEG = 3.6, 57.2958
ALARMS = ("notice", "warning", "critical")


def drive() -> DriveResult:
    """The drive, simulated and analysed."""
    with tempfile.TemporaryDirectory() as folder:
        recording, signals = Path(folder) / "drive.mf4", Path(folder) / "signals.toml"
        command = ["simulate", str(SCENARIO), "--out", str(recording), "--signals", str(signals)]
        if swaywatch([*command, "--quiet"]) != 0:
            raise SystemExit("readme-picture: the scenario could not be simulated")
        return analyze([recording], DRIVEN, signals)[0]


def diagnosed() -> engine.Diagnosed:
    """The diagnosis of the case with its fits."""
    return engine.diagnose_combination(
        [CASE / "run1.asc", CASE / "run2.asc"], CASE / "vehicle.toml", CASE / "signals.toml"
    )


def draw_drive(axes: list[Axes], result: DriveResult) -> None:
    """Swing, speed with critical speed, damping ratio with its error band; alarms behind."""
    swing, speed, damping = axes
    channel = result.drive.channels["trailer_yaw_rate"]
    swing.plot(channel.time_s, channel.value * DEG, color=BLUE, lw=0.8)
    swing.set_title("While driving: towards the critical speed and beyond it", loc="left",
                    fontweight="bold")  # fmt: skip
    swing.set_ylabel("trailer\nyaw rate, deg/s")
    estimates = result.estimates
    channel = result.drive.channels["speed"]
    speed.plot(channel.time_s, channel.value * KMH, color=BLUE, lw=1.4)
    has = estimates.has("critical_speed") & found_critical(estimates)
    _band(speed, estimates.time_s[has], estimates["v_crit_m_s"][has] * KMH,
          estimates["v_crit_se_m_s"][has] * KMH, RED)  # fmt: skip
    speed.set_ylim(96, 136)
    speed.text(30, 112, "speed", color=BLUE)
    speed.text(1, 132.5, "critical speed ± 2 standard errors", color=RED)
    speed.set_ylabel("km/h")
    good = estimates.has("line") & ~estimates.flagged("misfit") & ~estimates.flagged("forced")
    _band(damping, estimates.time_s[good], estimates["damping_ratio"][good],
          estimates["damping_ratio_se"][good], GREY)  # fmt: skip
    damping.axhline(0.0, color="black", lw=0.8)
    damping.set_ylim(-0.05, 0.15)
    damping.set_ylabel("damping ratio")
    damping.set_xlabel("time, s")
    for alarm in result.alarms:
        if alarm.state in ALARMS:
            for one in axes:
                one.axvspan(alarm.start_s, alarm.end_s, color=ALARM_COLOUR[alarm.state], alpha=0.3,
                            lw=0)  # fmt: skip
    for state in ALARMS:
        starts = [a.start_s for a in result.alarms if a.state == state]
        if starts:
            low, high = swing.get_ylim()
            swing.text(starts[0] + 0.4, low + 0.05 * (high - low), state, color="#374151")


def _band(axes: Axes, time: Any, value: Any, error: Any, colour: str) -> None:
    """A line with two standard errors to either side, broken where there are no estimates."""
    breaks = np.flatnonzero(np.diff(time) > 1.0) + 1
    for part in np.split(np.arange(len(time)), breaks):
        axes.fill_between(time[part], (value - 2 * error)[part], (value + 2 * error)[part],
                          color=colour, alpha=0.25, lw=0)  # fmt: skip
        axes.plot(time[part], value[part], color=colour, lw=1.2)


def draw_diagnosis(axes: list[Axes], found: engine.Diagnosed) -> None:
    """Measured, simulated before and after; the difference; the load of the axle concerned."""
    signal, error, load = axes
    verdict = found.verdict
    assert verdict is not None
    run = verdict.problem.runs[0]
    measured, before, after = page.measured_before_after(verdict, 0)
    wheels = ("wheel_vertical_load_rl", "wheel_vertical_load_rr")
    for (_, channels, _), label, colour, width in (
        (measured, "measured", "black", 0.9), (before, "simulated", RED, 1.1),
        (after, "simulated with what was found", BLUE, 1.1),
    ):  # fmt: skip
        yaw = channels["car_yaw_rate"] * DEG
        signal.plot(run.time, yaw, color=colour, lw=width, label=label)
        total = page.low_pass(sum(channels[name] for name in wheels), 4.0)
        load.plot(run.time, total * 1e-3, color=colour, lw=width)
        if label != "measured":
            rest = run.channels["car_yaw_rate"] * DEG - yaw
            error.plot(run.time, page.low_pass(rest - rest.mean(), 5.0), color=colour, lw=width)
    signal.set_title("Afterwards: a recording against its simulation", loc="left",
                     fontweight="bold")  # fmt: skip
    signal.set_ylim(-11.0, 9.0)
    signal.legend(loc="lower right", frameon=False, ncols=3, fontsize=8, handlelength=1.2)
    signal.set_ylabel("car\nyaw rate, deg/s")
    error.set_ylabel("measured minus\nsimulated, deg/s")
    load.set_ylabel("load of the car's\nrear axle, kN")
    load.set_xlabel("time, s")
    load.text(18.6, load.get_ylim()[0] + 0.15,
              "found: an axle load that oscillates\nat twice the yaw frequency, from when\n"
              "to when and how strongly", color=BLUE, va="bottom")  # fmt: skip
    for effect in found.result["effects"]:
        for window in effect.get("window_details", []):
            if window["run"] == run.name:
                for one in axes:
                    one.axvspan(window["start"], window["stop"], color="#fde68a", alpha=0.5, lw=0)


def main(path: Path) -> None:
    """Draw and write the picture."""
    mpl.rcParams.update({
        "font.family": "DejaVu Sans", "font.size": 9, "axes.spines.top": False,
        "axes.spines.right": False, "svg.hashsalt": "swaywatch", "path.simplify_threshold": 0.5,
    })  # fmt: skip
    result, found = drive(), diagnosed()
    figure = Figure(figsize=(11.0, 6.2), layout="constrained")
    grid = figure.subplots(3, 2, sharex="col")
    draw_drive(list(grid[:, 0]), result)
    draw_diagnosis(list(grid[:, 1]), found)
    figure.savefig(path, metadata={"Date": None})


if __name__ == "__main__":
    main(Path(sys.argv[1]))
