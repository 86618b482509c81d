"""What holds each file of the core: its twin in the reference, or a test with another oracle."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import popsteer
from popsteer import _core, paper, reference, sim
from tests.helpers import ROOT
from tests.parity.laws import COUPLED, LATERAL, SPEED_PID

REFERENCE = ROOT / "python" / "popsteer" / "reference"
CORE = ROOT / "rust" / "core" / "src"

_TWINS = "python/popsteer/reference/"
_RUST = "rust/core/tests/"
HELD = {
    # The twin is the definition: the same operations, or the same in matrices.
    **{
        f"{name}.rs": f"{_TWINS}{name}.py"
        for name in (
            *("math", "bounds", "error", "geometry"),
            *("laws/law", "laws/pop", "laws/search", "laws/pure_pursuit", "laws/stanley"),
            *(f"laws/preview_pop/{part}" for part in ("approach", "cost_to_go", "horizon")),
            "laws/preview_pop/limited",
            *(f"path/{part}" for part in ("follow", "locate", "lookahead", "measure", "owned")),
            *(f"path/{part}" for part in ("preview", "projection", "relocalise", "resample")),
            "path/view",
            *("speed/coupled", "speed/pedals", "speed/pid"),
            *(f"vehicle/{part}" for part in ("bicycle", "delay", "estimate", "state", "wheels")),
        )
    },
    "params.rs": f"{_TWINS}error.py",
    "laws/params.rs": f"{_TWINS}laws/law.py",
    "path/best.rs": f"{_TWINS}path/relocalise.py",
    "path/place.rs": f"{_TWINS}path/follow.py",
    "laws/pid/mod.rs": f"{_TWINS}laws/pid.py",
    "laws/pid/error_buffer.rs": f"{_TWINS}laws/pid.py",
    "laws/preview_pop/mod.rs": f"{_TWINS}laws/preview_pop/__init__.py",
    "vehicle/gate.rs": "tests/trust/test_poses.py",
    "vehicle/mod.rs": f"{_TWINS}vehicle/__init__.py",
    "tracker/step.rs": f"{_TWINS}tracker.py",
    "tracker/command.rs": f"{_TWINS}tracker.py",
    "tracker/limit.rs": f"{_TWINS}tracker.py",
    "tracker/see.rs": f"{_TWINS}tracker.py",
    "tracker/seen.rs": f"{_TWINS}tracker.py",
    # Shortcuts, beside the plain loop that defines them.
    "path/jump.rs": "tests/parity/test_shortcuts.py",
    "path/nearby.rs": "rust/core/src/path/nearby/tests.rs",
    "path/boxes.rs": "rust/core/src/path/index/tests.rs",
    "path/index.rs": "rust/core/src/path/index/tests.rs",
    "laws/preview_pop/active_set.rs": f"{_RUST}limited.rs",
    # Equations written out by hand.
    "row.rs": "tests/unit/test_api_state.py",
    "status.rs": f"{_RUST}equations.rs",
    **{f"path/sound/{part}.rs": f"{_RUST}sound.rs" for part in ("mod", "chain", "ends")},
    **{f"path/sound/{part}.rs": f"{_RUST}sound.rs" for part in ("folds", "gears", "mends")},
    "path/sound/fit.rs": f"{_RUST}sound_ends.rs",
    "path/stop.rs": f"{_RUST}laps.rs",
    **{
        f"speed/law/{part}.rs": f"{_RUST}speed_equations.rs"
        for part in ("mod", "curve", "limits", "situation", "state")
    },
    "speed/law/stop.rs": f"{_RUST}stopping.rs",
    "speed/law/wait.rs": f"{_RUST}stopping.rs",
    "speed/jerk.rs": "tests/closed_loop/test_speed_law.py",
    "speed/tracker.rs": f"{_RUST}stopping.rs",
    "vehicle/drive.rs": "tests/closed_loop/test_speed_law.py",
    "speed/disturbance.rs": f"{_RUST}speed_equations.rs",
    "speed/bias.rs": f"{_RUST}speed_equations.rs",
    "speed/servo.rs": "tests/closed_loop/test_speed_servo.py",
    "speed/stops.rs": f"{_RUST}stopping.rs",
    "path/carry.rs": f"{_RUST}new_path.rs",
    "path/shape.rs": f"{_RUST}shape.rs",
    "laws/any.rs": f"{_RUST}driver.rs",
    **{
        f"driver/{part}.rs": f"{_RUST}driver.rs"
        for part in ("mod", "command", "safe_stop", "signals", "state", "step")
    },
    "tracker/hold.rs": f"{_RUST}tracker.rs",
    "tracker/intend.rs": f"{_RUST}new_path.rs",
    "tracker/monitor/mod.rs": f"{_RUST}monitor.rs",
    "tracker/monitor/state.rs": f"{_RUST}monitor.rs",
    "tracker/monitor/course.rs": f"{_RUST}faults.rs",
    "tracker/perceive.rs": f"{_RUST}late_poses.rs",
    "tracker/replan.rs": f"{_RUST}new_path.rs",
    "tracker/reported.rs": "tests/unit/test_refused.py",
    "tracker/state.rs": "tests/unit/test_api_state.py",
    "vehicle/fault.rs": f"{_RUST}faults.rs",
    "vehicle/cusum.rs": "rust/core/src/vehicle/cusum/tests.rs",
    "vehicle/noise.rs": "rust/core/src/vehicle/noise/tests.rs",
    "vehicle/past.rs": f"{_RUST}late_poses.rs",
    "vehicle/timed.rs": "rust/core/src/vehicle/tests.rs",
    # The textbook's solution: least squares over all measurements at once; numpy.
    "vehicle/kalman.rs": f"{_RUST}estimates.rs",
    "vehicle/estimator.rs": f"{_RUST}estimates.rs",
    "vehicle/estimator/driven.rs": f"{_RUST}estimates.rs",
    "speed/curvature.rs": f"{_RUST}planned_speeds.rs",
    "speed/limits.rs": "tests/unit/test_planning_numpy.py",
    "speed/defaults.rs": "tests/unit/test_planning.py",
    "speed/profile.rs": "tests/unit/test_planning_numpy.py",
}
"""Where each file of the core has its definition, or the test that holds it to one."""


def _files(folder: Path, suffix: str) -> set[str]:
    return {file.relative_to(folder).as_posix() for file in folder.rglob(f"*{suffix}")}


def test_each_file_of_the_core_is_held_by_its_twin_or_by_a_test() -> None:
    files = {
        file
        for file in _files(CORE, ".rs")
        # Modules that pass names on, and tests.
        if (Path(file).name not in ("lib.rs", "tests.rs", "fixtures.rs", "mod.rs") or file in HELD)
    }
    assert files == set(HELD)
    for file, holder in HELD.items():
        text = (ROOT / holder).read_text("utf-8")
        assert holder.startswith(_TWINS) or "fn test_" in text or "def test_" in text, file


def test_each_file_of_the_reference_has_its_twin_in_the_core() -> None:
    twins = {holder.removeprefix(_TWINS) for holder in HELD.values()}
    packages = {file for file in _files(REFERENCE, ".py") if file.endswith("__init__.py")}
    assert _files(REFERENCE, ".py") - packages <= twins


def test_params_and_values_have_the_same_fields() -> None:
    names = [law.params_name for law in (*LATERAL, COUPLED, SPEED_PID)]
    for name in (*names, "Vehicle"):
        ours = set(getattr(popsteer, name)().as_dict())
        assert len(ours) >= 2
        assert ours == {field.name for field in dataclasses.fields(getattr(reference, name))}, name


def test_controllers_remember_what_the_references_do() -> None:
    path = popsteer.Path([(0.0, 0.0), (9.0, 0.0)])
    for law in LATERAL:
        own: dict[str, Any] = getattr(popsteer, law.name)(path).state.law.as_dict()
        own |= own.pop("buffer", {})
        assert set(vars(getattr(reference, law.name).STATE())) <= set(own)
    ours = set(popsteer.SpeedPid().state.as_dict()) - {"controller"}
    assert ours == set(vars(reference.SpeedPidState()))


def test_public_names_are_sorted_and_all_of_the_extension() -> None:
    assert popsteer.__all__ == sorted(popsteer.__all__)
    assert len(set(popsteer.__all__)) == len(popsteer.__all__)
    exported = {name for name in dir(_core) if not name.startswith("_")} | {"__version__"}
    # The five laws and their parts alone are fifteen.
    assert len(exported) > 30
    # The batch below an adapter is that adapter's.
    assert exported - {"plants", "Episodes"} <= {*popsteer.__all__, *sim.__all__}
    for name in popsteer.__all__:
        assert getattr(popsteer, name) is not None


def test_reference_has_public_names_of_popsteer_and_its_own_tracker() -> None:
    assert reference.__all__ == sorted(reference.__all__)
    ours = {*popsteer.__all__, *paper.__all__, "Pedals", "Window", "Tracker", "TrackerState"}
    states = {f"{law.name}State" for law in LATERAL} | {"SpeedPidState"}
    assert set(reference.__all__) <= ours | states
    assert {*paper.__all__, *(law.name for law in LATERAL)} <= set(reference.__all__)
    compared = "".join(file.read_text("utf-8") for file in (ROOT / "tests/parity").glob("*.py"))
    laws = {f"{law.name}{part}" for law in LATERAL for part in ("", "Params", "State")}
    answers = {"Command", "Lookahead", "Pedals", "Projection", "Window", "SpeedPidState"}
    names = set(reference.__all__) - laws - answers
    assert not [name for name in names if f'"{name}' not in compared and name not in compared]
