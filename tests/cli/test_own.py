"""Controllers, plants and tracks of one's own, by name."""

from __future__ import annotations

import csv
import json
import re
from pathlib import Path
from typing import Any

import pytest

import popsteer
from popsteer import own, plants, sim
from popsteer.cli.assignments import assigned
from popsteer.errors import ConfigError
from popsteer.lab import baselines
from popsteer.lab.common.names import title_of
from popsteer.params_file import load_all
from tests.cli.command import call
from tests.helpers import ROOT

PAGE = (ROOT / "docs" / "compare_your_controller.md").read_text(encoding="utf-8")
MINE, WRAPPED = re.findall(r"^```python\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL)
COMMANDS = re.findall(r"^popsteer (.*)$", PAGE, re.MULTILINE)

BROKEN = """
import popsteer
from popsteer import plants

class Tired:
    def __init__(self, path, vehicle):
        self.steps = 0

    def step(self, x, y, yaw, speed, dt):
        self.steps += 1
        if self.steps > 20:
            raise RuntimeError("tired of \\033[31msteering")
        return 0.0

class Unborn:
    def __init__(self, path, vehicle):
        raise LookupError("no such matrix")

class Blank:
    def __init__(self, path, vehicle):
        pass

class Car:
    name, reverses = "unicycle", True

    def __init__(self):
        self.vehicle = popsteer.Vehicle(wheelbase=2.0, steer_lag=0.0)

    def reset(self, x, y, yaw, speed):
        self.state = x, y, yaw, speed

    def advance(self, steer, throttle, brake, dt, substeps, reverse):
        import math
        x, y, yaw, speed = self.state
        for _ in range(substeps):
            x, y = x + speed * math.cos(yaw) * dt, y + speed * math.sin(yaw) * dt
            yaw += speed * math.tan(steer) / 2.0 * dt
            speed += (3.0 * throttle - 6.0 * brake) * dt
        self.state = x, y, yaw, speed
        return plants.PlantState(*self.state, speed * math.tan(steer) / 2.0, steer)

def road():
    return [(float(x), 0.0) for x in range(61)]

sign = "to the bridge"

def fallen():
    raise ArithmeticError("bridge out")
"""


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    Path("mine.py").write_text(MINE)
    Path("broken.py").write_text(BROKEN)
    return tmp_path


@pytest.mark.usefixtures("_blank_figures")
def test_page_class_is_compared_swept_and_tuned_by_the_commands_of_the_page(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    compare, matrix, sweep, tune, again = COMMANDS
    assert call(capsys, *compare.split()).status == 0
    figures = json.loads(Path("out/metrics.json").read_text())["controllers"]["mine.py:BangBang"]
    assert figures["finished"]
    assert figures["params"] == {"amplitude": 0.122}
    assert Path("out/overview.png").exists()
    assert Path("out/runs/mine.py-BangBang.csv").exists()
    assert "BangBang" in Path("slalom.html").read_text()
    done = call(capsys, *matrix.split())
    assert done.out.count("BangBang") == 4  # on two tracks and two plants
    assert call(capsys, *sweep.replace("1000", "4").split(), "--workers", "2").status == 0
    rows = list(csv.DictReader(Path("sweep.csv").read_text().splitlines()[1:]))
    assert [row["run"] for row in rows] == ["0", "1", "2", "3"]
    again_of = ("sweep", "--run", "sweep.csv:2")
    refused = "popsteer: sweep.csv: drives code of your own: name it by --controller"
    assert call(capsys, *again_of).err == f"{refused} mine.py:BangBang\n"
    done = call(capsys, *again_of, "--controller", "mine.py:BangBang")
    assert "to the last bit" in done.out
    assert call(capsys, *tune.replace("20", "2").split(), "--cars", "1").status == 0
    tuned = Path("tuned.toml").read_text()
    amplitude = float(tuned.rpartition("=")[2])
    assert 0.01 <= amplitude <= 0.5
    assert call(capsys, *again.split(), "--out", "tuned").status == 0
    figures = json.loads(Path("tuned/metrics.json").read_text())["controllers"]
    assert figures["mine.py:BangBang"]["params"] == {"amplitude": amplitude}


@pytest.mark.usefixtures("_blank_figures")
def test_changed_file_of_a_sweep_is_refused(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    name = [
        "--controller",
        "mine.py:BangBang",
        "--track",
        "circle",
        "--constant-speed",
        "6",
        "--runs",
        "1",
    ]
    assert call(capsys, "sweep", *name, "--workers", "1", "--out", "one.csv").status == 0
    Path("mine.py").write_text(MINE.replace("0.122", "0.2"))
    done = call(capsys, "sweep", "--run", "one.csv:0", "--controller", "mine.py:BangBang")
    assert done.status == 2
    assert "mine.py:BangBang is not there as it was" in done.err


def test_own_controller_with_the_title_of_a_shipped_one_is_told_from_it(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (here / "other.py").write_text(MINE.replace("class BangBang", "class Stanley"))
    line = "compare --controllers stanley,other.py:Stanley,mine.py:BangBang --track slalom"
    done = call(capsys, *line.split(), "--constant-speed", "6")
    rows = [row.split()[0] for row in done.out.splitlines() if " default " in row]
    assert rows == ["Stanley", "other.py:Stanley", "BangBang"]


@pytest.mark.usefixtures("_blank_figures")
def test_what_raises_is_shown_with_its_traceback_and_the_others_drive(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    line = "compare --controllers broken.py:Tired,pop,broken.py:Unborn --track broken.py:road"
    done = call(capsys, *line.split(), "--constant-speed", "5", "--step-time", "--out", "out")
    assert done.status == 0
    assert (
        "Tired came to an end after 1.0 s: raised RuntimeError: tired of \\x1b[31msteering"
        in done.out
    )
    assert "\nRuntimeError: tired of \\x1b[31msteering\n" in done.err
    assert 'raise LookupError("no such matrix")' in done.err
    assert "popsteer/" not in done.err
    found = json.loads(Path("out/metrics.json").read_text())["controllers"]
    assert [each["finished"] for each in found.values()] == [False, True, False]
    assert found["broken.py:Tired"]["steps"] == 20
    assert "step_time" in found["pop"]


def test_sweep_with_a_class_that_raises_counts_failures_and_shows_one(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    line = "sweep --controller broken.py:Unborn --track circle --runs 2 --workers 1"
    done = call(capsys, *line.split(), "--constant-speed", "5")
    assert done.status == 0
    assert done.err.count("no such matrix") == 2  # the line of code, and the message


@pytest.mark.usefixtures("_blank_figures")
def test_own_plant_and_road_are_driven_and_vary(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    where = ["--plant", "broken.py:Car", "--track", "broken.py:road", "--constant-speed", "5"]
    done = call(capsys, "compare", "--controllers", "pop", *where, "--out", "out")
    assert done.status == 0
    document = json.loads(Path("out/metrics.json").read_text())
    assert document["plant_vehicle"]["wheelbase"] == 2.0
    assert document["path"]["waypoints"] == 61
    assert document["controllers"]["pop"]["finished"]
    vary = ["--vary", "dead_time=uniform(0,0.1)", "--runs", "2", "--workers", "1"]
    assert call(capsys, "sweep", "--controller", "pop", *where, *vary, "--out", "a.csv").status == 0
    rows = list(csv.DictReader(Path("a.csv").read_text().splitlines()[1:]))
    assert len({row["dead_time"] for row in rows}) == 2
    assert {row["finished"] for row in rows} == {"True"}


@pytest.mark.usefixtures("_blank_figures")
def test_replay_lets_an_own_controller_watch_and_wrapped_one_answers(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    Path("wrapped.py").write_text(WRAPPED)
    rows = [f"{0.05 * k},{0.4 * k},0.1,0,8,0" for k in range(200)]
    Path("drive.csv").write_text("\n".join(["t,x,y,yaw,speed,steer", *rows]))
    line = "replay drive.csv --controllers wrapped.py:Wrapped --track straight --out out"
    done = call(capsys, *line.split())
    assert done.status == 0, done.err
    table = list(csv.reader(Path("out/summary.csv").read_text().splitlines()))
    assert any("wrapped.py:Wrapped" in cell for row in table for cell in row)
    line = "replay drive.csv --controllers broken.py:Tired --track straight"
    done = call(capsys, *line.split())
    assert done.status == 2
    assert "\nRuntimeError: tired of \\x1b[31msteering\n" in done.err


def test_names_that_stand_for_nothing_are_refused_in_one_line(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    Path("torn.py").write_text("def f(:\n")
    for arguments, said in (
        (("--controllers", "nowhere.py:Mpc"), "controller must be in a file that exists"),
        (("--controllers", "mine.py:Absent"), "controller must be defined in mine.py"),
        (("--controllers", "broken.py:Blank"), "one with a method step"),
        (("--controllers", "torn.py:f"), "torn.py:f raised SyntaxError"),
        (("--controllers", "no_such_module:f"), "of a module that Python finds"),
        (("--plant", "mine.py:Gains"), "a plant, which has name"),
        (("--track", "broken.py:fallen"), "broken.py:fallen raised ArithmeticError: bridge out"),
        (("--track", "broken.py:sign"), "popsteer: broken.py:sign: xy must be an array of numbers"),
    ):
        done = call(capsys, "compare", *arguments)
        assert (done.status, said in done.err) == (2, True), done.err
    assert done.err.count("\n") == 1  # the last is code that did not raise


def test_entry_points_of_an_installed_package_are_known(
    here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    Path("toy.py").write_text(MINE + BROKEN)
    folder = Path("toy-1.0.dist-info")
    folder.mkdir()
    (folder / "METADATA").write_text("Metadata-Version: 2.1\nName: toy\nVersion: 1.0\n")
    (folder / "entry_points.txt").write_text(
        "[popsteer.controllers]\nbang-bang = toy:BangBang\n[popsteer.plants]\ntoy-car = toy:Car\n"
    )
    monkeypatch.syspath_prepend(str(here))
    own.entry_points.cache_clear()
    assert baselines.get("bang-bang").params().as_dict() == {"amplitude": 0.122}
    assert sim.plant_name("toy-car") == "toy-car"
    assert plants.get("toy-car").vehicle.wheelbase == 2.0
    monkeypatch.undo()
    own.entry_points.cache_clear()
    with pytest.raises(ConfigError, match="unknown baseline 'bang-bang'"):
        baselines.get("bang-bang")


def test_run_of_the_library_raises_unless_asked_to_keep_going(here: Path) -> None:
    tired = own.load("controller", "broken.py:Tired")(None, None)
    path = popsteer.Path([(float(x), 0.0) for x in range(61)])
    with pytest.raises(RuntimeError, match="tired"):
        sim.run(tired, path=path)
    run = sim.run(own.load("controller", "broken.py:Tired")(None, None), path=path, keep_going=True)
    assert run.ending == "raised RuntimeError: tired of \x1b[31msteering"
    assert run.traceback.splitlines()[-1] == "RuntimeError: tired of \\x1b[31msteering"
    assert len(run.records["x"]) == run.metrics.steps == 20


ANY = """
class Any:
    steer, tracked_point, params, name = 0.1, "front", {"as_dict": 1}, ["mine"]
    vehicle, status, target = "a car", "fine", None

    def __init__(self, path, vehicle):
        self.path = [1, 2]

    def reset(self, pose):
        raise RuntimeError("reset")

    def step(self, x, y, yaw, speed, dt, *, reverse):
        return 0.05
"""


@pytest.mark.usefixtures("_blank_figures")
def test_own_controller_may_have_any_attribute(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (here / "any.py").write_text(ANY)
    line = "compare --controllers any.py:Any,pop --track circle --constant-speed 6 --step-time"
    done = call(capsys, *line.split(), "--out", "out", "--report", "page.html")
    assert done.status == 0, done.err
    found = json.loads(Path("out/metrics.json").read_text())["controllers"]["any.py:Any"]
    assert found["step_time"] > 0.0
    assert found["params"] == {}
    log = "replay out/runs/pop.csv --controllers any.py:Any --vehicle carla-identified"
    assert call(capsys, *log.split()).status == 0


RAISES = """
class Raises:
    vehicle_given = False

    def __init__(self, path, vehicle):
        pass

    def step(self, x, y, yaw, speed, dt):
        return 0.05

    def __getattr__(self, name):
        raise RuntimeError(name)
"""


def test_sweep_names_an_own_controller_that_cannot_be_made(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (here / "none.py").write_text("Number = 3\n")
    line = "sweep --controller none.py:Number --track circle --constant-speed 6"
    done = call(capsys, *line.split(), "--runs", "2", "--workers", "1")
    assert "Number on carla-identified:\nTypeError: 'int' object is not callable\n" in done.err


def test_what_an_own_controller_raises_first_floods_no_figure_and_no_terminal(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (here / "wordy.py").write_text(RAISES.replace("return 0.05", "raise ValueError(9999 * 'x\\a')"))
    line = "compare --controllers wordy.py:Raises --track circle --constant-speed 6"
    done = call(capsys, *line.split(), "--out", "out", "--report", "page.html")
    assert done.status == 0
    assert max(map(len, [*done.err.split("\n"), *done.out.split("\n")])) < 600
    assert "\a" not in done.out + done.err


@pytest.mark.usefixtures("_blank_figures")
def test_attributes_of_an_own_controller_that_raise_are_not_asked_for(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (here / "raises.py").write_text(RAISES)
    line = "compare --controllers raises.py:Raises --track circle --constant-speed 6 --step-time"
    done = call(capsys, *line.split(), "--out", "out", "--report", "page.html")
    assert (done.status, done.err) == (0, "")
    vary = ["--vary", "dead_time=uniform(0,0.1)", "--runs", "2", "--workers", "1"]
    where = ["--track", "circle", "--constant-speed", "6", "--controller", "raises.py:Raises"]
    assert call(capsys, "sweep", *where, *vary).status == 0


def test_own_controller_whose_errors_are_measured_nowhere_is_refused(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (here / "far.py").write_text(ANY.replace('"front"', "float('nan')"))
    done = call(capsys, "compare", "--track", "circle", "--controllers", "far.py:Any")
    assert (done.status, done.err.count("\n")) == (2, 1)
    assert "tracked_point must be in [-1000, 1000], got nan" in done.err


KINDS = """
from dataclasses import dataclass

@dataclass(frozen=True)
class Params:
    gain: float = 0.2
    damped: bool = True
    limit: float | None = None
    note: str = 'say "a\\nb", \\x7f [c]'
    weights: tuple[float, ...] = (1.0, 2.0)
    k_ψ: int = 2
    RANGES = {"gain": (0.01, 0.5)}

class Kinds:
    Params = Params

    def __init__(self, path, vehicle, params):
        self.path, self.params = path, params

    def step(self, x, y, yaw, speed, dt):
        return 0.1 * self.params.gain * (1.0 - abs(yaw))
"""


@pytest.mark.usefixtures("_blank_figures")
def test_tuned_parameters_of_all_kinds_are_read_by_every_command(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (here / 'a,"b.py').write_text(KINDS)
    name = 'a,"b.py:Kinds'
    line = ["tune", "--controller", name, "--tracks", "circle", "--constant-speed", "6"]
    line += ["--cars", "1", "--trials", "2", "--set", "damped=false", "--out", "tuned.toml"]
    done = call(capsys, *line)
    assert done.status == 0, done.err
    found: Any = load_all("tuned.toml", [name])[name]
    base: Any = own.params_of(own.load("controller", name))()
    assert (found.damped, found.limit, found.weights) == (False, None, (1.0, 2.0))
    assert found.note == base.note == 'say "a\nb", \x7f [c]'
    assert found.replace(gain=0.2, damped=True).as_dict() == base.as_dict()
    shown = call(capsys, "params", name).out
    assert 'say "a\\nb", \\x7f [c]' in shown
    said = assigned(base, ["note=quietly = so"], name)
    assert said.note == "quietly = so"
    # Before and after: each command reads it.
    short = ["--controller", name, "--params", "tuned.toml", "--constant-speed", "6"]
    assert call(capsys, *line[:-1], "again.toml", "--params", "tuned.toml").status == 0
    swept = ["sweep", *short, "--track", "circle", "--runs", "1", "--workers", "1"]
    assert call(capsys, *swept, "--out", "s.csv").status == 0
    assert "to the last bit" in call(capsys, "sweep", "--run", "s.csv:0", *short[:2]).out
    (here / "kinds.py").write_text(KINDS)
    text = Path("tuned.toml").read_text().replace('a,\\"b.py', "kinds.py")
    Path("kinds.toml").write_text(text)
    line = ["--controllers", "kinds.py:Kinds", "--params", "kinds.toml", "--constant-speed", "6"]
    assert call(capsys, "compare", *line, "--track", "circle").status == 0
    assert (
        call(capsys, "compare", *line, "--tracks", "circle", "--plants", "carla-identified").status
        == 0
    )
    Path("bad.toml").write_text(text.replace("damped = false", 'damped = "no"'))
    done = call(capsys, "compare", *line[:3], "bad.toml", "--track", "circle")
    assert done.err.startswith("popsteer: bad.toml: kinds.py:Kinds.damped must be true or false")


@pytest.mark.usefixtures("_blank_figures")
def test_own_controllers_of_one_class_name_are_told_apart(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (here / "new.py").write_text(MINE.replace("0.122", "0.2"))
    both = "mine.py:BangBang,new.py:BangBang"
    line = f"compare --controllers {both} --track circle --constant-speed 6 --out out"
    done = call(capsys, *line.split())
    for name in both.split(","):
        assert re.search(rf"^{name}  ", done.out, re.MULTILINE), done.out
    found = sorted(file.name for file in (here / "out" / "runs").iterdir())
    assert found == ["mine.py-BangBang.csv", "new.py-BangBang.csv"]
    line = "compare --controllers new.py:BangBang,pop --track circle --constant-speed 6"
    assert re.search(r"^BangBang  ", call(capsys, *line.split()).out, re.MULTILINE)
    # Of those that are shown together alone: nothing is remembered.
    assert title_of("mine.py:BangBang") == "BangBang"
    assert title_of("mine.py:BangBang", both.split(",")) == "mine.py:BangBang"
