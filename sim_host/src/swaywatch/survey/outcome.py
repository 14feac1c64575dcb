"""What a survey found on a run, and how it is kept while the survey goes on."""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import asdict, dataclass, field
from pathlib import Path

from swaywatch.errors import RecordingError
from swaywatch.recording.guard import whole_file

STATES = ("disagrees", "agrees", "cannot say", "not diagnosed", "failed")
"""What a survey says of a run, the urgent first."""


@dataclass
class SurveyOutcome:
    """What a survey found on a run, or on several runs together.

    Attributes
    ----------
    state : one of :data:`STATES`
    whole : it was diagnosed and has its pages; else it was only analysed
    verdict : of the diagnosis
    mismatch : rest of the fit of the model, in its noise; about 1 where nothing is missing
    why : sentences: the effects, or what stood in the way
    where : windows and lines of each effect
    v_crit_kmh, v_crit_se_kmh : of the analysis
    values : of the analysis, by name: value, standard error, the same in vehicle.toml (or None)
    stands_out : sentences: what is unlike the other runs
    alarm : the highest state
    pages : what there is to open: title -> path below the survey's folder
    cpu_s, memory_mb : processor time and most memory of its commands
    """

    name: str
    key: str
    state: str = "failed"
    whole: bool = True
    vehicle: str = ""
    verdict: str = ""
    mismatch: float | None = None
    mismatch_after: float | None = None
    why: list[str] = field(default_factory=list)
    where: list[str] = field(default_factory=list)
    effects: list[str] = field(default_factory=list)
    v_crit_kmh: float | None = None
    v_crit_se_kmh: float | None = None
    values: dict[str, list[float | None]] = field(default_factory=dict)
    stands_out: list[str] = field(default_factory=list)
    conclusion: str = ""
    alarm: str = ""
    duration_s: float | None = None
    pages: dict[str, str] = field(default_factory=dict)
    cpu_s: float = 0.0
    memory_mb: float = 0.0

    def line(self) -> str:
        """What was found in one line: what and where, when, how much."""
        count = len(self.effects)
        found = [
            f"{what} [{where}]" if where else what
            for what, where in zip(self.why[:count], self.where, strict=False)
        ]
        return "; ".join([*found, *self.why[len(found) :]])


class Journal:
    """``survey.jsonl``: a line for each outcome, written as it comes.

    Parameters
    ----------
    folder : of the survey; what an earlier survey left there is kept, but for what failed

    Raises
    ------
    RecordingError
        It cannot be written.
    """

    def __init__(self, folder: Path) -> None:
        self.path = folder / "survey.jsonl"
        self.kept = {o.name: o for o in _read(self.path) if o.state != "failed"}
        self.write(self.kept.values())  # without a last line that was cut off

    def add(self, outcome: SurveyOutcome) -> None:
        """Append one."""
        try:
            with self.path.open("a", encoding="utf-8") as stream:
                stream.write(_line(outcome))
        except OSError as error:
            raise RecordingError(f"{self.path}: cannot be written: {error.strerror}") from None

    def write(self, outcomes: Iterable[SurveyOutcome]) -> None:
        """Write all of them anew, one line for each."""
        with whole_file(self.path) as temporary:
            temporary.write_text("".join(map(_line, outcomes)), encoding="utf-8")


def _line(outcome: SurveyOutcome) -> str:
    return json.dumps(asdict(outcome)) + "\n"


def _read(path: Path) -> list[SurveyOutcome]:
    """Outcomes in a file; later lines of a run count, lines that are none do not."""
    try:
        lines = path.read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError:
        return []
    found: dict[str, SurveyOutcome] = {}
    for line in lines:
        try:
            outcome = SurveyOutcome(**json.loads(line))
        except (ValueError, TypeError):
            continue
        found[outcome.name] = outcome
    return list(found.values())
