"""Code of one's own on a cluster whose machines have none: files, packages, later versions."""

from __future__ import annotations

import importlib
import sys
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import popsteer
from popsteer import own, plants
from popsteer.errors import PopsteerError
from popsteer.lab import sweep
from popsteer.lab.sweep import runs as workers

pytest.importorskip("distributed")

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

TURN = 0.05 * np.arange(60)
BEND = np.column_stack((20.0 * np.sin(TURN), 20.0 * (1.0 - np.cos(TURN))))
OWN = """
from {package}deep.gain import GAIN

class Own:
    def __init__(self, path, vehicle):
        self.path = path

    def step(self, x, y, yaw, speed, dt):
        from box.deep import late
        error = self.path.project(x, y).cross_track_error
        return -late.scaled(GAIN) * error
"""
CAR = """
import popsteer
from popsteer.plants import PlantState

class Car:
    name, reverses = "own", True

    def __init__(self):
        self.vehicle = popsteer.Vehicle(wheelbase=2.0)

    def reset(self, x, y, yaw, speed):
        self.state = PlantState(x, y, yaw, speed, 0.0, 0.0)

    def advance(self, steer, throttle, brake, dt, substeps, reverse):
        x, y, yaw, speed, *_ = self.state
        self.state = PlantState(x + speed * dt, y, yaw, speed, 0.0, steer)
        return self.state
"""
FILES = {
    "mine.py": OWN.format(package="box."),
    "box/__init__.py": "",
    "box/base.py": "ONE = 1.0\n",
    "box/outer.py": OWN.format(package="."),
    "box/deep/gain.py": "from ..base import ONE\n\nGAIN = 0.2 * ONE\n",
    "box/deep/late.py": "def scaled(gain):\n    return 0.5 * gain\n",
    "car/mine.py": CAR,
    "beside.py": "",
}


def _forget() -> None:
    for name in list(sys.modules):
        if name.partition(".")[0] in {"box", "beside"}:
            del sys.modules[name]
    own._module.cache_clear()


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """The folder of the code, in which modules are found."""
    monkeypatch.setattr(sys, "path", [str(tmp_path), *sys.path])
    monkeypatch.chdir(tmp_path)
    for name, text in FILES.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    yield tmp_path
    _forget()


@pytest.fixture(scope="module")
def cluster(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """A cluster that was begun elsewhere, before there was any code; its address."""
    from distributed import LocalCluster

    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(tmp_path_factory.mktemp("elsewhere"))
        # It takes the path of this process, in which other tests have left their folders.
        ours = str(tmp_path_factory.getbasetemp())
        patch.setattr(sys, "path", [each for each in sys.path if not each.startswith(ours)])
        made = LocalCluster(n_workers=1, threads_per_worker=2, dashboard_address=":0")
    with made:
        yield made.scheduler_address


def _job(controller: str, plant: Any = "kinematic-bicycle") -> sweep.Job:
    params: Any = own.params_of(object)()
    path = popsteer.Path(BEND)
    return sweep.Job(path, controller, params, plant, {}, runs=3, constant_speed=5.0)


def _rows(job: sweep.Job, address: str) -> list[dict[str, Any]]:
    chunks = workers.on_dask(job, range(job.runs), address, lambda _: None)
    return sorted((row for chunk in chunks for row in chunk), key=lambda row: int(row["run"]))


@pytest.mark.parametrize("name", ["mine.py:Own", "box.outer:Own"])
def test_nested_packages_are_sent_along_and_again_once_changed(
    here: Path, cluster: str, name: str
) -> None:
    job = _job(name)
    first = sweep.drive(job, range(3))
    assert _rows(job, cluster) == first
    (here / "box/deep/late.py").write_text("def scaled(gain):\n    return 0.25 * gain\n")
    _forget()
    job = _job(name)
    second = sweep.drive(job, range(3))
    assert second != first
    assert _rows(job, cluster) == second


def test_module_beside_that_this_process_alone_has_loaded_is_sent(here: Path, cluster: str) -> None:
    importlib.import_module("beside")
    job = _job("mine.py:Own")
    assert "beside.py" in own.code("controller", "mine.py:Own")
    assert _rows(job, cluster) == sweep.drive(job, range(3))


def test_code_that_is_there_already_is_left_as_it_is(tmp_path: Path) -> None:
    """Another thread of the worker may look for its modules meanwhile."""
    files = tuple((name, text.encode()) for name, text in FILES.items())
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys, "path", list(sys.path))
        own.receive(files, tmp_path / "worker")
        before, (root,) = list(sys.path), (tmp_path / "worker").iterdir()
        (root / "beside.py").write_text("LOADED = True\n")
        own.receive(files, tmp_path / "worker")
        assert sys.path == before
        assert (root / "beside.py").read_text() == "LOADED = True\n"
        own.receive(files[:1], tmp_path / "worker")
        assert sys.path[-1] != before[-1]
        assert len(sys.path) == len(before)


def test_two_files_of_one_name_that_differ_are_refused(here: Path, cluster: str) -> None:
    job = _job("mine.py:Own", plants.get("car/mine.py:Car"))
    with pytest.raises(PopsteerError, match=r"--dask: .* two files mine\.py that differ"):
        _rows(job, cluster)


def test_code_of_a_module_has_what_its_functions_import_by_the_packages_name(here: Path) -> None:
    found = own.code("controller", "box.outer:Own")
    assert list(found) == ["__init__.py", "base.py", "deep/gain.py", "deep/late.py", "outer.py"]
    (here / "box/deep/late.py").write_text("")
    assert own.changed("controller", "box.outer:Own", found) == "deep/late.py"


def test_code_that_was_not_there_before_is_a_change(here: Path) -> None:
    found = own.code("controller", "mine.py:Own")
    known = {name: each for name, each in found.items() if name != "box/base.py"}
    assert own.changed("controller", "mine.py:Own", known) == "box/base.py"
