"""swaywatch in a notebook: results that show themselves, numbers as tables, pictures to zoom.

    from swaywatch import notebook as sway

    drive = sway.analyze("run1.asc", vehicle="vehicle.toml", signals="signals.toml")[0]
    drive                        # verdict, reasons, figures
    drive.picture("oscillation")
    drive.frame()                # every estimate, a pandas DataFrame

The functions do what the commands of the same names do. Pictures hold everything they need and send
nothing, as the pages do.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import plotly.graph_objects as go

from swaywatch.analysis import DriveResult, Value
from swaywatch.analysis import analyze as run_analysis
from swaywatch.damping.data import Choice
from swaywatch.damping.intervals import QUANTITIES
from swaywatch.damping.model import LinearModel, load_model
from swaywatch.damping.page import course_figure, signal_figure
from swaywatch.damping.sentences import interval
from swaywatch.damping.sentences import sentences as damping_sentences
from swaywatch.damping.sentences import verdict as damping_verdict
from swaywatch.damping.study import Study, StudyPlan, as_json, evaluate
from swaywatch.ecu.bus import encode_drive
from swaywatch.ecu.core import unit_of
from swaywatch.first_files import inventory
from swaywatch.recording import write_recording
from swaywatch.report import figures
from swaywatch.report.page import make_report
from swaywatch.report.sentences import sentences, verdict
from swaywatch.report.shell import document, fill, plot

if TYPE_CHECKING:
    import pandas as pd

File = Path | str
Files = File | Sequence[File]

_DRAWN: dict[str, Callable[[DriveResult], go.Figure | None]] = {
    "signals": figures.signals,
    "time_frequency": figures.time_frequency,
    "oscillation": figures.oscillation,
    "stiffness": figures.stiffness,
    "loads": figures.loads,
    "margin": figures.margin,
    "margin_against_speed": lambda result: figures.margin_against_speed([result]),
}


def _paths(files: Files) -> list[Path]:
    return [Path(files)] if isinstance(files, str | Path) else [Path(one) for one in files]


@dataclass(frozen=True)
class Picture:
    """A plot; `figure` is Plotly's, for those who go on with it."""

    name: str
    figure: go.Figure

    def _repr_html_(self) -> str:
        # a page of its own within the notebook: its rules hold there too
        page = document(
            "report/plot.html", self.name.replace("_", " "),
            plot=plot(go.Figure(self.figure), name=self.name),
        )  # fmt: skip
        height = int(self.figure.layout.height or 450) + 220
        return fill("notebook_picture.html", page=page, height=height)


def _shown(
    verdict: str, reasons: Sequence[str], head: Sequence[str], rows: Sequence[Sequence[Any]]
) -> str:
    """Verdict, reasons and a table, whose cells are words or lists of lines."""
    return fill("notebook.html", verdict=verdict, reasons=reasons, head=head, rows=rows)


def _frame(columns: dict[str, Any]) -> pd.DataFrame:
    import pandas

    return pandas.DataFrame(columns)


@dataclass(frozen=True)
class AnalyzedDrive:
    """One drive after :func:`analyze`."""

    result: DriveResult

    @property
    def verdict(self) -> str:
        """The answer in one sentence."""
        return verdict(self.result)[1]

    @property
    def sentences(self) -> list[str]:
        """The reasons."""
        return sentences(self.result)

    @property
    def values(self) -> dict[str, Value]:
        """Figures with their standard errors, SI."""
        return self.result.values

    @property
    def findings(self) -> list[str]:
        """What is wrong with the data."""
        return [finding.text for finding in self.result.findings]

    def frame(self) -> pd.DataFrame:
        """Every estimate, SI, over the time in s; units in ``frame().attrs["units"]``."""
        columns = self.result.estimates.columns
        found = _frame(dict(columns))
        found.index = self.result.estimates.time_s
        found.index.name = "time_s"
        found.attrs["units"] = {name: unit_of(name) for name in columns}
        return found

    def picture(self, name: str) -> Picture:
        """One plot of the page.

        Raises
        ------
        ValueError
            No such plot, or nothing to draw in it: says which there are.
        """
        drawn = _DRAWN[name](self.result) if name in _DRAWN else None
        if drawn is None:
            reason = "nothing to draw" if name in _DRAWN else "no such picture"
            raise ValueError(f"{name}: {reason}; there are {', '.join(_DRAWN)}")
        return Picture(name, drawn)

    def save(self, path: File) -> Path:
        """The page of this drive."""
        path = Path(path)
        path.write_text(make_report([self.result]), encoding="utf-8")
        return path

    def _repr_html_(self) -> str:
        rows = [
            [name, f"{value.value:.4g}", f"{value.error:.2g}", str(value.count)]
            for name, value in self.values.items()
            if np.isfinite(value.value)
        ]
        head = ["figure (SI)", "value", "standard error", "estimates"]
        return _shown(self.verdict, self.sentences, head, rows)


@dataclass(frozen=True)
class Swings:
    """Free oscillations after :func:`damping`."""

    study: Study

    @property
    def verdict(self) -> str:
        """The answer in one sentence."""
        return damping_verdict(self.study)[1]

    @property
    def sentences(self) -> list[str]:
        """What else is to be said."""
        return damping_sentences(self.study)

    def as_dict(self) -> dict[str, Any]:
        """What ``damping --json`` gives."""
        return as_json(self.study)

    def frame(self) -> pd.DataFrame:
        """A row for each window: times, speed, each quantity with its 95 % limits."""
        columns: dict[str, list[Any]] = {
            "recording": [point.run for point in self.study.points],
            "start_s": [point.start_s for point in self.study.points],
            "end_s": [point.end_s for point in self.study.points],
            "against": [point.against for point in self.study.points],
        }
        for name in QUANTITIES:
            own = [getattr(point, name) for point in self.study.points]
            columns[name] = [value.value for value in own]
            columns[f"{name}_low_95"] = [value.low for value in own]
            columns[f"{name}_high_95"] = [value.high for value in own]
        return _frame(columns)

    def picture(self, name: str = "course") -> Picture:
        """``course``: damping, frequency, growth over the speed; else the name of a recording.

        Raises
        ------
        ValueError
            No such recording: says which there are.
        """
        if name == "course":
            return Picture(name, course_figure(self.study))
        for found in self.study.found:
            if found.run.name == name:
                return Picture(name, signal_figure(found))
        there = ", ".join(["course", *(found.run.name for found in self.study.found)])
        raise ValueError(f"{name}: no such picture; there are {there}")

    def _repr_html_(self) -> str:
        head = [self.study.against_name or "", "windows", "frequency [Hz]", "damping ratio"]
        rows = [
            [
                "" if np.isnan(place.against) else f"{place.against:.4g}",
                str(place.count),
                interval(place.frequency_hz),
                interval(place.damping_ratio) if place.determinable else "not determinable",
            ]
            for place in self.study.places
        ]
        return _shown(self.verdict, self.sentences, head, rows)


@dataclass(frozen=True)
class Diagnosis:
    """What a simulation lacks, after :func:`diagnose`; `content` is ``diagnosis.json``."""

    content: dict[str, Any]

    @property
    def verdict(self) -> str:
        """``consistent``, ``effects_found`` ..."""
        return str(self.content["verdict"])

    @property
    def effects(self) -> list[dict[str, Any]]:
        """Each with id, component, parameters, confidence."""
        return list(self.content["effects"])

    @property
    def sentences(self) -> list[str]:
        """One for each effect."""
        from swaywatch.diagnose.report.sentences import sentence

        return [sentence(effect, self.content.get("stability")) for effect in self.effects]

    def _repr_html_(self) -> str:
        from swaywatch.diagnose.report.labels import how_much, part

        rows = [
            [
                str(effect["id"]),
                part(effect["component"]),
                f"{effect['confidence']:.2f}",
                how_much(effect),
            ]
            for effect in self.effects
        ]
        head = ["effect", "where", "confidence", "how much"]
        return _shown(self.verdict, self.sentences, head, rows)


def signals_of(recording: File, dbc: Files = ()) -> pd.DataFrame:
    """Every signal of a recording: message, unit, rate, range.

    Raises
    ------
    SwaywatchError
        The file cannot be read.
    """
    found, _ = inventory.inventory([Path(recording)], _paths(dbc))
    return _frame(
        {
            "signal": [one.name for one in found],
            "unit": [one.unit for one in found],
            "rate_hz": [one.rate_hz for one in found],
            "least": [float(np.min(one.value)) for one in found],
            "most": [float(np.max(one.value)) for one in found],
        }
    )


def simulate(scenario: File, to: File, *, signals: File, seed: int | None = None) -> Path:
    """A scenario driven by our own model, as a recording and its ``signals.toml``.

    Raises
    ------
    SwaywatchError
        The scenario is at fault.
    """
    from swaywatch.simulate import load_scenario, simulate_scenario
    from swaywatch.simulate.signals import write_signals

    drive, _ = simulate_scenario(load_scenario(scenario, seed))
    write_recording(to, encode_drive(drive))
    write_signals(Path(signals), drive)
    return Path(to)


def analyze(
    recordings: Files, *, vehicle: File, signals: File, window: float | None = None
) -> list[AnalyzedDrive]:
    """Stability margin, damping, stiffnesses of each drive; see ``swaywatch analyze``.

    Raises
    ------
    SwaywatchError
        The input is at fault.
    """
    results = run_analysis(_paths(recordings), Path(vehicle), Path(signals), window=window)
    return [AnalyzedDrive(result) for result in results]


def damping(
    recordings: Files,
    *,
    channels: Sequence[str] = (),
    inputs: Sequence[str] = (),
    against: str | None = None,
    signals: File | None = None,
    compare: Files = (),
    names: tuple[str, str] = ("first", "second"),
    model: LinearModel | str | None = None,
    band_hz: tuple[float, float] = (0.2, 10.0),
) -> Swings:
    """Free oscillations of any vehicle's recordings; see ``swaywatch damping``.

    `model` is a file, or what :func:`swaywatch.damping.model.from_systems` makes of python-control
    systems.

    Raises
    ------
    SwaywatchError
        The input is at fault.
    """
    chosen = Choice(
        tuple(channels), tuple(inputs), against, None if signals is None else Path(signals)
    )
    linear = load_model(model) if isinstance(model, str) else model
    return Swings(
        evaluate(
            _paths(recordings), StudyPlan(chosen, band_hz), compare=_paths(compare), names=names,
            model=linear,
        )
    )  # fmt: skip


def diagnose(
    recordings: Files, *, vehicle: File, signals: File, simulations: Files = ()
) -> Diagnosis:
    """What physics a simulation lacks; see ``swaywatch diagnose``.

    Raises
    ------
    SwaywatchError
        The input is at fault.
    """
    from swaywatch.diagnose.engine import diagnose as run_diagnosis

    return Diagnosis(
        run_diagnosis(
            _paths(recordings), Path(vehicle), Path(signals), simulations=_paths(simulations)
        )
    )
