"""docs/carla.md and docs/ros2.md say what their commands and code say, and what is missing."""

from __future__ import annotations

import contextlib
import io
import os
import re
import subprocess
import sys

import pytest

from tests.helpers import PATIENCE, ROOT

CARLA, ROS2 = (
    (ROOT / "docs" / f"{name}.md").read_text(encoding="utf-8") for name in ("carla", "ros2")
)
BLOCKS = re.compile(r"^```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)


@pytest.mark.parametrize(
    ("page", "extra", "module"), [(CARLA, "carla", "carla"), (ROS2, "ros2", "cyclonedds")]
)
def test_page_code_prints_what_the_page_says(page: str, extra: str, module: str) -> None:
    pytest.importorskip(module, reason=f'the extra "{extra}" is not installed')
    blocks = BLOCKS.findall(page)
    shown = [index for index, (kind, _) in enumerate(blocks) if kind == "text"]
    assert len(shown) == 1
    (_, code), (_, wanted) = blocks[shown[0] - 1 : shown[0] + 1]
    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        exec(compile(code, f"{extra}.md", "exec"), {})
    assert out.getvalue() == wanted


def test_carla_page_code_that_needs_a_simulator_is_python() -> None:
    code = [block for kind, block in BLOCKS.findall(CARLA) if kind == "python"]
    assert len(code) == 3
    for block in code:
        compile(block, "carla.md", "exec")


HIDDEN = "import sys; sys.modules['carla'] = None\n"
WITHOUT = f"{HIDDEN}from popsteer.adapters import carla as adapter\n"
MESSAGE = (
    'CARLA\'s client needs the extra "carla" (not installed: carla): '
    'pip install "popsteer-VERSION-PLATFORM.whl[carla]"'
)


def run(code: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-c", WITHOUT + code], check=False, capture_output=True, text=True
    )


@pytest.mark.parametrize(
    "call",
    [
        "adapter.LocalPlanner(None)",
        "adapter.transform_of(0.0, 0.0, 0.0)",
        "adapter.vehicle_control(0.0, 0.0, 0.0, steering=adapter.Steering(1.0))",
        "adapter.ackermann_control(0.0, 0.0)",
    ],
)
def test_entry_names_the_extra_that_is_missing(call: str) -> None:
    ended = run(call)
    assert ended.returncode == 1
    assert ended.stderr.splitlines()[-1] == f"popsteer.extras.MissingExtra: {MESSAGE}"


def test_adapter_is_imported_without_the_client() -> None:
    ended = run("assert adapter.speed_from_kmh(36.0) == 10.0; print(*adapter.__all__)")
    assert ended.returncode == 0, ended.stderr
    assert "LocalPlanner" in ended.stdout


def test_popsteer_imports_neither_adapter_nor_client() -> None:
    code = "import sys, popsteer; sys.exit(any('carla' in name for name in sys.modules))"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_example_without_the_extra_ends_with_one_line_and_status_2() -> None:
    code = "import runpy; runpy.run_path(sys.argv.pop(), run_name='__main__')"
    ended = subprocess.run(
        [sys.executable, "-c", HIDDEN + code, "examples/carla_drive.py"],
        check=False,
        capture_output=True,
        text=True,
        cwd=ROOT,
    )
    assert (ended.returncode, ended.stderr) == (2, f"carla_drive: {MESSAGE}\n")


def test_ros2_page_names_the_topics_and_times_that_are_the_defaults() -> None:
    from popsteer.adapters.ros2.node import Options
    from popsteer.adapters.ros2.topics import Topics

    plain, autoware, options = Topics(), Topics.of_autoware(), Options()
    rows = dict(re.findall(r"^\| `(\w+)` \| (.*) \|$", ROS2, re.MULTILINE))
    for name in ("odometry", "path", "command", "predicted", "diagnostics", "clock"):
        _, default, other = rows[name].split(" | ")
        assert default.split(",")[0] == f"`{getattr(plain, name)}`"
        if getattr(autoware, name) != getattr(plain, name):
            assert other.split(",")[0] == f"`{getattr(autoware, name)}`"
    assert f"`--stale`, {options.stale:g} s" in ROS2
    assert f"`--hold`, {options.hold:g} s" in ROS2
    assert f"`--timeout`, {options.timeout:g} s" in ROS2


def test_ros2_example_without_a_node_ends_with_one_line_and_status_2() -> None:
    pytest.importorskip("cyclonedds", reason='the extra "ros2" is not installed')
    from tests.adapters.ros2_domain import domain

    ended = subprocess.run(
        [sys.executable, "examples/ros2_vehicle.py", "--timeout", "0.3"],
        check=False,
        capture_output=True,
        text=True,
        cwd=ROOT,
        env={**os.environ, "ROS_DOMAIN_ID": str(domain())},
    )
    assert ended.returncode == 2
    assert ended.stderr == "ros2_vehicle: no command on /drive for 0.3 s\n"


def test_ros2_example_is_driven_to_the_end_of_its_path_by_the_node() -> None:
    pytest.importorskip("cyclonedds", reason='the extra "ros2" is not installed')
    from tests.adapters.ros2_domain import domain

    environment = {**os.environ, "ROS_DOMAIN_ID": str(domain())}
    track, waits = ("--track", "obstacle-avoidance"), ("--timeout", str(PATIENCE))
    node_options = ("--vehicle", "paper", "--localhost", "--max-speed", "25", *waits)
    with subprocess.Popen(
        [sys.executable, "-m", "popsteer", "ros2", *node_options],
        cwd=ROOT,
        env=environment,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    ) as node:
        try:
            ended = subprocess.run(
                [sys.executable, "examples/ros2_vehicle.py", *track, *waits],
                check=False,
                capture_output=True,
                text=True,
                cwd=ROOT,
                env=environment,
                timeout=PATIENCE,
            )
        finally:
            node.terminate()
    assert (ended.returncode, ended.stderr) == (0, "")
    found = re.fullmatch(
        r"At the end of obstacle-avoidance; never farther than ([\d.]+) m from it\.\n", ended.stdout
    )
    assert found
    assert float(found[1]) < 1.0


def test_ros2_example_without_the_extra_ends_with_one_line_and_status_2() -> None:
    code = (
        "import runpy, sys; sys.modules['cyclonedds'] = None\n"
        "runpy.run_path(sys.argv.pop(), run_name='__main__')"
    )
    ended = subprocess.run(
        [sys.executable, "-c", code, "examples/ros2_vehicle.py"],
        check=False,
        capture_output=True,
        text=True,
        cwd=ROOT,
    )
    needs = 'ROS 2 needs the extra "ros2" (not installed: cyclonedds)'
    message = f'{needs}: pip install "popsteer-VERSION-PLATFORM.whl[ros2]"'
    assert (ended.returncode, ended.stderr) == (2, f"ros2_vehicle: {message}\n")


def _followed(text: str, tracking: str) -> str:
    """What the page says of a FollowPath with this text, and with this text of its feedback."""
    _, result, feedback = text.split("---\n")
    codes = "codes" if "uint16 error_code\n" in result else "no codes"
    said = " and a message" if "string error_msg\n" in result else ""
    if "TrackingFeedback tracking_feedback\n" not in feedback:
        names = re.findall(r"^\w+ (\w+)$", feedback, re.MULTILINE)
        return f"{codes}{said}; {' and '.join(each.split('_')[0] for each in names)}"
    shown = {
        "errors": ("position_tracking_error", "heading_tracking_error"),
        "pose": ("robot_pose",),
        "speed": ("speed",),
        "distance": ("distance_to_goal",),
    }
    assert all(f" {name}\n" in tracking for names in shown.values() for name in names)
    told = ", ".join(shown).replace("errors", "errors with Nav2's signs")
    return f"{codes}{said}; `tracking_feedback`: {told}"


def test_page_says_of_each_distribution_what_its_texts_have() -> None:
    for module in ("cyclonedds", "rosbags"):
        pytest.importorskip(module, reason='the extra "ros2" is not installed')
    from popsteer.adapters.ros2 import graph
    from tests.adapters.ros.interfaces import FOLLOW_PATH, TEXTS

    after = ROS2.partition("What each distribution has of this")[2].partition("\nEach action")[0]
    rows = [[each.strip() for each in row.split("|")[1:-1]] for row in after.split("\n") if row]
    named = {}
    for names, *cells in rows[3:]:
        for name in names.partition(" (")[0].split(", "):
            named[name.lower()] = cells
    assert set(named) == set(FOLLOW_PATH)
    tracking = TEXTS["nav2_lyrical_msgs/msg/TrackingFeedback"]
    for name, (action, _, bare) in named.items():
        assert action == _followed(FOLLOW_PATH[name], tracking), name
        old = bare == "gids of 24 bytes, no type hashes"
        assert old == (name in graph._OLD), name
