"""What commands print of inputs that are written here, line by line as it was last looked at.

    python -m tests.values.test_recorded_commands

writes `recorded_commands.json` anew; what changed in it is to be looked at.
"""

from __future__ import annotations

import contextlib
import io
import json
import os
import tempfile
from pathlib import Path

import numpy as np
import pytest

from popsteer.cli import main

pytest.importorskip("scipy")
pytest.importorskip("typer")

RECORDED = Path(__file__).with_name("recorded_commands.json")
COMMANDS = {
    "tracks": "tracks",
    "plan": "plan bends.csv --set max_lateral_acceleration=3 --driving 0:3,20:1 --braking 0:2,9:4",
    "plan within": "plan bends.csv --keep-speeds --speed-limit 5:9:1.5 --speed-limit 20:30:2.5",
    "plan closed": "plan lap.csv --closed --set-vehicle max_steer=0.2 --set max_jerk=3",
    "plan smooth": "plan bends.csv --smooth 0.2 --out course.csv",
    "plan smooth backwards": "plan turn.csv --smooth 0.1",
    "replay": "replay drive.csv --controllers stanley,pop,pid --set-vehicle wheelbase=2.7",
    "replay on": "replay right.csv --controllers stanley --waypoints bends.csv --no-adapt"
    " --columns steer=wheel --unit steer=deg --unit speed=km/h",
    "stability": "stability --speeds 4,9 --set min_lookahead=4",
    "compare": "compare --controllers stanley,pop --waypoints bends.csv --start-offset 0.3"
    " --plant kinematic-bicycle --set-vehicle wheelbase=2.5 --speed 3",
    "compare planned": "compare --controllers pop --waypoints bends.csv --constant-speed 5"
    " --set-run time_limit=4 --no-adapt --preset default",
    "sweep": "sweep --controller stanley --waypoints bends.csv --runs 8 --seed 2 --deviation 0.535"
    " --vary start_offset=uniform(-1,1) --vary steer_lag=uniform(0.1,0.4) --workers 1",
    "tune": "tune --controller pop --waypoints bends.csv --cars 1 --trials 5 --seed 3"
    " --search min_lookahead=uniform(1,4) --vary steer_lag=uniform(0.1,0.4)",
    "new": "new my-car",
}


def _write(folder: Path) -> None:
    x = np.arange(0.0, 80.0, 1.0)
    y, speed = 4.0 * np.sin(x / 9.0), 3.0 + 0.02 * x
    rows = np.column_stack((x, y, speed)).round(3).tolist()
    (folder / "bends.csv").write_text("x,y,speed\n" + "".join(f"{a},{b},{c}\n" for a, b, c in rows))
    x = np.append(np.arange(0.0, 20.0, 0.5), np.arange(20.0, 8.0, -0.5))
    rows = np.column_stack((x, 0.01 * x * x, np.where(np.arange(len(x)) < 40, 2.0, -2.0)))
    (folder / "turn.csv").write_text(
        "x,y,speed\n" + "".join(f"{a},{b},{c}\n" for a, b, c in rows.tolist())
    )
    turn = np.linspace(0.0, 2.0 * np.pi, 40, endpoint=False)
    rows = np.column_stack((12.0 * np.cos(turn), 7.0 * np.sin(turn))).round(3).tolist()
    (folder / "lap.csv").write_text("".join(f"{a},{b}\n" for a, b in rows))
    t = 0.05 * np.arange(220)
    angle = 0.12 * np.sin(0.8 * t)
    yaw = np.cumsum(0.05 * 4.0 * np.tan(angle) / 2.7)
    at = np.cumsum(0.2 * np.stack((np.cos(yaw), np.sin(yaw))), axis=1)
    kept = (t < 6.0) | (t > 6.6)
    for name, heads, columns in (
        ("drive", "t,x,y,yaw,speed,steer", (t, *at, yaw, 4.0 + 0.0 * t, angle)),
        ("right", "t,x,y,yaw,speed,wheel", (t, *at, yaw, 14.4 + 0.0 * t, np.degrees(angle))),
    ):
        rows = np.column_stack(columns)[kept].round(5).tolist()
        lines = [",".join(map(str, row)) for row in rows]
        (folder / f"{name}.csv").write_text("\n".join([heads, *lines]) + "\n")


def _printed(command: str) -> list[str]:
    """Run a command in a folder with the inputs; give its lines, and those of files it wrote."""
    out, err = io.StringIO(), io.StringIO()
    here = Path.cwd()
    with tempfile.TemporaryDirectory() as name:
        _write(Path(name))
        os.chdir(name)
        try:
            with (
                contextlib.redirect_stdout(out),
                contextlib.redirect_stderr(err),
                contextlib.suppress(SystemExit),
            ):
                main(command.split())
        finally:
            os.chdir(here)
    lines = [*out.getvalue().splitlines(), *err.getvalue().splitlines()]
    return [" ".join(line.split()) for line in lines]


@pytest.mark.usefixtures("_blank")
def test_commands_print_what_they_printed() -> None:
    recorded = json.loads(RECORDED.read_text(encoding="utf-8"))
    for name, command in COMMANDS.items():
        assert _printed(command) == recorded[name], name


@pytest.fixture
def _blank(monkeypatch: pytest.MonkeyPatch) -> None:
    """Figures are made and not drawn, which takes seconds."""
    from matplotlib.figure import Figure

    monkeypatch.setattr(Figure, "draw_without_rendering", lambda self: None)
    monkeypatch.setattr(Figure, "savefig", lambda self, stream, **_: stream.write(b"blank"))


if __name__ == "__main__":
    found = {name: _printed(command) for name, command in COMMANDS.items()}
    RECORDED.write_text(json.dumps(found, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
