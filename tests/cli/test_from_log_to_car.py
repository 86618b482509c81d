"""The five commands from a log to a tuned car, as a person types them, on a terminal."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

import popsteer
from popsteer.lab.sweep import rows
from tests.cli import command

pytest.importorskip("optuna")
pytest.importorskip("rosbags")
pytest.importorskip("scipy")
pytestmark = pytest.mark.skipif(os.name != "posix", reason="needs a POSIX shell and a terminal")

SCRIPT = Path(__file__).parents[2] / "examples" / "from_log_to_car.sh"
SHORT = {"SECONDS_DRIVEN": "60", "TRIALS": "4", "RUNS": "16"}


def _on_terminal(folder: Path, columns: int) -> tuple[int, str]:
    """Run the script on a terminal of so many columns; its status and what it shows."""
    reading, writing = os.openpty()
    path = os.pathsep.join([str(Path(command.script()).parent), os.environ["PATH"]])
    environment = {**os.environ, **SHORT, "PATH": path, "PYTHON": sys.executable}
    environment |= {"COLUMNS": str(columns), "LINES": "40", "TERM": "xterm"}
    with subprocess.Popen(
        ["sh", str(SCRIPT), str(folder)],
        stdout=writing,
        stderr=subprocess.PIPE,
        env=environment,
    ) as process:
        os.close(writing)
        sent = command.read_terminal(reading)
        assert process.stderr is not None
        assert process.stderr.read() == b""
    os.close(reading)
    plain = re.sub(rb"\x1b\[[0-9;?]*[A-Za-z]", b"", sent)
    return process.returncode, plain.decode().replace("\r\n", "\n")


def test_five_commands_lead_from_a_log_to_a_car_that_stays_on_its_course(tmp_path: Path) -> None:
    status, said = _on_terminal(tmp_path, 80)
    assert status == 0, said
    shown = [line for line in said.splitlines() if not line.startswith(("$", "Written", "The "))]
    assert max(map(len, shown)) <= 80
    assert "…" not in said
    commands = re.findall(r"^\$ popsteer (\w+)", said, re.MULTILINE)
    assert commands == ["identify", "plan", "tune", "sweep", "replay"]

    car = popsteer.Vehicle.load(tmp_path / "car.toml")
    assert car.turning_wheelbase == pytest.approx(2.85, abs=0.03)
    assert car.dead_time + car.steer_lag == pytest.approx(0.25, abs=0.01)
    popsteer.PreviewPopParams.load(tmp_path / "tuned.toml")
    # The sweep drives the planned speeds, and the car that was identified.
    job, driven = rows.read(tmp_path / "sweep.parquet")
    assert job.given == car
    course = popsteer.Path.from_csv(tmp_path / "course.csv")
    assert course.speed is not None
    assert max(row["mean_speed"] for row in driven) < course.speed.max()
    assert all(row["success"] for row in driven)
    for name in ("car", "course", "tuned", "sweep", "replay/replay"):
        assert (tmp_path / f"{name}.png").stat().st_size > 10_000
