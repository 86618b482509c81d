"""What commands write into files, column by column, as it was last looked at.

    python -m tests.values.test_recorded_files

writes `recorded_files.json` anew; what changed in it is to be looked at.
"""

from __future__ import annotations

import contextlib
import csv
import io
import json
import os
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from popsteer.cli import main
from tests.values import tables as documents
from tests.values.test_recorded_commands import _blank, _write

pytest.importorskip("scipy")
pytest.importorskip("optuna")

__all__ = ["_blank"]

RECORDED = Path(__file__).with_name("recorded_files.json")
CLOSE = 2e-4
"""What solvers of different versions may differ by, as a share."""
COMMANDS = {
    "compare": "compare --controllers stanley,preview-pop --waypoints bends.csv --constant-speed 3"
    " --start-offset 0.4 --plant kinematic-bicycle --out out",
    "compare backwards": "compare --controllers pop --waypoints turn.csv --plant kinematic-bicycle"
    " --out out",
    "several": "compare --controllers pop,pid --waypoints bends.csv --constant-speed 4 --step-time"
    " --plants carla-identified,kinematic-bicycle --out out",
    "suite": "suite --controllers stanley --scenarios slalom --conditions noise,loss --out out",
    "stability": "stability --controllers pop,stanley --speeds 4,9 --vehicle carla-identified"
    " --out out",
    "replay": "replay drive.csv --controllers stanley,pop --set-vehicle wheelbase=2.7 --out out",
    "sweep": "sweep --controller stanley --waypoints bends.csv --runs 6 --seed 2 --workers 1"
    " --constant-speed 4 --out out/rows.csv",
    "plan": "plan bends.csv --set max_lateral_acceleration=2 --out out/course.csv",
    "tune": "tune --controller pop --waypoints bends.csv --cars 1 --trials 4 --seed 3"
    " --constant-speed 4 --vary steer_lag=uniform(0.1,0.4) --out out/tuned.toml",
    "identify": "identify long.csv --set-vehicle wheelbase=2.7 --set-vehicle rear_axle=0"
    " --out out/car.toml",
    "tracks": "tracks --out out",
}
# What differs from machine to machine, and from version to version.
LEFT_OUT = {"version", "versions", "machine", "popsteer", "python", "platform", "command"}
LEFT_OUT |= {"step_times", "step_time"}


def _column(values: list[str]) -> Any:
    """Say a column in few numbers, or words; places count, so that no two rows can change."""
    try:
        numbers = np.array([float(each) if each else np.nan for each in values])
    except ValueError:
        return sorted(set(values))[:12]
    weights = 1.0 + 0.1 * (np.arange(len(numbers)) % 7)
    known = numbers[np.isfinite(numbers)]
    if not len(known):
        return [len(numbers), 0]
    weighted = float(np.nanmean(np.where(np.isfinite(numbers), weights * numbers, np.nan)))
    ends = (float(known[0]), float(known[-1]), float(known.min()), float(known.max()))
    return [len(numbers), len(known), *(documents.plain(each) for each in (*ends, weighted))]


def _short(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _short(each) for key, each in value.items() if key not in LEFT_OUT}
    if isinstance(value, list) and len(value) > 8 and not isinstance(value[0], dict | list):
        return _column(["" if each is None else str(each) for each in value])
    return [_short(each) for each in value] if isinstance(value, list) else documents.plain(value)


def _rough(value: Any) -> Any:
    """Leave out the digits of a fit in which solvers differ."""
    if isinstance(value, dict):
        return {key: _rough(each) for key, each in value.items()}
    if isinstance(value, list):
        return [_rough(each) for each in value]
    return round(value, 3) if isinstance(value, float) else value


def _read(file: Path) -> Any:
    text = file.read_text(encoding="utf-8")
    if file.suffix == ".json":
        found = _short(json.loads(text))
        return _rough(found) if file.name == "car.json" else found
    if file.suffix == ".toml":
        pairs = [line.split(" = ") for line in text.splitlines() if " = " in line]
        known = [(name, value) for name, value in pairs if not name.startswith("#")]
        return {name: _rough(float(x)) if x.lstrip("-")[0].isdigit() else x for name, x in known}
    head, *rows = csv.reader(line for line in text.splitlines() if not line.startswith("#"))
    columns = zip(*rows, strict=True)
    named = dict(zip(head, columns, strict=True))
    return {name: _column(list(each)) for name, each in named.items() if name not in LEFT_OUT}


def _write_drive(file: Path) -> None:
    """Write a drive of bends at several speeds, with steering that comes 0.15 s late."""
    t = 0.05 * np.arange(600)
    speed = 6.0 + 2.5 * np.sin(0.25 * t)
    steer = 0.1 * np.sin(0.7 * t) + 0.04 * np.sign(np.sin(1.3 * t))
    wheel = np.interp(t - 0.15, t, steer)
    yaw = np.cumsum(0.05 * speed * np.tan(wheel) / 2.7)
    noise = np.random.default_rng(5).normal(0.0, 0.002, 600)
    at = np.cumsum(0.05 * speed * np.stack((np.cos(yaw), np.sin(yaw))), axis=1)
    rows = np.column_stack((t, *at, yaw + noise, speed, steer)).round(5).tolist()
    lines = [",".join(map(str, row)) for row in rows]
    file.write_text("\n".join(["t,x,y,yaw,speed,steer", *lines]) + "\n")


def _written(command: str) -> dict[str, Any]:
    """Run a command; give what it wrote, by file."""
    here = Path.cwd()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        _write(folder)
        _write_drive(folder / "long.csv")
        os.chdir(folder)
        try:
            err = io.StringIO()
            quiet = contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(err)
            with quiet[0], quiet[1], pytest.raises(SystemExit) as end:
                main(command.split())
            assert end.value.code == 0, err.getvalue()
            files = sorted(folder.glob("out/**/*"))
            return {
                str(file.relative_to(folder / "out")): _read(file)
                for file in files
                if file.suffix in (".csv", ".json", ".toml")
            }
        finally:
            os.chdir(here)


@pytest.mark.usefixtures("_blank", "_no_figures")
def test_commands_write_what_they_wrote() -> None:
    recorded = json.loads(RECORDED.read_text(encoding="utf-8"))
    for name, command in COMMANDS.items():
        assert documents.differences(_written(command), recorded[name], close=CLOSE) == [], name


@pytest.fixture
def _no_figures(monkeypatch: pytest.MonkeyPatch) -> None:
    """Those of stability take seconds to compute."""
    from popsteer.lab.stability import figures

    monkeypatch.setattr(figures, "stability_figures", lambda *_: {})


if __name__ == "__main__":
    from matplotlib.figure import Figure

    from popsteer.lab.stability import figures

    figures.stability_figures = lambda *_: {}
    Figure.savefig = lambda self, stream, **_: stream.write(b"blank")  # type: ignore[method-assign]
    found = {name: _written(command) for name, command in COMMANDS.items()}
    text = json.dumps(found, indent=0, ensure_ascii=False)
    RECORDED.write_text(text + "\n", encoding="utf-8")
