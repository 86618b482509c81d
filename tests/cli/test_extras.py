"""Whatever extra is missing: one line says at once how to install all that the command needs."""

from __future__ import annotations

import re
import sys
from typing import TYPE_CHECKING

import pytest

from popsteer.extras import MODULES, require
from popsteer.toml_file import tomllib
from tests.cli import command
from tests.helpers import ROOT

if TYPE_CHECKING:
    from collections.abc import Iterable
    from pathlib import Path

ALL = sorted({module for modules in MODULES.values() for module in modules})


def _hide(monkeypatch: pytest.MonkeyPatch, modules: Iterable[str]) -> None:
    for module in modules:
        monkeypatch.setitem(sys.modules, module, None)


@pytest.mark.parametrize(
    ("absent", "line", "said"),
    [
        *((MODULES["lab"], each, f'{each} needs the extra "lab"') for each in ("compare", "tune")),
        (("matplotlib",), "matrix --out out", 'matrix needs the extra "lab"'),
        (("plotly",), "compare --report page.html", 'compare needs the extra "lab"'),
        (("scipy",), "stability", 'stability needs the extra "lab"'),
        (("rosbags",), "replay drive.mcap", 'replay needs the extra "lab"'),
        (ALL, "", 'the command line needs the extra "lab"'),
        (ALL, "ros2 --vehicle paper", 'ros2 needs the extra "ros2"'),
        (("cyclonedds",), "ros2 --vehicle paper", 'ros2 needs the extra "ros2"'),
        (("rosbags",), "record new.mcap", 'record needs the extra "ros2"'),
        (ALL, "sweep --dask local:2", 'sweep needs the extras "dask", "lab"'),
        (("distributed",), "sweep --dask local:2", '--dask needs the extra "dask"'),
        (("pyarrow",), "sweep --out rows.parquet", 'Parquet needs the extra "parquet"'),
        (
            ("distributed", "pyarrow"),
            "sweep --dask local:2 --out rows.parquet",
            'Parquet needs the extras "dask", "parquet"',
        ),
        (("osqp",), "compare --controllers pop,mpc", 'controller mpc needs the extra "mpc"'),
        (
            ("osqp", "mujoco"),
            "matrix --controllers pop,mpc --plants mujoco-car",
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
    assert outcome.err == f'popsteer: {said}: pip install "popsteer[{names}]"\n'
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
