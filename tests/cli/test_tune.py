"""``popsteer tune``: a tuning that other commands take."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pytest

import popsteer
from tests.cli import command
from tests.helpers import looped

if TYPE_CHECKING:
    from pathlib import Path

pytest.importorskip("optuna")
pytest.importorskip("scipy")

SHORT = ("--controller", "pop", "--tracks", "slalom", "--cars", "1", "--trials", "6")


@pytest.mark.usefixtures("_blank_figures")
def test_tune_writes_what_every_command_takes(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    out = tmp_path / "new" / "tuned.toml"
    search = ("--search", "lookahead_gain=uniform(0,0.1)", "--effort-limit", "2")
    outcome = command.call(
        capsys, "tune", *SHORT, *search, "--tracks", "racetrack", "--out", str(out)
    )
    assert (outcome.status, outcome.err) == (0, "")
    names = {f"tuned{dark}.{kind}" for dark in ("", "-dark") for kind in ("png", "svg")}
    names |= {"tuned.toml", "tuned.journal"}
    assert {file.name for file in out.parent.iterdir()} == names
    assert "slalom" in outcome.out
    assert "before" in outcome.out
    params = popsteer.PopParams.load(out)
    assert 0.0 <= params.lookahead_gain <= 0.1
    value = f"{params.lookahead_gain:.4g}"
    assert value in outcome.out
    for each in ("compare", "stability"):
        assert command.call(capsys, each, "--controllers", "pop", "--params", str(out)).status == 0


@looped(
    ("options", "said"),
    [
        (("--search", "lookahead=uniform(1,2)"), "unknown parameter of pop 'lookahead'"),
        (("--search", "min_lookahead"), "--search must be written NAME=DISTRIBUTION"),
        (("--trials", "0"), "--trials must be a count in"),
        (("--seconds", "-1"), "--seconds must be positive"),
        (("--effort-limit", "0"), "--effort-limit must be in (0, 1000]"),
        (("--out", "tuned.json"), "--out must be a file *.toml"),
        (("--controller", "mpc"), "unknown controller 'mpc'"),
        (("--storage", "foo://nowhere"), "foo://nowhere: no study can be opened there"),
        (("--storage", "/dev/null/journal"), "/dev/null"),
    ],
)
def test_tune_refuses_in_one_line(
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    options: tuple[str, ...],
    said: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    outcome = command.call(capsys, "tune", *SHORT, *options)
    assert (outcome.status, outcome.out) == (2, "")
    assert said in outcome.err
    assert outcome.err.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_params_of_a_controller_that_is_not_driven_are_refused(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    popsteer.PidParams().save(tmp_path / "tuned.toml")
    given = ("--controllers", "pop", "--params", str(tmp_path / "tuned.toml"))
    outcome = command.call(capsys, "compare", *given)
    assert (outcome.status, outcome.out) == (2, "")
    assert "tuned.toml with pid" in outcome.err


def test_tune_takes_the_same_pedals_with_and_without_shipped_tracks(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    found: list[object] = []

    def kept(problem: object, *_: object, **__: object) -> None:
        found.append(problem)
        raise popsteer.PopsteerError("enough")

    monkeypatch.setattr(popsteer.lab.tune, "run", kept)
    for name, head, speed in (("plain", "x,y", ""), ("planned", "x,y,speed", ",5")):
        rows = "".join(f"{x},0{speed}\n" for x in range(60))
        (tmp_path / f"{name}.csv").write_text(f"{head}\n{rows}")
    for file, kind in (("plain", "SpeedTrackerParams"), ("planned", "SpeedTrackerParams")):
        for tracks in ("slalom", "slalom,racetrack"):
            given = ("--waypoints", str(tmp_path / f"{file}.csv"), "--tracks", tracks)
            outcome = command.call(capsys, "tune", "--controller", "pop", *given)
            assert "enough" in outcome.err
            problem: Any = found.pop()
            assert [*problem.paths] == [*tracks.split(","), f"{file}.csv"]
            assert type(problem.longitudinal).__name__ == kind, (file, tracks)
