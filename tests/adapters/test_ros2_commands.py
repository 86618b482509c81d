"""The commands where something is not there: an extra, a domain, a publisher, a fitting QoS."""

from __future__ import annotations

import itertools
import subprocess
import sys
import time
from typing import TYPE_CHECKING, Any

import pytest

import popsteer
from tests.cli import command
from tests.helpers import PATIENCE, looped

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

NEEDS = 'ROS 2 needs the extra "ros2" (not installed: {})'
MESSAGE = f'{NEEDS}: pip install "popsteer-VERSION-PLATFORM.whl[ros2]"'


def _without(missing: str, code: str) -> subprocess.CompletedProcess[str]:
    hidden = f"import sys; sys.modules[{missing!r}] = None\n"
    return subprocess.run(
        [sys.executable, "-c", hidden + code], check=False, capture_output=True, text=True
    )


def test_each_entry_names_the_extra_that_is_missing() -> None:
    code = """
import popsteer
from popsteer.adapters import ros2
for call in (
    lambda: ros2.odometry_message(0.0, 0.0, 0.0, 0.0, 0, "map"),
    lambda: ros2.path_message([], [], [], 0, "map"),
    lambda: ros2.ackermann_message(0.0, 0.0, 0.0, 0, "base_link"),
    lambda: ros2.control_message(0.0, 0.0, 0.0, 0),
    lambda: ros2.Recording("new.mcap"),
    lambda: ros2.Participant(1).reader("/odom", "nav_msgs/msg/Odometry"),
):
    try:
        call()
    except popsteer.PopsteerError as error:
        print(error)
"""
    ended = _without("rosbags", code)
    assert (ended.returncode, ended.stderr) == (0, "")
    assert ended.stdout == 6 * f"{MESSAGE.format('rosbags')}\n"


def test_popsteer_imports_neither_adapter_nor_dds() -> None:
    code = """
import sys, popsteer
parts = ("popsteer.adapters", "cyclonedds", "rosbags")
sys.exit(any(name.startswith(parts) for name in sys.modules))
"""
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


@looped(
    ("arguments", "said"),
    [
        (["--domain", "233"], "domain must be a whole number from 0 to 232, got '233'"),
        (["--topic", "odometry"], "--topic must be written NAME=VALUE, got 'odometry'"),
        (
            ["--topic", "odom=/odom"],
            "unknown topic 'odom', did you mean odometry? Known: odometry, path, command",
        ),
        (["--topic", "odometry=/my odom"], "topic odometry must be words of letters, digits and _"),
        (["--topic", "path=/a//b"], "topic path must be words of letters"),
        (["--topic", "path=/1abc"], "topic path must be words of letters"),
        (["--topic", "path=/a/"], "topic path must be words of letters"),
        (["--topic", "command=/odom"], "topic must be given once, not for odometry and command"),
        (["--topic", "path=/a", "--topic", "path=/b"], "--topic must be given once, got 'path'"),
        (["--ros-args", "-r", "odom"], "--remap must be written NAME:=VALUE, got 'odom'"),
        (["--ros-args", "-r", "__node:=my node"], "node name must be letters, digits"),
        (["--ros-args", "-r", "__ns:=car"], "namespace must be words of letters"),
        (["--ros-args", "-p", "rates:=3"], "unknown parameter 'rates', did you mean rate? Known"),
        (["--ros-args", "-p", "rate:=fast"], "parameter rate must be a number, got 'fast'"),
        (["--ros-args", "-p", "rate:=0"], "rate must be in [1, 1000], got 0"),
        (["--path-type", "points"], "unknown --path-type 'points'; known: path, trajectory"),
        (["--rate", "0"], "rate must be in [1, 1000], got 0"),
        (["--max-speed", "0"], "--max-speed must be in (0, 10000], got 0"),
        (["--record", "run.bag"], "recording must be a file *.mcap, got 'run.bag'"),
        (["--controller", "mpc"], "unknown controller 'mpc'; known: pid"),
        (["--params", "nowhere.toml"], "nowhere.toml: No such file or directory"),
        (["--timeout", "nan"], "timeout must be in [0, 1e+06], got nan"),
    ],
)
def test_option_that_cannot_be_is_refused_by_name(
    capsys: pytest.CaptureFixture[str], arguments: list[str], said: str
) -> None:
    pytest.importorskip("cyclonedds", reason='the extra "ros2" is not installed')
    outcome = command.call(capsys, "ros2", "--vehicle", "paper", *arguments)
    assert outcome.status == 2
    assert outcome.err.startswith(f"popsteer: {said}"), outcome.err
    assert outcome.out == ""


def test_ros_arguments_name_the_node_its_topics_and_parameters(tmp_path: Path) -> None:
    pytest.importorskip("rosbags", reason='the extra "ros2" is not installed')
    from popsteer.cli import ros2_options

    names = ros2_options.names_of(
        ["__ns:=/car", "__node:=steer", "odom:=/ego/odom", "drive:=out", "~/predicted_path:=ahead"]
    )
    topics = ros2_options.topics_of(["path=plan"], None, None, autoware=False, names=names)
    assert (topics.odometry, topics.path) == ("/ego/odom", "/car/plan")
    assert (topics.command, topics.predicted) == ("/car/out", "/car/ahead")
    assert (topics.diagnostics, topics.clock) == ("/diagnostics", "/clock")
    file = tmp_path / "params.yaml"
    text = "/**:\n  ros__parameters: {rate: 20, stale: 0.2}\n/car/steer:\n  ros__parameters:\n"
    file.write_text(f"{text}    stale: 0.25\nother:\n  ros__parameters: {{hold: 9}}\n")
    found = ros2_options.parameters_of(["rate:=40"], [str(file)], names)
    assert found == {"rate": 40, "stale": 0.25}


def test_files_of_parameters_are_read_as_ros_nodes_read_them(tmp_path: Path) -> None:
    pytest.importorskip("rosbags", reason='the extra "ros2" is not installed')
    from popsteer.cli import ros2_options

    names = ros2_options.names_of(["__ns:=/fleet/car", "__node:=steer"])
    file = tmp_path / "params.yaml"
    for pattern, meant in (
        ("/**", True),
        ("/fleet/car/*", True),
        ("/fleet/**/steer", True),
        ("/**/steer", True),
        ("/*/*/steer", True),
        ("fleet/car/steer", True),
        ("/*", False),
        ("/fleet/*", False),
        ("/**/other", False),
        ("/fleet/car/ste", False),
    ):
        file.write_text(f"{pattern}:\n  ros__parameters: {{rate: 20}}\n")
        assert ros2_options.parameters_of(None, [str(file)], names) == (
            {"rate": 20} if meant else {}
        ), pattern
    # What other nodes have is no business of this one, but a name of its own that is none is.
    file.write_text("/**:\n  ros__parameters: {rate: 20, use_lidar: true}\n")
    assert ros2_options.parameters_of(None, [str(file)], names) == {"rate": 20}
    file.write_text("/fleet/car/steer:\n  ros__parameters: {speed: 20}\n")
    with pytest.raises(popsteer.ConfigError, match="unknown parameter 'speed'"):
        ros2_options.parameters_of(None, [str(file)], names)
    file.write_bytes(b"\xff\xfe rate: 20\n")
    with pytest.raises(popsteer.ConfigError, match="a YAML file of ROS parameters"):
        ros2_options.parameters_of(None, [str(file)], names)


def test_log_level_is_that_of_ros() -> None:
    pytest.importorskip("typer")
    from popsteer.cli import ros2_options

    levels = [None, "debug", "INFO", "popsteer:=info", "warn", "popsteer:=ERROR", "fatal"]
    assert [ros2_options.least(each) for each in levels] == [0, 0, 0, 0, 1, 2, 3]
    with pytest.raises(popsteer.ConfigError, match="loud"):
        ros2_options.least("loud")


def _number() -> str:
    pytest.importorskip("cyclonedds", reason='the extra "ros2" is not installed')
    from tests.adapters.ros2_domain import domain

    return str(domain())


@pytest.mark.parametrize(
    ("options", "topic"),
    [
        ((), "nav_msgs/msg/Odometry that can be used on /odom"),
        (("--sim-time",), "rosgraph_msgs/msg/Clock on /clock"),
    ],
)
def test_silent_domain_ends_the_node_with_one_line_and_status_2(
    tmp_path: Path, options: tuple[str, ...], topic: str
) -> None:
    number, file = _number(), tmp_path / "run.mcap"
    there = ("--domain", number, "--localhost", "--timeout", "0.3", "--record", str(file))
    outcome = command.run("ros2", "--vehicle", "paper", *there, *options)
    assert outcome.status == 2
    assert outcome.err == (
        f"popsteer: no {topic} in domain {number} within 0.3 s: nobody publishes it\n"
    )


def test_silent_domain_ends_the_recorder_with_one_line_and_status_2(tmp_path: Path) -> None:
    number, file = _number(), tmp_path / "run.mcap"
    there = ("--domain", number, "--localhost", "--timeout", "0.3")
    outcome = command.run("record", str(file), *there)
    assert outcome.status == 2
    assert outcome.err.startswith(
        f"popsteer: no message in domain {number} within 0.3 s: /odom: nobody publishes it; /path: "
    )
    assert outcome.err.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def _within(wanted: Callable[[], bool]) -> bool:
    """Whether something holds before long: what is discovered takes a moment."""
    until = time.monotonic() + PATIENCE
    while not wanted():
        if time.monotonic() > until:
            return False
        time.sleep(0.01)
    return True


def _qos(*, reliable: bool, latched: bool) -> Any:
    """What a ROS node offers: rclcpp's `QoS(5)`, `SensorDataQoS` or `.transient_local()`."""
    from cyclonedds.core import Policy, Qos

    return Qos(
        Policy.Reliability.Reliable(10**8) if reliable else Policy.Reliability.BestEffort,
        Policy.Durability.TransientLocal if latched else Policy.Durability.Volatile,
        Policy.History.KeepLast(5),
    )


@pytest.mark.parametrize("latched", [False, True])
@pytest.mark.parametrize("reliable", [False, True])
def test_publishers_of_each_qos_are_heard_where_ros_would_hear_them(
    reliable: bool, latched: bool
) -> None:
    number = int(_number())
    from cyclonedds.pub import DataWriter

    from popsteer import Driver
    from popsteer.adapters.ros2 import messages
    from popsteer.adapters.ros2.dds import Participant
    from popsteer.adapters.ros2.node import Node

    ros = Participant(number, local=True)
    qos = _qos(reliable=reliable, latched=latched)
    writers = {
        kind: DataWriter(ros._participant, ros._topic(name, kind), qos=qos)
        for name, kind in (("/odom", messages.ODOMETRY), ("/path", messages.PATH))
    }
    node = Node(Participant(number, local=True), Driver)
    wanted = (1, int(reliable))
    readers = [node.odometry_reader, node.path_reader]
    assert _within(lambda: tuple(reader.peers for reader in readers) == wanted)
    if not reliable:
        assert _within(lambda: node.path_reader.refused > 0)
        why = ros.graph.why_silent("/path", messages.PATH, node.path_reader)
        assert why.startswith("its publisher has a QoS that does not fit")
    assert len(writers) == 2


def test_path_published_before_the_node_is_there_is_heard_once() -> None:
    pytest.importorskip("cyclonedds", reason='the extra "ros2" is not installed')
    from popsteer import Driver
    from popsteer.adapters import ros2
    from popsteer.adapters.ros2 import messages
    from popsteer.adapters.ros2.dds import Participant
    from popsteer.adapters.ros2.node import Node

    member = Participant(int(_number()), local=True)
    writer = member.writer("/path", messages.PATH, latched=True)
    writer.write(messages.encode(ros2.path_message([0.0, 9.0], [0.0, 0.0], [0.0, 0.0], 1, "map")))
    node = Node(member, Driver)
    at = itertools.count(10**9, 10**8)

    def heard(count: int) -> bool:
        node.cycle(next(at), 0.02)
        return (node.intake.courses.received, node.intake.course_number) == (count, count)

    assert _within(lambda: heard(1))
    writer.write(messages.encode(ros2.path_message([0.0, 8.0], [0.0, 0.0], [0.0, 0.0], 2, "map")))
    assert _within(lambda: heard(2))
    for _ in range(5):
        time.sleep(0.01)
        assert heard(2)
