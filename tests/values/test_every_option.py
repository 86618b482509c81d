"""Every option of every command reaches what it is for, with its value, and changes nothing else.

A command is stopped where it calls the library. What it calls it with is taken apart, and compared
with what it calls it with if the option is left out. An option without a case fails.

    python -m tests.values.test_every_option

writes `recorded_options.json` anew, what each case changes; what changed in it is to be looked at.
"""

from __future__ import annotations

import contextlib
import io
import json
import math
import os
import tempfile
from dataclasses import fields, is_dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import popsteer
from popsteer import identification, lab, planning
from popsteer.cli import main
from tests.cli.test_help import WANTED

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

pytest.importorskip("scipy")
pytest.importorskip("optuna")
pytest.importorskip("pyproj")
pytest.importorskip("rosbags")

RECORDED = Path(__file__).with_name("recorded_options.json")
# A line of a command as it is without the option, then each option with a value, indented.
CASES = """
compare --controllers pop --waypoints way.csv
 --controllers stanley
 --preset paper
 --params pop.toml
 --set min_lookahead=3.5
 --set turn_time=7
 --set deviation_limit=0.3
 --waypoints fast.csv
 --columns y,x
 --closed
 --tracks circle
 --plants kinematic-bicycle
 --set-plant dead_time=0.17
 --vehicle car.toml
 --set-vehicle dead_time=0.17
 --no-adapt
 --start=1,2,0.5
 --start=1,2,0.5 --start-at front
 --start-offset 0.7
 --speed 2
 --constant-speed 3.5
 --longitudinal speed-pid
 --set-longitudinal kp=0.7
 --dt 0.02
 --set-run time_limit=60
compare --controllers pop
 --track slalom
paper
 --preset paper
 --waypoints way.csv
 --waypoints way.csv --columns y,x
suite --controllers pop --plants kinematic-bicycle
 --controllers stanley
 --plants suite-car
 --params pop.toml
 --no-adapt
 --scenarios slalom
 --conditions noise
 --set turn_time=7
 --set deviation_limit=0.3
compare --controllers pop --waypoints geo.csv
 --origin 46.9,8
sweep --controller pop --waypoints geo.csv
 --origin 46.9,8
tune --controller pop --waypoints geo.csv
 --origin 46.9,8
stability --controllers pop
 --controllers stanley
 --preset paper
 --params pop.toml
 --set min_lookahead=3.5
 --speeds 3,7.5
 --vehicle car.toml
 --vehicle car.toml --plant paper
 --set-vehicle dead_time=0.17
 --plant car.toml
 --set-plant dead_time=0.17
 --dt 0.02
plan way.csv
 --columns y,x
 --closed
 --vehicle car.toml
 --set-vehicle max_speed=7
 --set max_jerk=3
 --driving 0:3,20:1
 --braking 0:2,9:4
 --speed-limit 5.5:7.5:1.5
plan geo.csv
 --origin 46.9,8
plan fast.csv
 --smooth 0.2
 --keep-speeds
identify drive.csv
 --stops drive.csv
 --vehicle car.toml
 --set-vehicle wheelbase=2.4
 --columns steer=wheel
 --unit steer=deg
 --unit speed=km/h
 --course
 --topic odometry=/odom
identify far.csv
 --origin 46.9,8
replay far.csv --controllers pop
 --origin 46.9,8
replay drive.csv --controllers pop
 --vehicle car.toml
 --set-vehicle wheelbase=2.4
 --columns steer=wheel
 --unit steer=deg
 --topic odometry=/odom
 --controllers stanley
 --params pop.toml
 --preset paper
 --set min_lookahead=3.5
 --set turn_time=7
 --set deviation_limit=0.3
 --no-adapt
 --waypoints way.csv
 --waypoints way.csv --closed
 --waypoints way.csv --path-columns y,x
 --track circle
sweep --controller pop --waypoints way.csv
 --controller stanley
 --preset paper
 --params pop.toml
 --set min_lookahead=3.5
 --set turn_time=7
 --set deviation_limit=0.3
 --no-adapt
 --waypoints fast.csv
 --columns y,x
 --closed
 --plant kinematic-bicycle
 --set-plant dead_time=0.17
 --vehicle car.toml
 --set-vehicle dead_time=0.17
 --vary steer_lag=uniform(0.1,0.2)
 --distributions vary.toml
 --runs 7
 --seed 3
 --deviation 0.3
 --vary start_offset=none --start-offset -0.4
 --speed 2
 --constant-speed 3.5
 --set-longitudinal kp=0.7
 --dt 0.02
 --workers 3
 --dask tcp://far:8786
sweep --controller pop --waypoints fast.csv
 --longitudinal speed-pid
sweep --controller pop
 --track slalom
tune --controller pop --waypoints way.csv
 --controller stanley
 --preset paper
 --params pop.toml
 --set min_lookahead=3.5
 --set turn_time=7
 --set deviation_limit=0.3
 --no-adapt
 --search min_lookahead=uniform(1,4)
 --waypoints fast.csv
 --tracks circle
 --columns y,x
 --closed
 --plant kinematic-bicycle
 --set-plant dead_time=0.17
 --vehicle car.toml
 --set-vehicle dead_time=0.17
 --vary steer_lag=uniform(0.1,0.2)
 --distributions vary.toml
 --cars 2
 --seed 3
 --constant-speed 3.5
 --set-longitudinal kp=0.7
 --dt 0.02
 --trials 9
 --seconds 8
 --effort-limit 1.4
 --storage kept.journal
tune --controller pop --waypoints fast.csv
 --longitudinal speed-pid
ros2 --vehicle paper
 --set-vehicle wheelbase=2.4
 --vehicle car.toml
 --controller pop
 --controller pop --preset paper
 --controller pop --params pop.toml
 --set turn_time=7
 --set turn_time=7
 --set deviation_limit=0.3
 --set deviation_limit=0.3
 --no-adapt
 --max-speed 3
 --rate 40
 --stale 0.4
 --hold 0.1
 --keep-path 2
 --topic odometry=/odo
 --path-type trajectory
 --command-type twist
 --autoware
 --sim-time
 --closed
 --domain 7
 --localhost
 --timeout 4
 --ros-args --remap odom:=/gps
 --ros-args --remap __ns:=/car
 --ros-args --remap __node:=me
 --param rate:=40.0
 --param max_speed:=2.5
 --param use_sim_time:=true
 --params-file ros.yaml
record drive.mcap
 --topic odometry=/odo
 --path-type trajectory
 --command-type twist
 --autoware
 --seconds 6
 --domain 7
 --localhost
 --timeout 4
"""


def _parts(value: Any) -> Any:
    """Give what a value consists of, by name; a value that is one by itself stays."""
    if isinstance(value, popsteer.Path):
        return {name: getattr(value, name) for name in ("x", "y", "speed", "reverse", "closed")}
    if hasattr(value, "as_dict") and not isinstance(value, type):
        return {"kind": type(value).__name__, **value.as_dict()}
    if is_dataclass(value) and not isinstance(value, type):
        return {each.name: getattr(value, each.name) for each in fields(value)}
    return value.tolist() if isinstance(value, np.ndarray) else value


def _leaves(value: Any, at: str = "") -> Iterator[tuple[str, Any]]:
    """Take a value apart: what can be compared, by where it is."""
    value = _parts(value)
    if isinstance(value, list | tuple) and all(isinstance(x, int | float) for x in value):
        yield at, [_short(each) for each in value] if len(value) <= 8 else _summary(value)
    elif isinstance(value, dict | list | tuple):
        pairs = value.items() if isinstance(value, dict) else enumerate(value)
        for key, each in pairs:
            yield from _leaves(each, f"{at}.{key}" if at else str(key))
    elif isinstance(value, float):
        yield at, _short(value)
    else:
        yield at, value if value is None or isinstance(value, int | str) else str(value)


def _summary(values: Any) -> str:
    ends = f"{len(values)}: {_short(values[0])} to {_short(values[-1])}"
    return f"{ends}, sum {_short(math.fsum(values))}"


def _short(value: float) -> float | str:
    return round(value, 8) + 0.0 if math.isfinite(value) else str(value)


class Enough(popsteer.PopsteerError):
    """What a command is stopped by."""


CALLED: dict[str, Any] = {}


def _stop(*names: str) -> Callable[..., Any]:
    """A function that keeps what it is called with, and ends the command."""

    def kept(*given: Any, **named: Any) -> None:
        CALLED.update({**dict(zip(names, given, strict=False)), **named})
        CALLED.pop("progress", None)
        raise Enough("enough")

    return kept


def _participant(domain: int | None, **named: Any) -> Any:
    CALLED.update({"domain": domain, **named})
    return SimpleNamespace(domain=domain)


def _node(participant: Any, make: Any, options: Any, **_: Any) -> None:
    """Keep how the node runs, and the driver that it would make of a path."""
    made = make(popsteer.Path([(0.0, 0.0), (9.0, 0.0)]))
    CALLED.update(options=options, params=made.controller)
    CALLED.update(vehicle=made.vehicle, adapt=made.adapt, monitor=made.monitor)


# What is written, measured or read from files of an earlier run has its tests in tests/cli.
LEFT_OUT = {
    "--log-level",
    "--out",
    "--report",
    "--record",
    "--step-time",
    "--run",
}


def _files(folder: Path) -> None:
    (folder / "way.csv").write_text(
        "".join(
            f"{12.0 * math.sin(0.12 * k):.6f},{12.0 - 12.0 * math.cos(0.12 * k):.6f}\n"
            for k in range(40)
        )
    )
    (folder / "fast.csv").write_text("x,y,speed\n" + "".join(f"{x},0,4\n" for x in range(40)))
    log = "".join(f"{0.1 * k},{0.5 * k},0,0,5,0.01,0.2\n" for k in range(200))
    east = [8.0 + 1e-5 * k for k in range(200)]
    (folder / "geo.csv").write_text("lon,lat\n" + "".join(f"{x:.5f},47\n" for x in east))
    far = "".join(f"{0.1 * k},{x:.5f},47,0,7.6,0.01\n" for k, x in enumerate(east))
    (folder / "far.csv").write_text(f"t,lon,lat,yaw,speed,steer\n{far}")
    (folder / "drive.csv").write_text(f"t,x,y,yaw,speed,steer,wheel\n{log}")
    popsteer.Vehicle(wheelbase=2.2).save(folder / "car.toml")
    popsteer.PopParams(min_lookahead=3.3).save(folder / "pop.toml")
    (folder / "vary.toml").write_text('steer_lag = "uniform(0.1,0.3)"\n')
    (folder / "ros.yaml").write_text("popsteer:\n  ros__parameters:\n    rate: 25.0\n")


def _patched(monkeypatch: pytest.MonkeyPatch) -> None:
    from popsteer.adapters.ros2 import dds, node, pacing, recording
    from popsteer.identification import procedure

    runs = {
        lab.compare.paper: ("path", "preset"),
        lab.suite: ("tuning", "plants"),
        lab.stability: ("tuning", "plant", "speeds"),
        lab.replay: ("log", "tuning", "vehicle"),
        lab.sweep: ("job", "out"),
        lab.tune: ("job", "storage"),
    }
    for module, names in runs.items():
        monkeypatch.setattr(module, "run", _stop(*names))
    monkeypatch.setattr(lab.compare, "run_each", _stop("paths", "tuning", "plants"))
    monkeypatch.setattr(lab.sweep, "repeat", _stop("job", "run"))
    monkeypatch.setattr(planning, "speed_profile", _stop("path", "limits", "vehicle"))
    smooth = planning.smooth

    def smoothed(recorded: Any, *given: Any, **named: Any) -> popsteer.Path:
        CALLED["smooth"] = [given, named]
        return smooth(recorded, *given, **named)

    monkeypatch.setattr(planning, "smooth", smoothed)
    monkeypatch.setattr(identification, "identify", _stop("log", "vehicle"))
    monkeypatch.setattr(procedure, "identify", _stop("log", "vehicle"))
    reader = popsteer.logs.read

    def read(*given: Any, **named: Any) -> Any:
        CALLED["topics"] = named["topics"]
        return reader(*given, **{**named, "topics": {}})

    monkeypatch.setattr(popsteer.logs, "read", read)
    monkeypatch.setattr(dds, "Participant", _participant)
    monkeypatch.setattr(node, "Node", _node)
    monkeypatch.setattr(pacing, "spin", _stop())
    monkeypatch.setattr(recording, "Recording", contextlib.nullcontext)
    monkeypatch.setattr(pacing, "stop_on_signals", lambda: lambda: False)
    monkeypatch.setattr(recording, "tap", _stop("participant", "topics", "recording", "stopped"))


def _asked(words: str) -> dict[str, Any]:
    """Give what a command calls the library with, taken apart."""
    CALLED.clear()
    out, err = io.StringIO(), io.StringIO()
    with (
        contextlib.redirect_stdout(out),
        contextlib.redirect_stderr(err),
        contextlib.suppress(SystemExit),
    ):
        main(words.split())
    assert "enough" in err.getvalue(), (words, err.getvalue())
    left_out = ("participant", "stopped", "recording", "out", "console")
    return dict(_leaves({k: v for k, v in CALLED.items() if k not in left_out}))


def _changes() -> dict[str, dict[str, dict[str, Any]]]:
    """What each command calls the library with, and what each option changes of that."""
    found: dict[str, dict[str, dict[str, Any]]] = {}
    here = Path.cwd()
    with tempfile.TemporaryDirectory() as folder, pytest.MonkeyPatch.context() as patch:
        _files(Path(folder))
        _patched(patch)
        os.chdir(folder)
        try:
            for line in CASES.strip().splitlines():
                if not line.startswith(" "):
                    base, usual = line, _asked(line)
                    found[base] = {"": usual}
                    continue
                asked = _asked(base + line)
                names = sorted({*usual, *asked})
                changed = {k: asked.get(k) for k in names if asked.get(k) != usual.get(k)}
                assert changed, f"{base}{line} changes nothing"
                found[base][line.strip()] = changed
        finally:
            os.chdir(here)
    return found


def test_every_option_reaches_what_it_is_for_and_changes_nothing_else() -> None:
    recorded = json.loads(RECORDED.read_text(encoding="utf-8"))
    found = _changes()
    assert list(found) == list(recorded)
    for base, cases in found.items():
        for words, changed in cases.items():
            assert changed == recorded[base][words], (base, words)


def test_every_option_has_a_case() -> None:
    tried: dict[str, set[str]] = {name: set() for name in WANTED}
    for line in CASES.strip().splitlines():
        parts = line.split()
        if not line.startswith(" "):
            command = parts[0]
        tried[command] |= {part.split("=")[0] for part in parts if part.startswith("--")}
    untried = {f"{name} {each}" for name in WANTED for each in WANTED[name] - tried[name]}
    untried -= {"tracks --tracks", "params --vehicle"}  # tests/cli/test_help.py
    assert {each for each in untried if each.split()[1] not in LEFT_OUT} == set()


if __name__ == "__main__":
    text = json.dumps(_changes(), indent=0, ensure_ascii=False)
    RECORDED.write_text(text + "\n", encoding="utf-8")
