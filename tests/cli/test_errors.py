"""Whatever is wrong: one line on stderr, exit status 2, nothing written."""

from __future__ import annotations

import re
import sys
from typing import TYPE_CHECKING

import pytest

from popsteer.extras import MODULES, require
from popsteer.toml_file import tomllib
from tests.cli import command
from tests.helpers import ROOT, looped

if TYPE_CHECKING:
    from collections.abc import Iterable
    from pathlib import Path


RAGGED = "0,0\n1,0\n2,0,5\n"
POP = ("compare", "--controllers", "pop")
WRONG = {
    "law": (
        ("compare", "--controllers", "pid,lqr"),
        "unknown controller 'lqr'; known: pid, ",
    ),
    "no-law": (("compare", "--controllers", " , "), "--controllers must be names, separated"),
    "plant": (("compare", "--plant", "tank"), "unknown plant 'tank'; known: carla-identified, "),
    "track": (("compare", "--track", "monza"), "unknown track 'monza'; known: racetrack, "),
    "typo": (
        ("compare", "--plant", "carla-identifed"),
        "', did you mean carla-identified? Known: ",
    ),
    "typo-of-column": (
        ("replay", "drive.csv", "--unit", "sped=km/h"),
        "unknown column 'sped', did you mean speed? Known: t, ",
    ),
    "preset": (("compare", "--preset", "mine"), "unknown preset 'mine'; known: default, paper, "),
    "start-text": (("compare", "--start", "here"), "--start must be three numbers X,Y,YAW"),
    "start-two": (("compare", "--start=1,2"), "--start must be three numbers X,Y,YAW"),
    "start-both": (
        ("compare", "--start=1,2,0", "--start-offset=1"),
        "--start-offset must be left out where --start is given, got 1.0",
    ),
    "start-offset": (
        (*POP, "--start-offset=inf"),
        "start_offset must be in",
    ),
    "preset-of-none": (
        ("compare", "--controllers", "mpc", "--preset", "paper"),
        "preset must be left out, as it changes nothing about mpc, got 'paper'",
    ),
    "start-nan": (("compare", "--start=nan,0,0"), "x must be in"),
    "start-inf": (("compare", "--start=0,0,-inf"), "yaw must be in"),
    "dt-negative": (("compare", "--dt", "-0.05"), "dt must be in [1e-06, 1], got -0.05"),
    "dt-zero": (("compare", "--dt", "0"), "dt must be in [1e-06, 1], got 0.0"),
    "dt-nan": (("compare", "--dt", "nan"), "dt must be in [1e-06, 1], got nan"),
    "dt-text": (("compare", "--dt", "soon"), "Invalid value for '--dt': "),
    "closed-track": (("compare", "--closed"), "--closed must be given with --waypoints"),
    "both": (("sweep", "--waypoints", "a.csv", "--track", "circle"), "--track must be left out"),
    "former-option": (("compare", "--laws", "pop"), "--controllers now"),
    "former-file": (("stability", "--json", "a.json"), "No such option: --json; it is --out now"),
    "former-command": (("simulate",), "'simulate'; it is compare --controllers NAME now"),
    "former-bench": (("bench",), "it is make bench, in a checkout, now"),
    "option": (("compare", "--colour"), "No such option: --colour"),
    "command": (("drive",), "No such command 'drive'"),
    "argument": (("compare", "extra"), "unexpected extra argument"),
    "missing": (("plan",), "Missing argument 'WAYPOINTS'"),
    "export": (("tracks", "--tracks", "monza", "--out", "a"), "unknown track 'monza'"),
    "controller": (("compare", "--controllers", "x"), "unknown controller 'x'"),
    "set-name": (
        (*POP, "--set", "gain=1"),
        "unknown parameter of pop 'gain'; known: look",
    ),
    "set-form": (
        (*POP, "--set", "turn_time"),
        "must be written NAME=VALUE, got 'turn_time'",
    ),
    "set-text": (
        (*POP, "--set", "turn_time=x"),
        "turn_time must be a number, got 'x'",
    ),
    "set-nan": (
        (*POP, "--set", "min_lookahead=nan"),
        "min_lookahead must be",
    ),
    "set-none": (
        (*POP, "--set", "turn_time=none"),
        "turn_time must be a number, got 'none'",
    ),
    "set-range": (
        (*POP, "--set-vehicle", "max_steer=-1"),
        "max_steer must be",
    ),
    "set-vehicle": (("compare", "--set-vehicle", "mass=1"), "unknown parameter of the vehicle"),
    "vehicle": (("compare", "--vehicle", "tank"), "unknown vehicle 'tank'; known: paper, "),
    "vehicle-file": (("compare", "--vehicle", "no.toml"), "no.toml: "),
    "plant-file": ((*POP, "--plant", "no.toml"), "no.toml: "),
    "vehicle-point": (
        ("compare", "--vehicle", "paper"),
        "rear_axle must be that of the plant, -1.94, got 0.0",
    ),
    "start-at": (("compare", "--start=1,2,0", "--start-at", "roof"), "unknown --start-at 'roof'"),
    "start-at-none": (
        ("compare", "--start-at", "front"),
        "--start-at must be given with --start, got 'front'",
    ),
    "set-even": (
        (*POP, "--set", "candidate_count=20"),
        "candidate_count must be odd",
    ),
    "set-real": (
        (*POP, "--set", "candidate_count=2.5"),
        "candidate_count must be a whole",
    ),
    "set-truth": (
        ("compare", "--controllers", "pid", "--set", "integral_with_dt=2"),
        "integral_with_dt must be true or false, got '2'",
    ),
    "set-plant": (
        (*POP, "--set-plant", "mass=1"),
        "unknown parameter of carla-identified",
    ),
    "set-run": ((*POP, "--set-run", "substeps=0"), "substeps must be"),
    "set-records": (
        (*POP, "--set-run", "keep_records=no"),
        "keep_records must be true",
    ),
    "longitudinal": (
        (*POP, "--longitudinal", "x"),
        "unknown longitudinal controller 'x'; known: ",
    ),
}


@looped(("arguments", "message"), WRONG.values())
def test_wrong_use_is_one_line_and_writes_nothing(
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    arguments: tuple[str, ...],
    message: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    if arguments[0] != "tracks" and arguments[0] != "drive":
        arguments = (*arguments, "--out", "out")
    outcome = command.call(capsys, *arguments)
    assert outcome.status == 2
    assert outcome.out == ""
    assert outcome.err.startswith("popsteer: ")
    assert message in outcome.err
    assert outcome.err.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


@looped(
    ("arguments", "message"),
    [
        (("compare", "--plant", "car.tml"), "'car.tml', did you mean car.toml? Known: carla-"),
        (("compare", "--plants", "mujoco-car,car.tml"), "'car.tml', did you mean car.toml? Known"),
        (("compare", "--vehicle", "car.tml"), "'car.tml', did you mean car.toml? Known: paper, "),
        (
            ("compare", "--vehicle", "cra.toml"),
            "cra.toml: No such file or directory, did you mean ",
        ),
        (("compare", "--params", "car.tml"), "did you mean car.toml?\n"),
        (
            ("plan", "course.cvs"),
            "cannot be read: No such file or directory, did you mean course.csv?",
        ),
        (("replay", "drve.mcap"), "no such file or folder, did you mean drive.mcap?"),
        (
            ("sweep", "--run", "swep.csv:3"),
            "swep.csv: No such file or directory, did you mean sweep.csv",
        ),
        (("plan", "other.txt"), "other.txt: cannot be read: No such file or directory\n"),
    ],
)
def test_mistyped_file_draws_the_one_that_may_be_meant(
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    arguments: tuple[str, ...],
    message: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ("car.toml", "course.csv", "drive.mcap", "sweep.csv"):
        (tmp_path / name).touch()
    outcome = command.call(capsys, *arguments)
    assert outcome.status == 2
    assert message in outcome.err
    assert outcome.err.count("\n") == 1


@looped(
    ("content", "message"),
    [
        (None, "cannot be read"),
        ("", "at least 2 waypoints are needed"),
        ("1,2\n", "at least 2 waypoints are needed"),
        (RAGGED, "line 3: found 3 columns, the first row has 2"),
        ("0,0\n1,x\n", "line 2, column 2: 'x' is not a number"),
        ("0,0\n1,nan\n", "line 2, column 2: 'nan' is not finite"),
        ("0,0\n0,0\n", "way.csv: its 2 waypoints are all at one place"),
        ("0,0\n0.2,0\n", "way.csv is 0.2 m long, and the vehicle 3 m from axle to axle"),
        ("0,0,1\n1,0,fast\n", "line 2, column 3: 'fast' is not a number"),
    ],
)
def test_waypoints_at_fault_are_named(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, content: str | None, message: str
) -> None:
    file = tmp_path / "way.csv"
    if content is not None:
        file.write_text(content, encoding="utf-8")
    out = tmp_path / "out"
    outcome = command.call(capsys, "compare", "--waypoints", str(file), "--out", str(out))
    assert outcome.status == 2
    assert outcome.err.count("\n") == 1
    assert message in outcome.err
    assert not out.exists()


def test_installed_command_with_wrong_use_exits_2_without_traceback() -> None:
    outcome = command.run("compare", "--controllers", "foo")
    assert outcome.status == 2
    assert outcome.out == ""
    assert outcome.err == (
        "popsteer: unknown controller 'foo'; known: pid, pure-pursuit, stanley, pop, "
        "preview-pop, mpc\n"
    )


def test_output_to_a_terminal_without_greek_is_no_error() -> None:
    outcome = command.run(
        "compare", "--track", "straight", environment={"PYTHONIOENCODING": "ascii"}
    )
    assert outcome.status == 0
    assert outcome.err == ""


HEAD = "t,x,y,yaw,speed,steer\n0,0,0,0,1,0\n"
WILD = {
    "digits.csv": (HEAD + f"0.1,{'1' * 5_000_000},0,0,1,0\n0.2,x,0,0,1,0\n", "identify"),
    "two-rows.csv": (HEAD + "0.1,0.1,0,0,1,0\n", "identify"),
    "nested.toml": (f"a = {'[' * 20_000}{']' * 20_000}", "sweep", "--distributions"),
    "key-of-draws.toml": (f"{'k' * 1_000_000} = 1\n", "sweep", "--distributions"),
    "key.toml": (f"{'k' * 1_000_000} = 1\n", "compare", "--vehicle"),
    "key-of-tuning.toml": (f"[pop]\n{'k' * 1_000_000} = 1\n", "compare", "--params"),
    "table.toml": (f"[{'k' * 1_000_000}]\nx = 1\n", "compare", "--params"),
    "value.toml": (f"steer_lag = '{'v' * 1_000_000}'\n", "compare", "--vehicle"),
}


@looped("name", WILD)
def test_wild_file_is_one_short_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str
) -> None:
    text, *arguments = WILD[name]
    (tmp_path / name).write_text(text, encoding="utf-8")
    outcome = command.call(capsys, *arguments, str(tmp_path / name))
    assert (outcome.status, outcome.out) == (2, "")
    assert name in outcome.err or "quantity" in outcome.err
    assert outcome.err.count("\n") == 1
    assert len(outcome.err) < 1500


@looped("arguments", [("replay",), ("compare", "--waypoints"), ("compare", "--vehicle", ".toml")])
def test_device_without_an_end_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], arguments: tuple[str, ...]
) -> None:
    endless = tmp_path / f"endless{arguments[2] if len(arguments) > 2 else '.csv'}"
    endless.unlink(missing_ok=True)
    endless.symlink_to("/dev/zero")
    outcome = command.call(capsys, *arguments[:2], str(endless))
    assert outcome.status == 2
    assert "is a device, not a file" in outcome.err


ALL = sorted({module for modules in MODULES.values() for module in modules})


def _hide(monkeypatch: pytest.MonkeyPatch, modules: Iterable[str]) -> None:
    for module in modules:
        monkeypatch.setitem(sys.modules, module, None)


@pytest.mark.parametrize(
    ("absent", "line", "said"),
    [
        *((MODULES["lab"], each, f'{each} needs the extra "lab"') for each in ("compare", "tune")),
        (("matplotlib",), "compare --out out", 'compare needs the extra "lab"'),
        (("plotly",), "compare --report page.html", 'compare needs the extra "lab"'),
        (("scipy",), "stability", 'stability needs the extra "lab"'),
        (("rosbags",), "replay drive.mcap", 'replay needs the extra "lab"'),
        (ALL, "", 'the command line needs the extra "lab"'),
        (ALL, "ros2 --vehicle paper", 'ros2 needs the extra "ros2"'),
        (("cyclonedds",), "ros2 --vehicle paper", 'ros2 needs the extra "ros2"'),
        (("rosbags",), "record new.mcap", 'record needs the extra "ros2"'),
        (ALL, "sweep --dask tcp://far:8786", 'sweep needs the extras "dask", "lab"'),
        (("distributed",), "sweep --dask tcp://far:8786", '--dask needs the extra "dask"'),
        (("pyarrow",), "sweep --out rows.parquet", 'Parquet needs the extra "parquet"'),
        (
            ("distributed", "pyarrow"),
            "sweep --dask tcp://far:8786 --out rows.parquet",
            'Parquet needs the extras "dask", "parquet"',
        ),
        (("daqp",), "compare --controllers pop,mpc", 'controller mpc needs the extra "mpc"'),
        (
            ("daqp", "mujoco"),
            "compare --controllers pop,mpc --plants mujoco-car",
            'plant mujoco-car needs the extras "mpc", "plants"',
        ),
    ],
)
def test_command_names_at_once_the_extras_that_are_missing(
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    absent: tuple[str, ...],
    line: str,
    said: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    _hide(monkeypatch, absent)
    outcome = command.call(capsys, *line.split())
    names = ",".join(re.findall(r'"(\w+)"', said))
    assert (outcome.status, outcome.out) == (2, "")
    lack = sorted(set(absent) & {each for extra in names.split(",") for each in MODULES[extra]})
    assert outcome.err == (
        f"popsteer: {said} (not installed: {', '.join(lack)}): "
        f'pip install "popsteer-VERSION-PLATFORM.whl[{names}]"\n'
    )
    assert list(tmp_path.iterdir()) == []


def test_ros2_needs_nothing_of_the_lab_and_other_commands_show_their_help(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    _hide(monkeypatch, set(ALL) - set(MODULES["ros2"]))
    for line in (("ros2", "--help"), ("record", "--help"), ("compare", "--help"), ("tracks",)):
        assert command.call(capsys, *line).status == 0
    require("ros2", "ros2")


def test_extras_are_those_of_the_package_and_a_requirement_reads_the_same_everywhere() -> None:
    content = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    extras = content["project"]["optional-dependencies"]
    assert set(extras) == set(MODULES)
    asked: dict[str, set[str]] = {}
    for each in (*extras.values(), *content["dependency-groups"].values()):
        for requirement in each:
            if isinstance(requirement, str) and not requirement.startswith("popsteer["):
                name = re.split(r"[^\w.-]", requirement)[0]
                asked.setdefault(name, set()).add(requirement.partition(";")[0])
    assert {name: ways for name, ways in asked.items() if len(ways) > 1} == {}


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--set-vehicle", "wheelbase=270"), "wheelbase = 270 m is beyond what vehicles have"),
        (("--set-plant", "max_steer_rate=35"), "max_steer_rate = 35 rad/s is beyond"),
        (("--set-vehicle", "wheelbase=0.33"), None),
    ],
)
def test_number_in_an_implausible_unit_draws_one_warning(
    capsys: pytest.CaptureFixture[str], options: tuple[str, str], said: str | None
) -> None:
    short = ("--track", "slalom", "--set-run", "time_limit=1")
    outcome = command.call(capsys, *POP, *short, *options)
    assert outcome.status == 0
    assert outcome.err.count("warning") == (said is not None)
    assert (said or "") in outcome.err
