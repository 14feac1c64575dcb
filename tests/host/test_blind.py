"""Generated cases with a concealed cause: repeatable, complete, and the answer is apart."""

import json
import sys
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("mujoco")
cantools = pytest.importorskip("cantools")
can = pytest.importorskip("can")

BLIND = Path(__file__).parents[1] / "proof" / "blind"
sys.path.insert(0, str(BLIND))

import drives  # noqa: E402
import effects  # noqa: E402
import generate  # noqa: E402
import recorder  # noqa: E402
import unlisted  # noqa: E402

from swaywatch.models import physics  # noqa: E402
from swaywatch.models.multibody_vehicle import MORE, static_loads  # noqa: E402

OF_TEN = ("opened-twelfth", "opened-thirteenth", "opened-fourteenth")


@pytest.fixture(scope="module")
def case(tmp_path_factory):
    folder = tmp_path_factory.mktemp("blind")
    generate.generate(7, 0, folder / "cases", folder / "answers", 1)
    name = generate.make_case(7, 2, folder / "cases", folder / "answers")
    return folder, name


def frames(path: Path) -> list[tuple[int, bytes]]:
    with can.LogReader(str(path)) as reader:
        return [(m.arbitration_id, bytes(m.data)) for m in reader]


def test_case_has_all_files_and_no_answer_in_it(case):
    folder, name = case
    names = {p.name for p in (folder / "cases" / name).iterdir()}
    assert {p.split(".")[0] for p in names} == {"run1", "run2", "vehicle", "signals"}
    assert (folder / "answers" / name / "answer.json").exists()
    answer = json.loads((folder / "answers" / name / "answer.json").read_text())
    assert answer["effects"][0]["id"] in {f.__name__ for f in effects.PLANAR}
    assert list((folder / "answers" / name).glob("run3.*"))


def test_same_seed_same_recording(case, tmp_path):
    folder, name = case
    generate.generate(7, 0, tmp_path / "cases", tmp_path / "answers", 1)
    generate.make_case(7, 2, tmp_path / "cases", tmp_path / "answers")
    for run in ("run1", "run2"):
        (path,) = (folder / "cases" / name).glob(f"{run}.*")
        assert frames(path) == frames(tmp_path / "cases" / name / path.name)


def test_unlisted_kinds_are_in_one_set_each_and_in_no_library():
    names = [function.__name__ for kinds in unlisted.SETS.values() for function in kinds]
    assert sorted(names) == sorted(MORE)
    assert len(set(names)) == len(names)
    listed = {path.stem for path in Path(physics.__file__).parent.glob("*.py")}
    assert listed
    assert not listed & set(names)


@pytest.mark.parametrize("which", unlisted.SETS)
def test_unlisted_kinds_come_in_turn_and_say_where_they_are(which):
    kinds = unlisted.SETS[which]
    for index in range(2 * len(kinds)):
        (draw,) = generate.draw_case(5, index, which).draws
        assert draw.answer["id"] == kinds[index % len(kinds)].__name__
        assert draw.outside
        assert draw.answer["places"]
        assert draw.answer["variables"]
        assert 0.4 <= draw.strength <= 1.0


@pytest.mark.parametrize("index", [3, 15])
def test_a_wind_that_never_rests_is_no_instability(index, tmp_path, monkeypatch):
    """Driven as fast as the combination itself allows; the others as fast as they are stable."""
    asked = []
    monkeypatch.setattr(generate, "critical_speed", lambda plant: asked.append(plant) or 20.0)
    monkeypatch.setattr(generate, "make_runs", lambda case, plants, *_: asked.extend(plants) or {})
    generate.make_case(5, index, tmp_path / "cases", tmp_path / "answers", "opened-fifth")
    restless = index == 3
    assert asked[0] is asked[2 if restless else 1]
    (draw,) = generate.draw_case(5, index, "opened-fifth").draws
    assert (draw.answer["id"] == "wake_shedding") == restless


def test_liquid_in_two_tanks_is_part_of_the_trailer():
    """Mass and inertia of all that is in it are those of the vehicle that its user knows."""
    index = [kind.__name__ for kind in unlisted.SETS["opened-sixth"]].index("two_tanks")
    case = generate.draw_case(5, index, "opened-sixth")
    plant, healthy = case.plant(), case.healthy.trailer
    moves, at = plant.physics.slosh_mass_kg, plant.physics.slosh_position_m
    rest = plant.combination.trailer
    assert moves > 0.0
    assert rest.mass_kg == healthy.mass_kg
    inertia = rest.yaw_inertia_kgm2 + moves * at**2
    assert inertia == pytest.approx(healthy.yaw_inertia_kgm2)


def test_unlocked_slew_is_part_of_the_trailer():
    index = [kind.__name__ for kind in unlisted.SETS["opened-seventh"]].index("unlocked_slew")
    for turn in range(4):
        at = index + turn * len(unlisted.SETS["opened-seventh"])
        case = generate.draw_case(5, at, "opened-seventh")
        plant, healthy = case.plant(), case.healthy.trailer
        rest = plant.combination.trailer.yaw_inertia_kgm2
        assert rest > 0.0
        assert rest + plant.physics.more_size == pytest.approx(healthy.yaw_inertia_kgm2)


def test_loose_rack_is_part_of_the_car():
    """Mass, place of the COG, inertia and static loads are those of the car its user knows."""
    index = [kind.__name__ for kind in unlisted.SETS["opened-eighth"]].index("rear_rack")
    for turn in range(4):
        at = index + turn * len(unlisted.SETS["opened-eighth"])
        case = generate.draw_case(5, at, "opened-eighth")
        plant, car = case.plant(), case.healthy.car
        rest, mass = plant.combination.car, plant.physics.more_size
        assert rest.mass_kg + mass == pytest.approx(car.mass_kg)
        ahead = rest.hitch_to_cog_m - car.hitch_to_cog_m
        assert ahead > 0.0
        assert rest.mass_kg * ahead == pytest.approx(mass * car.hitch_to_cog_m)
        assert rest.front.to_cog_m - rest.rear.to_cog_m == pytest.approx(
            car.front.to_cog_m - car.rear.to_cog_m
        )
        inertia = rest.yaw_inertia_kgm2 + rest.mass_kg * ahead**2 + mass * car.hitch_to_cog_m**2
        assert inertia == pytest.approx(car.yaw_inertia_kgm2)
        loads = static_loads(plant.combination)
        assert loads[:2] == pytest.approx(static_loads(case.healthy)[:2])


def test_shares_of_the_eighth_set_leave_something():
    """Whatever is drawn, a trailer keeps mass, and tyres keep grip."""
    kinds = {kind.__name__: kind for kind in unlisted.SETS["opened-eighth"]}
    for name in ("leaking_load", "concrete_slabs", "worn_shoulders"):
        for strength in (0.4, 1.0):
            size = kinds[name](np.random.default_rng(1), strength).value
            assert 0.05 < abs(size) < 0.9


@pytest.mark.parametrize(
    ("which", "loads", "shares", "either_way"),
    [
        (
            "opened-ninth", {"slack_lashing"}, {"clay_tread"},
            {"spring_bars", "hub_drives", "angle_vectoring", "levelling_pump", "racked_frame"},
        ),
        (
            "opened-tenth", {"loosening_straps"}, {"snow_tracks", "seized_top_mount"},
            {
                "crosswind_assist", "link_steering", "broken_leaf", "hunting_vectoring",
                "cocked_overrun",
            },
        ),
        (
            "opened-eleventh", {"rocking_hull"}, {"rag_joint"},
            {"stepper_rear", "leaky_link", "bent_arm", "quick_rear", "curve_brake"},
        ),
        (
            "opened-twelfth", {"hanging_load"}, {"puddles", "subframe_rubber"},
            {"locker_corner", "bump_steer", "working_frame", "late_rear_steering"},
        ),
        (
            "opened-thirteenth", {"leaning_stack"}, set(),
            {"soft_tyre", "greasy_ball", "crooked_joint", "loose_hub", "broken_link"},
        ),
        (
            "opened-fourteenth", set(),
            {"bump_stop_grip", "loose_hands", "hopping_wheels", "slow_puncture"},
            {"worn_pad", "skew_joints"},
        ),
        (
            "opened-fifteenth", {"sliding_box"}, {"stop_overload", "wet_stretches"},
            {"rolled_under", "sticky_beam"},
        ),
        (
            "opened-sixteenth", set(), {"aged_tyres", "caster_lock"},
            {
                "camera_rear", "open_crack", "passing_lorry", "wallowing_tail", "braking_driver",
            },
        ),
    ],
)  # fmt: skip
def test_newer_sets_stay_within_what_can_be(which, loads, shares, either_way):
    """Shares leave something, loads are their size, and kinds with two signs have both."""
    kinds = {kind.__name__: kind for kind in unlisted.SETS[which]}
    assert len(kinds) == (10 if which in OF_TEN else 12)
    signs = {name: set() for name in kinds}
    for seed in range(12):
        for strength in (0.4, 1.0):
            for name, kind in kinds.items():
                drawn = kind(np.random.default_rng(seed), strength)
                signs[name].add(np.sign(drawn.value))
                physics = drawn.physics(generate.Physics())
                if name in loads:
                    assert physics.slosh_mass_kg == drawn.value <= 500.0
                if name == "slack_lashing":
                    assert 0.1 <= abs(physics.more_at) <= 0.4
                if name in ("soft_tyre", "rolled_under"):
                    assert 0.05 < abs(drawn.value) <= 0.9
                if name in shares:
                    assert 0.05 < drawn.value <= 0.9
    assert {name for name, found in signs.items() if found == {1.0, -1.0}} == either_way


def test_different_seeds_differ():
    kinds = [generate.draw_case(7, i).draws for i in range(12)]
    others = [generate.draw_case(8, i).draws for i in range(12)]
    assert [d[0].answer for d in kinds if d] != [d[0].answer for d in others if d]


def test_clean_cases_of_one_tier():
    """Nothing concealed, on springs, and no two combinations alike."""
    cases = [generate.draw_case(7, i, "F") for i in range(6)]
    assert all(c.kind == "clean" and not c.draws and c.known.sprung for c in cases)
    assert len({c.healthy.car.mass_kg for c in cases}) == 6


def test_frames_decode_to_what_was_measured():
    time = np.arange(0.0, 3.0, 0.002)
    truth = {
        "YawRate1": 5.0 * np.sin(4.0 * time),
        "LatAccRear1": np.cos(4.0 * time),
        "FyFL": 1000.0 * np.sin(4.0 * time),
        "FzFL": 4800.0 + 0.0 * time,
    }
    rng = np.random.default_rng(1)
    rows = recorder.measure(truth, time, {}, "run1", rng, 0.0)
    db = cantools.database.load_string(recorder.dbc_text(trailer=True), "dbc")
    found = {name: ([], []) for name in truth}
    for ns, frame, data in zip(rows.time_ns, rows.identifier, rows.data, strict=True):
        for name, value in db.decode_message(int(frame), bytes(data)).items():
            if name in found:
                found[name][0].append((ns - recorder.START_NS) * 1e-9)
                found[name][1].append(value)
    for name, (t, values) in found.items():
        error = np.array(values) - np.interp(t, time, truth[name])
        assert len(values) > 250
        step = next(s.scale for s in recorder.SIGNALS if s.name == name)
        assert np.std(error) < 0.5 * step  # an offset, and half a step of rounding


def test_delay_and_gain_are_what_they_say():
    time = np.arange(0.0, 20.0, 0.002)
    truth = {"YawRate2": 8.0 * np.sin(4.0 * time)}
    fault = {"YawRate2": {"delay": 0.05, "gain": 1.1}}
    rng = np.random.default_rng(2)
    rows = recorder.measure(truth, time, fault, "run1", rng, 0.0)
    hit = rows.identifier == 696
    t = (rows.time_ns[hit] - recorder.START_NS) * 1e-9
    raw = rows.data[hit, :2].copy().view(">i2")[:, 0]
    wanted = 1.1 * 8.0 * np.sin(4.0 * (t - 0.05))
    keep = t > 1.0
    error = raw[keep] * 0.01 - wanted[keep]
    assert np.std(error) < 0.01


@pytest.mark.parametrize("function", effects.PLANAR + effects.VERTICAL + effects.OUTSIDE)
def test_every_effect_changes_something(function):
    """Each effect changes plant, inputs, sensors or the user's file, and more when stronger."""
    rng = np.random.default_rng(3)
    weak, strong = function(np.random.default_rng(3), 0.0), function(rng, 1.0)
    assert weak.value != strong.value
    changed = (
        strong.physics(generate.Physics()) != generate.Physics()
        or strong.combination(drives.reference_combination()) != drives.reference_combination()
        or bool(strong.inputs("run1", drives.times(38.3)))
        or bool(strong.sensors)
        or bool(strong.user)
    )
    assert changed
