"""Each option of a command reaches what it is for, with its value, and changes nothing else."""

from __future__ import annotations

from dataclasses import fields
from typing import TYPE_CHECKING, Any

import pytest

import popsteer
from popsteer import lab
from tests.cli import command

if TYPE_CHECKING:
    from pathlib import Path

pytest.importorskip("scipy")
pytest.importorskip("optuna")

LOG = "t,x,y,yaw,speed,steer\n" + "".join(f"{0.1 * k},{0.5 * k},0,0,5,0.01\n" for k in range(200))
SHARED: dict[str, tuple[str, Any]] = {
    "--seed 3": ("seed", 3),
    "--constant-speed 3.5": ("constant_speed", 3.5),
    "--no-adapt": ("adapt", None),
    "--dt 0.02": ("settings", popsteer.sim.Settings(dt=0.02)),
    "--vehicle paper": ("vehicle", popsteer.vehicles.get("paper")),
}
OPTIONS: dict[str, dict[str, tuple[str, Any]]] = {
    "sweep --controller pop --track slalom": {
        **SHARED,
        "--runs 7": ("runs", 7),
        "--deviation 0.3": ("deviation", 0.3),
        "--start-offset -0.4": ("start_offset", -0.4),
        "--speed 2": ("speed", 2.0),
        "--set min_lookahead=3": ("params", popsteer.PopParams(min_lookahead=3.0)),
    },
    "tune --controller pop --tracks slalom": {
        **SHARED,
        "--cars 2": ("cars", 2),
        "--set min_lookahead=3": ("base", popsteer.PopParams(min_lookahead=3.0)),
        "--trials 9": ("trials", 9),
        "--seconds 8": ("seconds", 8.0),
        "--effort-limit 1.4": ("effort_limit", 1.4),
        "--storage kept.journal": ("storage", "kept.journal"),
    },
    "replay drive.csv --controllers pop": {
        "--no-adapt": ("adapt", None),
        "--set min_lookahead=3": ("tuning", {"pop": popsteer.PopParams(min_lookahead=3.0)}),
        "--set-vehicle wheelbase=2.2": (
            "vehicle",
            popsteer.vehicles.get("paper").replace(wheelbase=2.2),
        ),
        "--track circle": ("course", "circle"),
    },
    "matrix --controllers pop --plants kinematic-bicycle --tracks slalom": {
        "--no-adapt": ("adapt", None),
        "--dt 0.02": ("settings", popsteer.sim.Settings(dt=0.02)),
        "--constant-speed 3.5": ("constant_speed", 3.5),
        "--start-offset -0.4": ("start_offset", -0.4),
        "--speed 2": ("speed", 2.0),
    },
    "stability --controllers pop": {
        "--no-adapt": ("adapt", None),
        "--dt 0.02": ("dt", 0.02),
        "--set-plant dead_time=0.17": (
            "plant",
            popsteer.vehicles.get("paper").replace(dead_time=0.17),
        ),
    },
}


def test_every_option_reaches_what_it_is_for_and_nothing_else(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "drive.csv").write_text(LOG)
    found: dict[str, Any] = {}

    def kept_of(names: tuple[str, ...]) -> Any:
        def kept(first: Any, *rest: Any, **named: Any) -> None:
            found.clear()
            names_of = [each.name for each in fields(first)] if names[0] == "job" else []
            found.update({name: getattr(first, name) for name in names_of})
            found.update({**dict(zip(names[1:], rest, strict=False)), **named})
            raise popsteer.PopsteerError("enough")

        return kept

    monkeypatch.setattr(lab.sweep, "run", kept_of(("job", "out")))
    monkeypatch.setattr(lab.tune, "run", kept_of(("job", "storage")))
    monkeypatch.setattr(lab.replay, "run", kept_of(("log", "tuning", "vehicle")))
    monkeypatch.setattr(lab.matrix, "run", kept_of(("paths", "tuning", "plants")))
    monkeypatch.setattr(lab.stability, "run", kept_of(("tuning", "plant", "speeds")))

    def asked(*words: str) -> dict[str, Any]:
        outcome = command.call(capsys, *words)
        assert "enough" in outcome.err, outcome.err
        return {k: _plain(v) for k, v in found.items() if k not in ("progress", "out")}

    for whole, options in OPTIONS.items():
        usual = asked(*whole.split())
        for option, (name, value) in options.items():
            given = asked(*whole.split(), *option.split())
            assert given[name] == _plain(value) != usual[name], (whole, option)
            # A speed or a car that is given changes the pedals or what varies, too.
            others = {"longitudinal", "vary", "path", "plant", "label", "search", "base", "given"}
            rest = [k for k in usual if k != name and k not in others and given[k] != usual[k]]
            assert rest == [], (whole, option)


def _plain(value: Any) -> Any:
    if isinstance(value, popsteer.Path):
        return [value.x.tolist(), value.y.tolist()]
    if isinstance(value, dict):
        return {key: _plain(each) for key, each in value.items()}
    if hasattr(value, "as_dict"):
        return value.as_dict()
    return value if isinstance(value, int | float | str | None) else repr(type(value))
