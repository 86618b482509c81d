from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import pytest

from popsteer import Vehicle, controllers, sim
from popsteer.lab.common import draw
from tests.cli import command

if TYPE_CHECKING:
    from pathlib import Path

POP = ("--controllers", "pop")


@pytest.fixture
def _no_figures(monkeypatch: pytest.MonkeyPatch) -> None:
    """Drawing takes longer than everything else, and is looked at elsewhere."""
    monkeypatch.setattr(draw, "drawn", lambda *arguments: {})


def _other(value: float) -> float:
    """Another value than a default; no preset has it."""
    if isinstance(value, bool):
        return not value
    return value - 10 if isinstance(value, int) else 0.7 * value


@pytest.mark.usefixtures("_no_figures")
@pytest.mark.parametrize("law", controllers.names())
def test_compare_with_every_parameter_set_drives_with_them(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, law: str
) -> None:
    out = tmp_path / "out"
    kind = controllers.get(law).params
    default = kind().resolved(sim.vehicle_of("carla-identified")).as_dict()
    settings = [f"{name}={_other(value)}" for name, value in default.items()]
    arguments = [part for setting in settings for part in ("--set", setting)]
    arguments += ["--set-run", "time_limit=2", "--out", str(out)]
    outcome = command.call(capsys, "compare", "--controllers", law, *arguments)
    assert outcome.status == 0
    metrics = json.loads((out / "metrics.json").read_text(encoding="utf-8"))
    params = metrics["controllers"][law]["params"]
    assert params.keys() == default.keys()
    assert all(params[name] != default[name] for name in params)
    assert metrics["controllers"][law]["tuning"] == "default with changes"


def _driven(capsys: pytest.CaptureFixture[str], out: Path, *arguments: str) -> dict[str, Any]:
    short = ("--set-run", "time_limit=20", "--out", str(out))
    outcome = command.call(capsys, "compare", *arguments, *short)
    assert (outcome.status, outcome.err) == (0, "")
    found: dict[str, Any] = json.loads((out / "metrics.json").read_text("utf-8"))
    return found


@pytest.mark.usefixtures("_no_figures")
def test_compare_with_fields_of_the_plants_vehicle_tells_the_controller_too(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    plant = ("--plant", "kinematic-bicycle", "--set-plant", "wheelbase=2.5")
    metrics = _driven(capsys, tmp_path, *POP, *plant, "--set-plant", "drive=5")
    car = sim.vehicle_of("kinematic-bicycle").replace(wheelbase=2.5)
    assert metrics["plant_vehicle"] == metrics["controllers"]["pop"]["vehicle"] == car.as_dict()


@pytest.mark.usefixtures("_no_figures")
def test_compare_tells_the_controller_what_it_is_to_believe(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    car = tmp_path / "car.toml"
    Vehicle(wheelbase=2.8, rear_axle=-1.4).save(car)
    plant = ("--plant", str(car), "--set-plant", "steer_lag=0.2")
    given = ("--vehicle", str(car), "--set-vehicle", "max_lateral_acceleration=none")
    metrics = _driven(capsys, tmp_path / "out", "--controllers", "preview-pop", *plant, *given)
    vehicle = Vehicle(wheelbase=2.8, rear_axle=-1.4)
    assert metrics["plant"] == "car.toml"
    assert metrics["plant_vehicle"] == vehicle.replace(steer_lag=0.2).as_dict()
    believed = vehicle.replace(max_lateral_acceleration=None)
    assert metrics["controllers"]["preview-pop"]["vehicle"] == believed.as_dict()


@pytest.mark.usefixtures("_no_figures")
def test_compare_sets_how_a_controller_adapts(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    wrong = ("--controllers", "preview-pop", "--set-vehicle", "steer_offset=0.02")
    errors = []
    for k, options in enumerate(((), ("--set", "turn_time=0"), ("--no-adapt",))):
        metrics = _driven(capsys, tmp_path / str(k), *wrong, *options)["controllers"]
        errors.append(metrics["preview-pop"]["settled_mean_abs_cross_track_error"])
    adapting, constant, nothing = errors
    assert adapting < 0.7 * constant
    # The offset is all that is wrong here, and it alone has a turn time.
    assert constant == nothing


def test_what_a_controller_takes_for_a_fault_is_set_by_name_in_each_command(
    capsys: pytest.CaptureFixture[str],
) -> None:
    strict = ("--set", "deviation_limit=0.001")
    on = ("--controllers", "pop", "--track", "slalom")
    assert "Fault" not in command.call(capsys, "compare", *on).out
    assert "Fault of POP: deviating" in command.call(capsys, "compare", *on, *strict).out
    suite: tuple[str, ...] = ("suite", *POP, "--plants", "suite-car")
    suite += ("--scenarios", "slalom", "--conditions", "as told")
    for options, failed in (((), 1), (strict, 0)):
        said = command.call(capsys, *suite, *options).out
        assert f"runs that succeed {failed} of 1" in " ".join(said.split())


@pytest.mark.parametrize(
    ("options", "named"),
    [
        (("compare", *POP, "--no-adapt", "--set", "turn_time=1"), "pop with --no-adapt"),
        (("stability", *POP, "--set", "turn_time=1"), "pop"),
        (("stability", *POP, "--set", "deviation_limit=1"), "pop"),
    ],
)
def test_parameter_that_would_do_nothing_is_refused(
    capsys: pytest.CaptureFixture[str], options: tuple[str, ...], named: str
) -> None:
    outcome = command.call(capsys, *options)
    assert (outcome.status, outcome.out) == (2, "")
    assert f"unknown parameter of {named} '" in outcome.err


def test_compare_of_a_baseline_takes_no_parameter_of_adapting(
    capsys: pytest.CaptureFixture[str],
) -> None:
    outcome = command.call(capsys, "compare", "--controllers", "mpc", "--set", "turn_time=2")
    assert (outcome.status, outcome.out) == (2, "")
    assert "unknown parameter of mpc 'turn_time'" in outcome.err


def test_compare_with_the_speed_pid_follows_the_reference_speeds(
    capsys: pytest.CaptureFixture[str],
) -> None:
    plain = command.call(capsys, "compare", "--controllers", "pop")
    speed = command.call(
        capsys,
        "compare",
        "--controllers",
        "pop",
        "--longitudinal",
        "speed-pid",
        "--set-longitudinal",
        "kp=0.8",
    )
    assert speed.status == 0
    assert plain.out != speed.out
