"""``make bench-car``: what issue 15 asks of the car's own sensors, line by line, and what it is.

Each row is a line under "It must show" with its aim, today's figure and yes or no; what is not run
here says where it is. Nothing here is a test: a "no" is printed and stays. The parts are in
`car_sensors.py` and `trailer_swap.py`; their generated drives begin at seed 20001.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import car_sensors
import trailer_swap
from trailer_swap import Pair
from written import written

from swaywatch.trailer import INTERVAL

ROLES = Path(__file__).resolve().parents[1] / "data" / "real"
CARD = ("p01", "p03", "p05", "p08")
KNOWN = (("all", 3.0), ("mass and length", 6.0))


@dataclass(frozen=True)
class Row:
    """A line, its aim, what came out, and whether that is it; None: not run here."""

    line: str
    aim: str
    figure: str
    shown: bool | None


def limits(f: dict[str, Any]) -> str:
    """Error of the critical speed and its intervals."""
    return (
        f"median error {f['median_error_percent']:.1f} % (signed {f['bias_percent']:+.1f} %), "
        f"{100 * f['in_90_percent_interval']:.0f} % of the 90 % intervals hold, "
        f"{f['reported']} reported"
    )


def held(f: dict[str, Any], aim: float) -> bool:
    """Near enough, with honest intervals."""
    return bool(f["median_error_percent"] <= aim and 0.80 <= f["in_90_percent_interval"] <= 0.97)


def of_recordings(found: dict[str, Any]) -> Iterator[Row]:
    """Practice and road, the car's own four channels."""
    for name, words in (("frequency_hz", "frequency"), ("damping_ratio", "damping ratio")):
        f = found[name]
        yield Row(
            f"{f['cases']} recordings: {words} within its 95 % interval (reference: all sensors, "
            "with their own error)",
            "92 to 98 %",
            f"{100 * f['inside_95']:.0f} %",
            0.92 <= f["inside_95"] <= 0.98,
        )
        yield Row(
            f"{f['cases']} recordings: error of the {words} over that with all sensors (median)",
            "<= 2",
            f"{f['error_ratio_median']:.2f}",
            f["error_ratio_median"] <= 2.0,
        )
    for how, aim in KNOWN:
        yield Row(
            f"{found['cases']} recordings: critical speed, of the trailer known: {how}",
            f"<= {aim:.0f} %, 80 to 97 % hold",
            limits(found[how]),
            held(found[how], aim),
        )
    yield Row(
        f"{found['cases']} recordings: critical speed, of the trailer known: nothing",
        "<= 10 %, 80 to 97 % hold",
        limits(found["nothing"]),
        held(found["nothing"], 10.0),
    )
    yield card(found)


def card(found: dict[str, Any]) -> Row:
    """The user's card: with the car's wheel forces, each case by itself."""
    words, right = [], 0
    for case in found["table"]:
        if "card" not in case or case["card"][0] is None:
            continue
        value, se = case["card"]
        error = 100 * (value / case["true"] - 1)
        inside = abs(value - case["true"]) < INTERVAL * se
        right += inside and abs(error) <= 3.0
        words.append(
            f"{case['case']} {case['true']:.1f}: {value:.1f} ± {se:.1f} ({error:+.1f} %"
            + (")" if inside else ", outside)")
        )
    return Row(
        "the user's card (with the car's wheel forces): true critical speed and the answer, km/h",
        f"{len(CARD)} of {len(CARD)} within 3 % and their 90 % interval",
        f"{right} of {len(words)}: " + "; ".join(words),
        right == len(words) == len(CARD),
    )


ORDINARY = (
    ("nothing", "nothing known, not even that there is a trailer"),
    ("attached", "nothing known but that there is a trailer (an empty `[trailer]`)"),
)


def of_ordinary(f: dict[str, Any], words: str) -> Row:
    """Five minutes at three speeds."""
    return Row(
        f"{f['drives']} ordinary drives of five minutes at three speeds, production sensors, "
        f"{words}: critical speed",
        "<= 10 %, 80 to 97 % hold, reported in each",
        limits(f) if f["reported"] else "reported in none",
        bool(f["reported"] == f["drives"] and held(f, 10.0)),
    )


def of_presence(found: dict[str, Any]) -> Row:
    """A minute with or without a trailer."""
    there, alone = found["with a trailer"], found["alone"]
    each = found["drives_of_each"]
    return Row(
        f"trailer or none after 60 s with {found['swerves']} swerves, {each} drives of each",
        "all right",
        f"with a trailer: {there['there']} there, {there['undecided']} undecided, {there['none']} "
        f"none (false); alone: {alone['none']} none, {alone['undecided']} undecided, "
        f"{alone['there']} there (false)",
        there["there"] == alone["none"] == each,
    )


def of_pairs(found: Sequence[Pair], which: str) -> Iterator[Row]:
    """The ECU's memory: another trailer, the same one, none."""
    count = trailer_swap.counted(found)
    other, same, alone, first = (count[k] for k in ("other", "same", "alone", "first"))
    yield Row(
        f"a swapped trailer noticed, {len(found)} pairs {which}, drives of three minutes through "
        "`swaywatchd --remember`",
        "all",
        f"noticed {other['another']}, undecided {other['unknown'] + other['new']}, false "
        f'{other["same"] + other["no trailer"]} ({other["same"]} "the same", '
        f'{other["no trailer"]} "no trailer")',
        other["another"] == len(found),
    )
    yield Row(
        "the same trailer known again, in these pairs",
        "all",
        f"known {same['same']}, undecided {same['unknown'] + same['new']}, false "
        f'{same["another"] + same["no trailer"]} ({same["another"]} "another", '
        f'{same["no trailer"]} "no trailer")',
        same["same"] == len(found),
    )
    yield Row(
        "no trailer, in these pairs; the first drive of each (a trailer, none remembered)",
        "all right",
        f'alone: {alone["no trailer"]} "no trailer", {len(found) - alone["no trailer"]} else; '
        f'first: {first["new"]} "new", {first["no trailer"]} "no trailer" (false), '
        f"{first['unknown']} undecided",
        alone["no trailer"] == first["new"] == len(found),
    )


def of_warnings(found: dict[str, Any]) -> Iterator[Row]:
    """The car's own sensors beside the full set, on the same drives."""
    full, own = found["all sensors"], found["own"]
    for name in ("median", "95 %"):
        ratio = own[name] / full[name] if full[name] > 0.0 else float("inf")
        yield Row(
            f"warning campaign, {own['unstable']} unstable drives: delay, {name}, over that of the "
            "full set",
            "<= 1.3",
            f"{ratio:.1f} ({own[name]:.1f} and {full[name]:.1f} oscillations)",
            ratio <= 1.3,
        )
    yield Row(
        f"warning campaign: missed; false in {own['hours']:.1f} h",
        "0; 0 in 200 h",
        f"{own['missed']} missed (full set {full['missed']}), {own['false']} false",
        None if own["missed"] == own["false"] == 0 and own["hours"] < 200.0
        else own["missed"] == own["false"] == 0,
    )  # fmt: skip


def of_solo(root: Path) -> Iterator[Row]:
    """Real cars without a trailer."""
    for car in ("infiniti_g35", "ferrari_250lm"):
        if not (root / "real" / car).is_dir():
            yield Row(f"{car} (solo, real)", '"none" in each run', "no recordings here", None)
            continue
        said = car_sensors.solo(root / "real" / car, ROLES / f"{car}.toml")
        right = sum(words.startswith("none,") for words in said.values())
        yield Row(
            f"{car} (solo, real): no trailer with its certainty, nothing else",
            '"none" in each run',
            f"{right} of {len(said)}: "
            + "; ".join(f"{name} {words}" for name, words in said.items()),
            right == len(said),
        )


ELSEWHERE = (
    Row("diagnosis, tiers D and E of road", "aims of the road issue",
        "limits.md, random combinations", None),
    Row("ECU images within their budgets, identical on all targets", "yes",
        "make firmware-test", None),
    Row("swaywatchd hears only a production-style bus through the map", "yes",
        "tests/hil/test_foreign.py, make hil", None),
)  # fmt: skip


def shown(args: argparse.Namespace) -> list[Row]:
    """Every row."""
    rows: list[Row] = []

    def add(*more: Row) -> None:
        for row in more:
            rows.append(row)
            print(f"{row.line}: {row.figure}", file=sys.stderr, flush=True)

    root = args.recordings
    if (root / "practice").is_dir() and (root / "road").is_dir():
        add(*of_recordings(car_sensors.recordings(root)))
    else:
        add(Row("recordings, the user's card", "-", "no recordings here", None))
    add(*of_solo(root))
    if args.presence:
        add(*(of_presence(car_sensors.presence(args.presence, swerves)) for swerves in (2, 0)))
    if args.pairs:
        for most, which in (
            (trailer_swap.SWAYING_KMH, "whose critical speeds are 100 to 180 km/h"),
            (float("inf"), "of any critical speed above 100 km/h"),
        ):
            add(*of_pairs(trailer_swap.pairs(args.pairs, most), which))
    if args.drives:
        add(*(of_ordinary(car_sensors.ordinary(args.drives, how), w) for how, w in ORDINARY))
    if args.warnings:
        add(*of_warnings(car_sensors.warnings(args.warnings, args.hours)))
    add(*ELSEWHERE)
    return rows


def table(rows: Sequence[Row]) -> list[str]:
    """Markdown."""
    words = {True: "yes", False: "**no**", None: "not shown here"}
    met = sum(row.shown is True for row in rows)
    return [
        f'**`make bench-car`**: issue 15, "It must show", line by line; {met} of {len(rows)} met',
        "",
        "| line | aim | today | met |",
        "|---|---|---|---|",
        *(f"| {r.line} | {r.aim} | {r.figure} | {words[r.shown]} |" for r in rows),
    ]


def main() -> int:
    """Write the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--recordings", type=Path, required=True)
    parser.add_argument("--presence", type=int, default=200, help="drives of each (200)")
    parser.add_argument("--pairs", type=int, default=20, help="of trailers (20)")
    parser.add_argument("--drives", type=int, default=60, help="of five minutes (60)")
    parser.add_argument("--warnings", type=int, default=40, help="drives of each kind (40)")
    parser.add_argument("--hours", type=float, default=2.0, help="of ordinary driving (2)")
    parser.add_argument("--report", type=Path, required=True)
    args = parser.parse_args()
    return written(table(shown(args)), args.report)


if __name__ == "__main__":
    raise SystemExit(main())
