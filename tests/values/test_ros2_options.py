"""Names, ranges and intake of the ROS 2 node, field by field."""

from __future__ import annotations

import math
from dataclasses import fields, replace
from typing import Any

import pytest

import popsteer
from popsteer.adapters import ros2
from popsteer.errors import ConfigError

pytest.importorskip("rosbags", reason='the extra "ros2" is not installed')

from popsteer.adapters.ros2 import conversions, messages, paths
from popsteer.adapters.ros2.intake import Intake
from popsteer.adapters.ros2.topics import Topics

NAMES = [each.name for each in fields(Topics) if not each.name.endswith("_type")]


def test_every_topic_takes_a_name_of_ros_alone_and_one_of_its_own() -> None:
    for name in NAMES:
        assert getattr(replace(Topics(), **{name: "/a/b_1"}), name) == "/a/b_1"
        for bad in ("a", "/", "/1a", "/a//b", "/a b", "/a/", f"/{'a' * 247}"):
            with pytest.raises(ConfigError, match=f"topic {name}"):
                replace(Topics(), **{name: bad})
        other = "path" if name != "path" else "command"
        with pytest.raises(ConfigError, match="given once") as refused:
            replace(Topics(), **{name: getattr(Topics(), other)})
        assert {name, other} <= set(str(refused.value).replace(",", " ").split())
    assert replace(Topics(), odometry=f"/{'a' * 246}").odometry == f"/{'a' * 246}"


def test_every_topic_has_its_type_and_its_new_name() -> None:
    for topics in (Topics(), Topics.of_autoware(), Topics(mode="/mode")):
        types = topics.types()
        named = [getattr(topics, name) for name in NAMES if getattr(topics, name)]
        assert sorted(types) == sorted(named)
        assert types[topics.path] == topics.path_type
        assert types[topics.command] == topics.command_type
        assert types[topics.odometry] == messages.ODOMETRY
    given = {name: f"/new/{name}" for name in NAMES}
    twist = replace(Topics(), command_type="geometry_msgs/msg/Twist")
    assert twist.renamed({}, namespace="/car").command == "/car/cmd_vel"
    found = Topics().renamed(given)
    assert {name: getattr(found, name) for name in NAMES} == given
    with pytest.raises(ConfigError, match="topic"):
        Topics().renamed({"path_type": "/a"})


def test_names_are_in_the_namespace_and_rules_come_last() -> None:
    found = Topics().renamed({}, "car", "/fleet")
    assert (found.odometry, found.path, found.command) == (
        "/fleet/odom",
        "/fleet/path",
        "/fleet/drive",
    )
    assert found.predicted == "/fleet/car/predicted_path"
    assert (found.diagnostics, found.clock, found.mode) == ("/diagnostics", "/clock", "")
    found = Topics().renamed({"path": "plan"}, "car", "/fleet", {"odom": "/gps", "plan": "~/p"})
    assert (found.odometry, found.path) == ("/gps", "/fleet/car/p")
    # What has another name already keeps it.
    assert (
        Topics.of_autoware().renamed({}, "car", "/fleet").odometry
        == "/localization/kinematic_state"
    )


def test_every_option_holds_its_ends() -> None:
    ends = {
        "rate": (1.0, 1000.0),
        "stale": (0.01, 1.0),
        "hold": (0.0, 10.0),
        "keep_path": (0.0, 1e6),
        "timeout": (0.0, 1e6),
        "report_rate": (0.1, 1000.0),
    }
    numbers = {each.name for each in fields(ros2.Options) if isinstance(each.default, float)}
    assert numbers == set(ends)
    for name, (low, high) in ends.items():
        for value in (low, high):
            assert getattr(ros2.Options(**{name: value}), name) == value  # type: ignore[arg-type]
        for value in (low - 1e-6, high * 1.001, float("nan")):
            with pytest.raises(ConfigError, match=name):
                ros2.Options(**{name: value})  # type: ignore[arg-type]


def _course(intake: Intake) -> Any:
    return intake.course


def test_intake_stands_until_another_path_comes() -> None:
    intake: Any = Intake(messages.PATH, stale=0.3)
    intake.stand("the goal has ended")
    assert intake.course is None
    path = popsteer.Path([(0.0, 0.0), (9.0, 0.0)])
    intake.use(path, "map")
    assert not _course(intake).stands
    intake.stand("the goal has ended")
    assert _course(intake).stands == "the goal has ended"
    assert (_course(intake).path, intake.course_number) == (path, 1)
    again = conversions.path_message([0.0, 5.0], [0.0, 0.0], [0.0, 0.0], 0, "map")
    assert intake.take_course(messages.encode(again), 1.0)
    assert not _course(intake).stands
    assert intake.course_number == 2
    zero = "the path's speeds are 0"
    for speeds, stands in (([0.0, 0.0], zero), ([0.0, 1.0], ""), ([-1.0, -1.0], "")):
        intake.use(popsteer.Path([(0.0, 0.0), (9.0, 0.0)], speed=speeds), "map")
        assert _course(intake).stands == stands


def test_refused_path_says_since_when_and_another_one_ends_it() -> None:
    intake = Intake(messages.PATH, stale=0.3)
    bad = messages.encode(conversions.path_message([0.0], [0.0], [0.0], 0, "map"))
    good = messages.encode(conversions.path_message([0.0, 1.0], [0.0, 0.0], [0.0] * 2, 0, "map"))
    for now in (3.0, 4.0):
        assert not intake.take_course(bad, now)
    assert intake.course_refused_at == 3.0
    assert intake.course_refused
    assert intake.take_course(good, 5.0)
    assert intake.course_refused == ""
    assert not intake.take_course(bad, 6.0)
    assert intake.course_refused_at == 6.0
    assert (intake.courses.received, intake.courses.refused, intake.courses.lately) == (4, 3, 3)
    # In another frame than the odometry, as long as that is fresh.
    here: Any = conversions.odometry_message(0.0, 0.0, 0.0, 1.0, 7_000_000_000, "odom")
    intake.course = None
    assert intake.take_odometry(messages.encode(here), 7.0)
    assert not intake.take_course(good, 7.3)
    assert "'map'" in intake.course_refused
    assert intake.take_course(good, 7.31)


def test_bytes_of_a_trajectory_give_what_its_message_gives() -> None:
    def point(x: float, speed: float) -> Any:
        place = messages.make("geometry_msgs/msg/Point", x=x, y=-0.5 * x, z=9.0)
        return messages.make(
            "autoware_planning_msgs/msg/TrajectoryPoint",
            pose=messages.make("geometry_msgs/msg/Pose", position=place),
            longitudinal_velocity_mps=speed,
            lateral_velocity_mps=speed + 3.0,
        )

    points = [point(0.0, 2.0), point(5.0, 1.5), point(9.0, 0.0)]
    message = messages.make(messages.TRAJECTORY, points=points)
    data = messages.encode(message)
    for path, _ in (
        paths.path_of(message),
        (paths.points_of_bytes(messages.TRAJECTORY, data).path(), ""),
    ):
        assert path.speed is not None
        assert path.speed.tolist() == [2.0, 1.5, 0.0]
        assert path.x.tolist() == [0.0, 5.0, 9.0]
        assert path.y.tolist() == [0.0, -2.5, -4.5]


def test_speed_of_the_node_is_the_lower_of_the_vehicles_and_its_own() -> None:
    pytest.importorskip("typer")
    from popsteer.cli.ros2 import _limited

    for car, asked, wanted in ((None, 3.0, 3.0), (10.0, 3.0, 3.0), (2.0, 3.0, 2.0)):
        assert _limited(popsteer.Vehicle(max_speed=car), asked).max_speed == wanted


def test_angle_that_a_yaw_rate_shows_is_the_one_commanded() -> None:
    car = popsteer.Vehicle(wheelbase=2.7, understeer=0.004, steer_offset=0.02)
    for speed in (8.0, -8.0):
        rate = speed * math.tan(0.1 + 0.02) / (2.7 + 0.004 * speed**2)
        seen = conversions.Measured(0.0, 0.0, 0.0, speed, 0, "map", "base_link", rate)
        assert conversions.shown_steer(car, seen) == pytest.approx(0.1)
        # Below half a wheelbase a second the noise is more than the angle.
        for slow, shows in ((1.34, False), (1.36, True)):
            seen = seen._replace(speed=math.copysign(slow, speed))
            assert (conversions.shown_steer(car, seen) != 0.0) is shows
