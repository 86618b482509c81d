"""The module computes what a native build of its crate computes, and nearly what Python does."""

from __future__ import annotations

import itertools
import json
import os
import struct
import subprocess
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import pytest

import popsteer
from popsteer import controllers, sim, tracks
from tests.helpers import ROOT
from tests.playground.built import ENGINE, program

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from tests.playground.built import Built

NODE = ROOT / "tests" / "playground" / "wasm_in_node.js"
METRICS, COLUMNS = 9, 17
CONTROLLERS = ("pop", "preview-pop", "preview-pop-unlimited", "pure-pursuit", "stanley", "pid")


class Settings(NamedTuple):
    """In the order of the module's settings."""

    wheelbase: float = 2.7
    steer_lag: float = 0.15
    dead_time: float = 0.15
    max_steer_rate: float = 0.4
    speed: float = 10.0
    slow_in_bends: float = 0.0
    start_offset: float = -2.0
    known: float = 1.0


def _line(call: str, numbers: Sequence[float]) -> str:
    return " ".join((call, *(struct.pack(">d", number).hex() for number in numbers)))


def _track(name: str) -> str:
    track = tracks.get(name)
    return _line("closed" if track.closed else "open", track.xy.ravel().tolist())


def _in_node(built: Built, lines: Sequence[str]) -> list[str]:
    command = [program("node"), str(NODE), str(ENGINE), str(built.module)]
    return _answers(command, lines)


def _natively(lines: Sequence[str]) -> list[str]:
    # Alone, so that no other crate turns the platform's mathematics on.
    build = ["build", "--locked", "--package", "popsteer-wasm", "--example", "native"]
    command = [program("cargo"), *build, "--message-format", "json-render-diagnostics"]
    # It is built from nothing, since others have that mathematics, and only to be run; in a folder
    # of its own, so that it waits for no other build.
    quick = {"CARGO_PROFILE_DEV_DEBUG": "0", "CARGO_INCREMENTAL": "0"}
    quick["CARGO_TARGET_DIR"] = str(ROOT / "target" / "native")
    done = subprocess.run(
        command, cwd=ROOT, env=os.environ | quick, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    made = (json.loads(message).get("executable") for message in done.stdout.splitlines())
    return _answers([next(file for file in made if file)], lines)


def _answers(command: Sequence[str], lines: Sequence[str]) -> list[str]:
    given = "\n".join(lines) + "\n"
    done = subprocess.run(command, input=given, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    answers = done.stdout.removesuffix("\n").split("\n")
    assert len(answers) == len(lines)
    return answers


def _numbers(answer: str) -> NDArray[np.float64]:
    return np.frombuffer(bytes.fromhex(answer.replace(" ", "")), dtype=">f8").astype(np.float64)


def _lines() -> list[str]:
    """Every track and every controller, each setting away from its default at least once."""
    others = (
        Settings(),
        Settings(0.33, 0.05, 0.05, 1.5, 3.0, 1.0, 0.25),
        Settings(6.0, 0.3, 0.0, 0.2, 14.0, 1.0, 3.0, 0.0),
        Settings(dead_time=0.32, speed=7.3, known=0.0),
    )
    lines = []
    for name, settings in zip(tracks.names(), itertools.cycle(others), strict=False):
        lines.append(_track(name))
        lines += [_line(controller, settings) for controller in CONTROLLERS]
    bumpy = [20.0 * k + offset for k in range(12) for offset in (0.0, 30.0 * (-1) ** k - 20.0 * k)]
    lines.append(_line("draw", bumpy))
    lines += [_line(controller, Settings()) for controller in CONTROLLERS]
    lines.append(_line("draw", [50.0 * f(k / 9) for k in range(52) for f in (np.cos, np.sin)]))
    lines.append(_line("preview-pop", Settings()))
    # Refusals, and that it works afterwards.
    lines.append(_line("open", [1.0, 2.0]))
    lines.append(_line("draw", [1.0, float("nan")]))
    lines.append(_line("pop", Settings(wheelbase=1e-9)))
    lines.append(_line("pop", Settings()))
    return lines


def test_module_same_bits_as_native(built: Built) -> None:
    lines = _lines()
    answers = _in_node(built, lines)
    runs = [answer for answer in answers if len(answer) > 1000]
    assert len(runs) == len(tracks.names()) * 6 + 6 + 1 + 1 + 2  # drawn tracks are answered too
    assert answers[-4].startswith("a path needs at least 2 waypoints")
    assert answers[-3].startswith("y must be in")
    assert answers[-2].startswith("wheelbase must be in [0.001, 1000.0], got 1e-9")
    natively = _natively(lines)
    for line, answer, native in zip(lines, answers, natively, strict=True):
        assert answer == native, line[:60]


def _car(settings: Settings) -> popsteer.Vehicle:
    return sim.KinematicBicycle().vehicle.replace(
        max_steer=0.6,
        wheelbase=settings.wheelbase,
        steer_lag=settings.steer_lag,
        dead_time=settings.dead_time,
        max_steer_rate=settings.max_steer_rate,
    )


@pytest.mark.parametrize("name", ["racetrack", "figure-eight"])
def test_module_close_to_python(built: Built, name: str) -> None:
    """Python takes sines, tangents and exponentials from the platform, the module from libm."""
    # From 2 m aside such slow wheels make a PID oscillate (`too-fast`), where differences grow.
    settings = Settings(start_offset=-1.0)
    lines = [_track(name), *(_line(controller, settings) for controller in CONTROLLERS)]
    answers = _in_node(built, lines)[1:]
    track = tracks.get(name)
    path = popsteer.Path(track.xy, closed=track.closed)
    car = _car(settings)
    made: dict[str, controllers.Controller] = {
        "pop": popsteer.Pop(path, car),
        "preview-pop": popsteer.PreviewPop(path, car),
        "preview-pop-unlimited": popsteer.PreviewPop(path, car.replace(max_steer_rate=None)),
        "pure-pursuit": popsteer.PurePursuit(path, car),
        "stanley": popsteer.Stanley(path, car),
        "pid": popsteer.Pid(path, car),
    }
    for controller, answer in zip(CONTROLLERS, answers, strict=True):
        run = sim.run(
            made[controller],
            sim.KinematicBicycle(car),
            start=sim.closed_loop.default_start(path, settings.start_offset, car),
            constant_speed=settings.speed,
        )
        rows = _numbers(answer)[METRICS:].reshape(-1, COLUMNS)
        x, y = run.records["x"], run.records["y"]
        # Wheels that are slower than it plans for: its loop is unstable, and differences grow.
        steps = 500 if controller == "preview-pop-unlimited" else len(x)
        assert steps == len(rows) or steps == 500
        off = np.hypot(rows[:steps, 1] - x[:steps], rows[:steps, 2] - y[:steps])
        assert off.max() < 1e-10, controller


def test_module_slower_in_bends_drives_by_the_driver_of_python(built: Built) -> None:
    settings = Settings(slow_in_bends=1.0, speed=12.0)
    drivers: dict[str, Any] = {
        "preview-pop": popsteer.PreviewPopParams(),
        "stanley": popsteer.StanleyParams(),
    }
    lines = [_track("slalom"), *(_line(controller, settings) for controller in drivers)]
    answers = _in_node(built, lines)[1:]
    path = popsteer.Path(tracks.get("slalom").xy)
    car = _car(settings)
    start = sim.closed_loop.default_start(path, settings.start_offset, car)
    for answer, params in zip(answers, drivers.values(), strict=True):
        driver = popsteer.Driver(path, car.replace(max_speed=settings.speed), params)
        plant = sim.KinematicBicycle(car)
        run = sim.run(driver, plant, start=start, speed=float(driver.plan[0]))
        rows = _numbers(answer)[METRICS:].reshape(-1, COLUMNS)
        records = run.records
        assert len(rows) == len(records["x"]) > 300
        assert np.hypot(rows[:, 1] - records["x"], rows[:, 2] - records["y"]).max() < 1e-9
        assert np.ptp(records["speed"]) > 4.0


def test_module_that_fails_is_started_again(built: Built) -> None:
    script = f"""
        require({str(ENGINE)!r});
        const bytes = require("node:fs").readFileSync({str(built.module)!r});
        WebAssembly.instantiate(bytes, {{}}).then(({{ module, instance }}) => {{
            const failing = () => {{ throw new WebAssembly.RuntimeError("unreachable"); }};
            const exports = {{ ...instance.exports, playground_drive: failing }};
            const engine = new popsteer.Engine(module, {{ exports }});
            engine.setTrack([0, 0, 60, 0, 120, 0], false);
            const settings = {json.dumps(Settings()._asdict())};
            try {{
                engine.drive("pop", settings);
            }} catch (error) {{
                console.log(error instanceof popsteer.Refused, error.message);
            }}
            console.log(engine.drive("pop", settings).metrics.ending);
        }});
    """
    done = subprocess.run(
        [program("node"), "-e", script], capture_output=True, text=True, check=False
    )
    failed = "true the module failed (unreachable); it was started again"
    assert done.stdout.splitlines() == [failed, "0"], done.stderr
