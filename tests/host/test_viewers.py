"""Formats of viewers and of MATLAB: round trips, foreign files, damaged ones; merged channels."""

from __future__ import annotations

import json
import re
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pyarrow.parquet as pq
import pytest
from conftest import DATA
from scipy.io import loadmat, savemat

from swaywatch.cli import main
from swaywatch.errors import RecordingError
from swaywatch.recording import Series, read_recording, write_recording

P01 = DATA / "practice" / "p01"


def series(count: int = 200, start_ns: int = 1_700_000_000_000_000_000) -> dict[str, Series]:
    time = start_ns + 10_000_000 * np.arange(count)
    return {
        "Yaw.Rate1": Series(time, np.sin(np.arange(count) / 9.0), "rad/s"),
        "Speed": Series(time, np.full(count, 27.3), "m/s"),
        "a signal with a name that is longer than 31": Series(time[::2], np.ones(count // 2), "N"),
    }


def analyzed(out: Path, recording: Path, signals: Path, *more: str) -> int:
    """``swaywatch analyze`` without a page."""
    toml = ["--vehicle", str(P01 / "vehicle.toml"), "--signals", str(signals / "signals.toml")]
    return main(["analyze", str(recording), *toml, "--no-report", "--out", str(out), *more])


@pytest.mark.parametrize("suffix", [".mat", ".mcap"])
def test_round_trip(tmp_path: Path, suffix: str) -> None:
    given = series()
    write_recording(tmp_path / f"x{suffix}", given)
    found = read_recording(tmp_path / f"x{suffix}").signals
    assert found is not None
    assert sorted(found) == sorted(given)
    for name, one in given.items():
        assert np.abs(found[name].time_ns - one.time_ns).max() <= 200
        np.testing.assert_array_equal(found[name].value, one.value)
        assert found[name].unit == one.unit


def write_bag(folder: Path, signals: dict[str, Series], storage: str) -> Path:
    """A ROS 2 bag by rosbags, a topic of std_msgs/Float64 for each signal; its data file."""
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_JAZZY)
    number = store.types["std_msgs/msg/Float64"]
    with Writer(folder, version=9, storage_plugin=StoragePlugin[storage]) as writer:
        for name, one in signals.items():
            topic = writer.add_connection(f"/{name}", number.__msgtype__, typestore=store)
            for time_ns, value in zip(one.time_ns, one.value, strict=True):
                data = store.serialize_cdr(number(float(value)), number.__msgtype__)
                writer.write(topic, int(time_ns), data)
    return next(p for p in folder.iterdir() if p.suffix in (".db3", ".mcap"))


def roles_toml(signals: dict[str, Series], prefix: str = "", suffix: str = "") -> str:
    """``signals.toml`` of a file whose signals have the names of the roles."""
    wheels = ("_fl", "_fr", "_rl", "_rr")
    positions = {"car_lateral_acceleration": -1.383, "trailer_lateral_acceleration": 0.0}

    def entry(name: str) -> str:
        quoted = f'"{prefix}{name}{suffix}"'
        unit = ""
        if suffix:  # a bag says no units
            unit = f', unit = "{signals[name].unit}"'
        where = f", position = {positions[name]}" if name in positions else ""
        return f"{{ signal = {quoted}{unit}{where} }}" if unit or where else quoted

    lines = [f"{name} = {entry(name)}" for name in signals if not name.endswith(wheels)]
    for force in ("wheel_lateral_force", "wheel_vertical_load"):
        lines.append(f"{force} = [{', '.join(entry(force + w) for w in wheels)}]")
    return "[signals]\n" + "\n".join(lines) + "\n"


def analysis(folder: Path) -> tuple[Any, list[dict[str, Any]]]:
    """Values of the summary, and every estimate, of an analysis of one recording."""
    values = json.loads((folder / "summary.json").read_text())["drives"][0]["values"]
    (estimates,) = folder.glob("estimates_*.parquet")
    return values, pq.read_table(estimates).to_pylist()


def test_analysis_is_the_same(tmp_path: Path) -> None:
    """A recording written as .mat, MCAP and ROS 2 bags is analysed to the same result, bit for bit.

    (A Parquet table of one clock has rounded stamps: nearly the same.)
    """
    found = {}
    roles: dict[str, Series] = {}
    for kind in (".parquet", ".mat", ".mcap"):
        merged = tmp_path / f"roles{kind}"
        assert analyzed(tmp_path / "first", P01 / "run1.blf", P01, "--merge", str(merged)) == 0
        signals = read_recording(merged).signals
        assert signals is not None
        roles = {n: s for n, s in signals.items() if not n.startswith("swaywatch.")}
        (tmp_path / "signals.toml").write_text(roles_toml(roles))
        assert analyzed(tmp_path / f"again{kind}", merged, tmp_path) == 0
        found[kind] = analysis(tmp_path / f"again{kind}")
    for storage in ("SQLITE3", "MCAP"):
        bag = write_bag(tmp_path / f"bag_{storage}", roles, storage)
        (tmp_path / "signals.toml").write_text(roles_toml(roles, "/", "/data"))
        assert analyzed(tmp_path / f"again_{storage}", bag, tmp_path) == 0
        found[storage] = analysis(tmp_path / f"again_{storage}")
    values, estimates = analysis(tmp_path / "first")
    assert len(estimates) > 100
    for name, value in found.pop(".parquet")[0].items():
        assert value["value"] == pytest.approx(values[name]["value"], rel=1e-4, abs=1e-6)
    for kind, (again, rows) in found.items():
        assert again == values, kind
        assert rows == estimates, kind


def test_a_bag_of_ros_messages(tmp_path: Path) -> None:
    """Nested fields, stamps of the header, a type of the user's own, lists left out."""
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    own = "my_msgs/msg/Hitch"
    store = get_typestore(Stores.ROS2_JAZZY)
    store.register(get_types_from_msg("float64 force_n\nuint8 state\nfloat64[3] rest\n", own))
    types = store.types
    time, header = types["builtin_interfaces/msg/Time"], types["std_msgs/msg/Header"]
    vector = types["geometry_msgs/msg/Vector3"]
    stamped = types["geometry_msgs/msg/Vector3Stamped"]
    for storage in ("SQLITE3", "MCAP"):
        folder = tmp_path / storage
        with Writer(folder, version=9, storage_plugin=StoragePlugin[storage]) as writer:
            motion = writer.add_connection("/imu", stamped.__msgtype__, typestore=store)
            hitch = writer.add_connection("/hitch", own, typestore=store)
            for k in range(50):
                at = time(sec=1_700_000_000, nanosec=10_000_000 * k)
                one = stamped(header(at, "car"), vector(0.0, 0.1 * k, -1.0))
                late = 1_700_000_000_030_000_000 + 10_000_000 * k
                writer.write(motion, late, store.serialize_cdr(one, stamped.__msgtype__))
                other = types[own](12.5 * k, 3, np.zeros(3))
                writer.write(hitch, late, store.serialize_cdr(other, own))
        bag = next(p for p in folder.iterdir() if p.suffix in (".db3", ".mcap"))
        found = read_recording(bag).signals
        assert found is not None
        assert sorted(found) == ["/hitch/force_n", "/hitch/state"] + [
            f"/imu/vector.{axis}" for axis in "xyz"
        ]
        assert found["/imu/vector.y"].time_ns[1] == 1_700_000_000_010_000_000  # of the stamp
        assert found["/hitch/force_n"].time_ns[0] == 1_700_000_000_030_000_000
        np.testing.assert_allclose(found["/imu/vector.y"].value, 0.1 * np.arange(50))


def test_a_damaged_bag_is_one_sentence(tmp_path: Path) -> None:
    path = write_bag(tmp_path / "bag", series(), "SQLITE3")
    data = bytearray(path.read_bytes())
    random = np.random.default_rng(1)
    damaged = tmp_path / "damaged.db3"
    for cut in (len(data) // 2, 60, 4096):
        damaged.write_bytes(data[:cut])
        with pytest.raises(RecordingError, match=r"damaged\.db3"):
            read_recording(damaged)
    for _ in range(40):
        changed = bytearray(data)
        changed[int(random.integers(len(data)))] ^= 1 << int(random.integers(8))
        damaged.write_bytes(changed)
        with suppress(RecordingError):  # what is damaged is named, or does not matter
            read_recording(damaged)


def test_mcap_of_others_reads_what_is_written(tmp_path: Path) -> None:
    """Schema, summary and checksums, by the format's own reader; in order of time."""
    from mcap.reader import make_reader

    path = tmp_path / "x.mcap"
    write_recording(path, series())
    with path.open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        summary = reader.get_summary()
        assert summary is not None
        assert summary.statistics.message_count == 200 + 100
        stamps = [message.log_time for _, _, message in reader.iter_messages()]
    assert stamps == sorted(stamps)
    for schema in summary.schemas.values():
        content = json.loads(schema.data)
        assert schema.encoding == "jsonschema"
        assert all(entry["unit"] for entry in content["properties"].values())


def test_a_sample_that_is_no_number_is_left_out(tmp_path: Path) -> None:
    """Messages of an MCAP file hold to their schema, which knows numbers only."""
    from mcap.reader import make_reader

    gaps = Series(np.arange(3) * 1_000_000, np.array([1.0, np.nan, np.inf]), "m/s")
    write_recording(tmp_path / "x.mcap", {"v": gaps, "w": replace(gaps, value=np.zeros(3))})
    with (tmp_path / "x.mcap").open("rb") as file:
        messages = [json.loads(m.data) for _, _, m in make_reader(file).iter_messages()]
    assert messages == [{"v": 1.0, "w": 0.0}, {"w": 0.0}, {"w": 0.0}]


def test_layouts_show_what_is_in_the_file(tmp_path: Path) -> None:
    """Every curve of Foxglove's and PlotJuggler's layout is a field of the MCAP file beside it."""
    from mcap.reader import make_reader

    merged = tmp_path / "merged.mcap"
    assert analyzed(tmp_path / "out", P01 / "run1.blf", P01, "--merge", str(merged)) == 0
    units = {}
    with merged.open("rb") as file:
        summary = make_reader(file).get_summary()
    assert summary is not None
    for channel in summary.channels.values():
        for name, entry in json.loads(summary.schemas[channel.schema_id].data)[
            "properties"
        ].items():
            units[channel.topic, name] = entry["unit"]

    layout = json.loads((tmp_path / "merged.foxglove.json").read_text())
    shown = []
    for plot in layout["configById"].values():
        paths = [re.fullmatch(r'([\w/]+)\."([^"]+)"', path["value"]) for path in plot["paths"]]
        fields = [(str(path[1]), str(path[2])) for path in paths if path]
        assert len(fields) == len(plot["paths"]) > 0
        (unit,) = {units[field] for field in fields}  # one unit a plot, that of its title
        assert unit == "1" or plot["title"].endswith(f"[{unit}]")
        shown.append(fields)
    places, tree = [], layout["layout"]
    while isinstance(tree, dict):
        places.append(tree["first"])
        tree = tree["second"]
    assert [*places, tree] == list(layout["configById"])
    assert len(shown) == 6

    root = ElementTree.parse(tmp_path / "merged.plotjuggler.xml").getroot()
    curves = [[curve.get("name") for curve in plot.iter("curve")] for plot in root.iter("plot")]
    assert curves == [[f"{topic}/{name}" for topic, name in fields] for fields in shown]
    (docks,) = root.iter("DockSplitter")
    assert int(str(docks.get("count"))) == len(curves) == len(str(docks.get("sizes")).split(";"))
    limits = [{k: float(v) for k, v in entry.items()} for entry in root.iter("range")]
    assert all(entry["right"] > 37.0 and entry["top"] > entry["bottom"] for entry in limits)


def test_merged_channels_open_in_asammdf(tmp_path: Path) -> None:
    from asammdf import MDF

    path = tmp_path / "merged.mf4"
    main(["analyze", str(P01 / "run1.blf"), str(P01 / "run2.blf"), "--vehicle",
          str(P01 / "vehicle.toml"), "--signals", str(P01 / "signals.toml"), "--no-report",
          "--out", str(tmp_path / "out"), "--merge", str(path)])  # fmt: skip
    with MDF(tmp_path / "merged_run1.mf4") as mdf:
        rate, estimate = mdf.get("car_yaw_rate"), mdf.get("swaywatch.frequency_hz")
        assert (rate.unit, estimate.unit) == ("rad/s", "Hz")
        assert "measured, YawRate1" in rate.comment
        assert "estimated" in estimate.comment
        assert estimate.timestamps[0] >= 0.0
        assert estimate.timestamps[-1] <= rate.timestamps[-1]
    assert (tmp_path / "merged_run2.mf4").exists()


def test_plain_vectors_of_a_script(tmp_path: Path) -> None:
    path = tmp_path / "script.mat"
    time = np.arange(0.0, 2.0, 0.01)
    savemat(path, {"t": time[:, None], "yaw": np.sin(time)[:, None], "mass": 1955.0})
    found = read_recording(path).signals
    assert found is not None
    assert list(found) == ["yaw"]
    assert len(found["yaw"].value) == len(time)
    savemat(path, {"t": time, "time": time, "yaw": time})
    with pytest.raises(RecordingError, match="several vectors of time"):
        read_recording(path)


def test_matlab_accepts_the_names(tmp_path: Path) -> None:
    path = tmp_path / "x.mat"
    write_recording(path, series())
    names = [name for name in loadmat(path) if not name.startswith("__")]
    assert all(name.isidentifier() and len(name) <= 31 for name in names)


@pytest.mark.parametrize("suffix", [".mat", ".mcap"])
def test_damage_is_one_sentence(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"x{suffix}"
    write_recording(path, series())
    data = bytearray(path.read_bytes())
    random = np.random.default_rng(1)
    for cut in (len(data) // 2, len(data) - 3, 60):
        path.write_bytes(data[:cut])
        with pytest.raises(RecordingError, match=path.name):
            read_recording(path)
    for _ in range(60):
        damaged = bytearray(data)
        damaged[int(random.integers(len(data)))] ^= 1 << int(random.integers(8))
        path.write_bytes(damaged)
        with suppress(RecordingError):  # what is damaged is named, or does not matter
            read_recording(path)


def test_matlab_7_3_is_named(tmp_path: Path) -> None:
    path = tmp_path / "x.mat"
    path.write_bytes(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(512, b"\0"))
    with pytest.raises(RecordingError, match=r"save it with save\(\.\.\., '-v7'\)"):
        read_recording(path)


def test_a_foreign_mcap_of_json(tmp_path: Path) -> None:
    from mcap.writer import Writer

    path = tmp_path / "x.mcap"
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start()
        channel = writer.register_channel("/imu", "json", 0)
        other = writer.register_channel("/image", "cdr", 0)
        for k in range(20):
            content = json.dumps({"rate": {"z": 0.1 * k}, "frame": "car"}).encode()
            writer.add_message(channel, 10_000_000 * k, content, 0)
            writer.add_message(other, 10_000_000 * k, b"\0", 0)
        writer.finish()
    found = read_recording(path)
    assert found.signals is not None
    assert list(found.signals) == ["/imu/rate.z"]
    assert "/image (cdr)" in found.notes[0]
