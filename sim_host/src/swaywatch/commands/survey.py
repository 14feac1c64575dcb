"""``swaywatch survey``: a folder of recordings over night."""

from __future__ import annotations

import argparse
import os
import time
from pathlib import Path
from typing import Any


def add_parser(subparsers: Any) -> None:
    """Add the ``survey`` command."""
    parser = subparsers.add_parser(
        "survey",
        help="overnight: which recordings of a folder disagree with the model, where and why",
        description="Analyse and diagnose every recording below a folder; those of the same "
        "combination that disagree with the model are then diagnosed together. A "
        "vehicle.toml and a signals.toml beside a recording "
        "(or above it) take precedence over those given here. Started again, it resumes where "
        "it stopped. survey.parquet has a row for each run, survey.html lists the worst first "
        "and the outliers of the fleet. Exit code 1: done, but some runs failed; the page gives "
        "the reasons.",
    )
    parser.add_argument("folder", type=Path, help="folder with recordings, at any depth")
    parser.add_argument(
        "--vehicle",
        type=Path,
        metavar="TOML",
        help="vehicle.toml of recordings that have none beside or above them",
    )
    parser.add_argument(
        "--signals",
        type=Path,
        metavar="TOML",
        help="signals.toml of recordings that have none beside or above them",
    )
    parser.add_argument(
        "--out", type=Path, default=Path("swaywatch-survey"), metavar="DIR",
        help="folder for survey.html, survey.parquet, survey.jsonl and the pages "
        "(default: %(default)s)",
    )  # fmt: skip
    parser.add_argument(
        "--exclude", action="append", default=None, metavar="PATTERN",
        help="file names to leave out (default: simulation*); may be repeated",
    )  # fmt: skip
    parser.add_argument(
        "--jobs", type=int, default=os.cpu_count() or 1, metavar="N",
        help="processes at a time (default: one for each processor core)",
    )  # fmt: skip
    parser.add_argument(
        "--scheduler", metavar="ADDRESS",
        help="address of a dask cluster whose workers do the work, such as tcp://host:8786; they "
        "need the same swaywatch, the folder and --out (pip install 'swaywatch[cluster]')",
    )  # fmt: skip
    parser.add_argument(
        "--diagnose", choices=("all", "outliers", "none"), default="all",
        help="which runs to diagnose; outliers: analyse all and diagnose only those that differ "
            "from the rest of the fleet "
            "(default: %(default)s)",
    )  # fmt: skip
    parser.add_argument(
        "--limit", type=float, default=1800.0, metavar="S",
        help="time limit of one analysis or diagnosis, s (default: %(default)s)",
    )  # fmt: skip


def run(args: argparse.Namespace) -> int:
    """Survey, tell each run as it comes, write the page."""
    from swaywatch.errors import SwaywatchError
    from swaywatch.recording.guard import must_exist, whole_file
    from swaywatch.survey.outcome import SurveyOutcome
    from swaywatch.survey.page import count_words, make_page
    from swaywatch.survey.plan import find_runs
    from swaywatch.survey.work import survey
    from swaywatch.survey.workers import workers

    if args.jobs < 1:
        raise SwaywatchError(f"--jobs {args.jobs}; expected 1 or more")
    for path in (args.vehicle, args.signals):
        if path is not None:
            must_exist(path, "TOML file")
    exclude = ["simulation*"] if args.exclude is None else args.exclude
    out = args.out.resolve()
    folder = args.folder.resolve()
    given = [None if path is None else path.resolve() for path in (args.vehicle, args.signals)]
    runs = find_runs(folder, given[0], given[1], exclude, out)
    start, done = time.monotonic(), 0

    def report(outcome: SurveyOutcome) -> None:
        nonlocal done
        done += 1
        reason = f": {outcome.line()}" if outcome.why else ""
        place = f"{done}/{len(runs)}" if done <= len(runs) else "then"
        print(f"[{place}] {outcome.name}  {outcome.state}{reason}", flush=True)

    with workers(args.jobs, args.scheduler, folder, out) as executor:
        alone, together = survey(
            runs, out, executor, diagnose=args.diagnose, limit_s=args.limit, report=report
        )
    took = f"{(time.monotonic() - start) / 60.0:.0f} min"
    page = args.out / "survey.html"
    with whole_file(page) as temporary:
        temporary.write_text(make_page(str(args.folder), alone, together, took), encoding="utf-8")
    print(f"{count_words(alone)}\n{page}")
    return 1 if any(outcome.state == "failed" for outcome in [*alone, *together]) else 0
