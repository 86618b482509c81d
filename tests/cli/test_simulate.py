from __future__ import annotations

import json
from typing import TYPE_CHECKING

import pytest

from popsteer import laws, sim
from popsteer.report import figures
from tests.cli import command

if TYPE_CHECKING:
    from pathlib import Path

# A value other than the default for every parameter of every law.
CHANGED = {
    "alpha_by_arccos": "yes",
    "amplitude": "0.2",
    "buffer_length": "100",
    "candidate_count": "11",
    "cross_track_gain": "1.1",
    "deadband": "0.05",
    "grid_spacing": "0.02",
    "heading_behind": "True",
    "exact_lookahead": "false",
    "integral_with_dt": "false",
    "kd": "0.3",
    "ki": "0.02",
    "kp": "0.2",
    "lookahead_gain": "0.3",
    "lookahead_tolerance": "0.02",
    "lost_distance": "40",
    "max_steer": "0.9",
    "min_lookahead": "7",
    "reference_offset": "1.5",
    "search_distance": "8",
    "softening": "0.1",
    "speed_gain": "1.2",
    "steer_span": "0.1",
    "wheelbase": "2.9",
    "window_ahead": "25",
    "max_steer_rate": "0.9",
    "max_lateral_acceleration": "9",
    "horizon": "0.8",
    "heading_cost": "2.5",
    "steer_rate_cost": "0.4",
    "approach_angle": "0.3",
    "min_speed": "4",
    "smoothing_length": "3",
    "turn_learning_time": "0.5",
    "slip_learning_time": "2",
    "understeer": "0.001",
    "steer_lag": "0.15",
}


@pytest.fixture
def _no_figures(monkeypatch: pytest.MonkeyPatch) -> None:
    """Drawing takes longer than everything else, and is looked at elsewhere."""
    monkeypatch.setattr(figures, "render", lambda *arguments: {})


@pytest.mark.usefixtures("_no_figures")
@pytest.mark.parametrize("law", laws.names())
def test_simulate_with_every_parameter_set_drives_with_them(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, law: str
) -> None:
    out = tmp_path / "out"
    settings = [f"{name}={CHANGED[name]}" for name in laws.get(law).params().as_dict()]
    arguments = [part for setting in settings for part in ("--set", setting)]
    arguments += ["--set-run", "time_limit=2", "--out", str(out)]
    outcome = command.call(capsys, "simulate", "--controller", law, *arguments)
    assert outcome.status == 0
    metrics = json.loads((out / "metrics.json").read_text(encoding="utf-8"))
    params = metrics["controllers"][law]["params"]
    default = laws.get(law).params().as_dict()
    assert params.keys() == default.keys()
    # What the preset sets already may be what is set here.
    assert all(params[name] != default[name] for name in params)
    assert "with changes" in metrics["preset"]


def test_simulate_writes_the_same_files_as_compare(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    names = []
    for command_ in (
        ("compare", "--controllers", "stanley"),
        ("simulate", "--controller", "stanley"),
    ):
        out = tmp_path / command_[0]
        command.call(capsys, *command_, "--track", "straight", "--out", str(out))
        names.append(sorted(str(f.relative_to(out)) for f in out.rglob("*")))
        assert (out / "metrics.json").read_bytes() == (
            tmp_path / "compare" / "metrics.json"
        ).read_bytes()
    assert names[0] == names[1]


@pytest.mark.usefixtures("_no_figures")
def test_simulate_with_plant_parameters_moves_the_axles_too(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    out = tmp_path / "out"
    command.call(
        capsys,
        *("simulate", "--plant", "kinematic-bicycle", "--set-plant", "wheelbase=2.5"),
        *("--set-run", "time_limit=1", "--out", str(out)),
    )
    params = json.loads((out / "metrics.json").read_text("utf-8"))["controllers"]["pop"]["params"]
    assert (params["wheelbase"], params["reference_offset"]) == (2.5, 2.5)


def test_simulate_with_the_speed_pid_follows_the_reference_speeds(
    capsys: pytest.CaptureFixture[str],
) -> None:
    plain = command.call(capsys, "simulate")
    speed = command.call(
        capsys, "simulate", "--longitudinal", "speed-pid", "--set-longitudinal", "kp=0.8"
    )
    assert speed.status == 0
    assert plain.out != speed.out


def test_simulate_help_lists_every_parameter(capsys: pytest.CaptureFixture[str]) -> None:
    text = command.call(capsys, "simulate", "--help").out
    for law in laws.names():
        assert f"--controller {law}, parameters" in text
        for name in laws.get(law).params().as_dict():
            assert f"    {name} : " in text
    for plant in (sim.CarlaIdentified(), sim.KinematicBicycle(), sim.Settings()):
        for name in plant.as_dict():
            assert f"    {name} : " in text
