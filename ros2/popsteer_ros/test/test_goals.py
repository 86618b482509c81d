"""Goals of FollowPath: who has the path, how goals end, what distributions have otherwise."""

from __future__ import annotations

import gc
from typing import Any

import numpy as np
import pytest

pytest.importorskip("ready")  # before all that is ROS's

from action_msgs.msg import GoalStatus
from geometry_msgs.msg import PoseStamped
from nav2_msgs.action import FollowPath
from nav2_msgs.msg import SpeedLimit
from popsteer_ros import goals
from rclpy.parameter import Parameter
from rclpy.serialization import deserialize_message, serialize_message
from world import Car, path

SUCCEEDED, CANCELED, ABORTED = (
    GoalStatus.STATUS_SUCCEEDED,
    GoalStatus.STATUS_CANCELED,
    GoalStatus.STATUS_ABORTED,
)


def test_goal_is_not_touched_by_the_paths_of_a_topic() -> None:
    car = Car().start()
    handle = car.goal(20.0)
    assert car.until(lambda: car.speed > 1.0)
    aside = path(car.x, 6.0, origin=(0.0, -3.0, 0.0))
    car.node.create_timer(0.1, lambda: car.paths.publish(aside))
    assert car.outcome(handle)[0] == SUCCEEDED
    assert abs(car.x - 20.0) < 0.4
    assert car.farthest < 0.01
    inputs = car.track.core.intake
    assert inputs.goals
    assert inputs.courses.reason == "goals of the action have the path"
    # And nothing drives on after it.
    car.rest(1.0)
    assert (car.speed, abs(car.x - 20.0) < 0.4) == (0.0, True)
    car.close()


def test_cancelled_goal_stands_though_a_planner_publishes_and_answers_when_it_does() -> None:
    car = Car().start()
    handle = car.goal(100.0)
    car.node.create_timer(0.1, lambda: car.paths.publish(path(car.x, 100.0)))
    assert car.until(lambda: car.speed > 4.0)
    handle.cancel_goal_async()
    assert car.outcome(handle)[0] == CANCELED
    assert car.speed == 0.0
    car.rest(1.0)
    assert car.speed == 0.0
    car.close()


def test_cancelled_goal_is_answered_though_the_odometry_is_gone() -> None:
    car = Car().start()
    handle = car.goal(100.0)
    assert car.until(lambda: car.speed > 3.0)
    car.publishes = False
    handle.cancel_goal_async()
    assert car.outcome(handle)[0] == CANCELED
    assert car.speed == 0.0
    car.close()


def test_nothing_is_commanded_after_a_goal_but_one_standstill() -> None:
    car = Car().start()
    assert car.outcome(car.goal(4.0))[0] == SUCCEEDED
    car.rest(0.3)
    assert car.commands[-1].drive.speed == 0.0
    count = len(car.commands)
    car.speed = -0.5  # a recovery backs up
    car.rest(1.0)
    assert (len(car.commands), car.speed) == (count, -0.5)
    car.speed = 0.0
    assert car.outcome(car.goal(4.0))[0] == SUCCEEDED
    car.close()


def test_goal_begins_afresh_after_one_that_ended_in_a_fault(
    capfd: pytest.CaptureFixture[str],
) -> None:
    car = Car().start()
    handle = car.goal(60.0)
    assert car.until(lambda: car.speed > 3.0)
    car.y += 8.0  # the localisation is somewhere else
    assert car.outcome(handle)[0] == ABORTED
    said = capfd.readouterr().err.splitlines()
    assert " braking: " in next(each for each in said if "[ERROR]" in each)
    assert not any(" driving" in each for each in said if "[INFO]" not in each)
    assert car.until(lambda: car.speed == 0.0)
    course = path(car.x, 6.0, origin=(0.0, -car.y, 0.0))
    assert car.outcome(car.send(course)) == (SUCCEEDED, 0)
    car.close()


def test_goal_where_the_robot_is_has_succeeded_and_no_path_elsewhere_is_one() -> None:
    car = Car().start()
    assert car.until(lambda: car.track.core.intake.measured is not None)
    assert car.outcome(car.send(path(0.1, 0.0))) == (SUCCEEDED, 0)
    codes = FollowPath.Result
    assert car.outcome(car.send(path(3.0, 0.0))) == (ABORTED, codes.INVALID_PATH)
    for frame in ("map", "", "m" * 2000):  # a path without poses is one in no frame
        assert car.outcome(car.send(path(0.0, -1.0, frame))) == (ABORTED, codes.INVALID_PATH)
    car.close()


def test_goal_has_an_end_where_paths_of_the_topic_are_closed() -> None:
    car = Car(closed=True).start()
    assert car.outcome(car.goal(6.0)) == (SUCCEEDED, 0)
    car.close()


def test_controller_that_is_not_there_aborts_a_goal_with_its_code() -> None:
    car = Car(controller_plugins=["FollowPath", "slow"]).start()
    unknown = FollowPath.Result.INVALID_CONTROLLER
    assert car.outcome(car.send(path(0.0, 4.0), "fast")) == (ABORTED, unknown)
    assert car.outcome(car.send(path(0.0, 4.0), "")) == (ABORTED, unknown)
    assert car.outcome(car.send(path(0.0, 4.0), "slow")) == (SUCCEEDED, 0)
    car.close()


def test_deactivation_ends_a_goal_with_a_result() -> None:
    car = Car().start()
    handle = car.goal(60.0)
    assert car.until(lambda: car.speed > 1.0)
    ended = handle.get_result_async()
    car.track.trigger_deactivate()
    assert car.until(ended.done)
    assert ended.result().status == ABORTED
    assert ended.result().result.error_msg == "the node is deactivated"
    assert car.until(lambda: car.speed == 0.0)
    sent = car.client.send_goal_async(FollowPath.Goal(path=path(0.0, 4.0)))
    assert car.until(sent.done)
    assert not sent.result().accepted
    car.track.trigger_activate()
    assert car.outcome(car.goal(4.0)) == (SUCCEEDED, 0)
    car.close()


def test_speed_limit_counts_while_it_drives() -> None:
    car = Car(max_speed=4.0).drive()
    limits = car.node.create_publisher(SpeedLimit, "speed_limit", 1)
    assert car.until(lambda: limits.get_subscription_count() > 0)
    for limit, wanted in (
        (SpeedLimit(percentage=True, speed_limit=50.0), 2.0),
        (SpeedLimit(speed_limit=1.5), 1.5),
        (SpeedLimit(speed_limit=0.0), 4.0),
    ):
        limits.publish(limit)
        assert car.until(lambda w=wanted: abs(car.speed - w) < 0.05), (limit, car.speed)
    assert car.track.set_parameters([Parameter("max_speed", value=3.0)])[0].successful
    assert car.until(lambda: abs(car.speed - 3.0) < 0.05)
    assert car.state == "driving"
    car.close()


def test_cusp_by_the_orientations_of_a_path_is_driven_backwards() -> None:
    car = Car(max_speed=2.0).start()
    there, back = path(0.0, 8.0), path(0.0, 8.0)
    for each in (*there.poses, *back.poses):
        each.pose.orientation.z, each.pose.orientation.w = 1e-6, 1.0  # nobody leaves it as it is
    there.poses += back.poses[-2:8:-1]
    begun = car.send(there)
    assert car.outcome(begun) == (SUCCEEDED, 0)
    distances = [each.distance_to_goal for each in car.feedback]
    assert distances[0] == pytest.approx(11.5, abs=0.5)  # beyond the cusp, too
    assert np.diff(distances).max() < 0.1
    assert car.x == pytest.approx(4.5, abs=0.4)
    assert min(each.drive.speed for each in car.commands) < -0.5
    car.close()


@pytest.mark.parametrize("distribution", ["humble", "iron", "jazzy", "lyrical"])
def test_goals_are_driven_by_the_action_that_each_distribution_has(
    monkeypatch: pytest.MonkeyPatch, distribution: str
) -> None:
    package = "nav2_msgs" if distribution == "jazzy" else f"nav2_{distribution}_msgs"
    action = pytest.importorskip(f"{package}.action").FollowPath
    monkeypatch.setattr("popsteer_ros.follow_path.FollowPath", action)
    car = Car(action=action).start()
    car.y, car.yaw = 0.1, -0.2  # on the left of the path, and it points to the right
    results = []
    for length in (8.0, -1.0):
        ended = car.send(path(0.0, length)).get_result_async()
        assert car.until(ended.done)
        results.append(ended.result())
        if length > 0.0:
            told = [getattr(each, "tracking_feedback", each) for each in car.feedback]
    assert told[0].distance_to_goal == pytest.approx(8.0, abs=0.5)
    assert told[-1].distance_to_goal < 1.0
    assert [each.status for each in results] == [SUCCEEDED, ABORTED]
    if distribution == "lyrical":
        assert told[-1].header.frame_id == told[-1].robot_pose.header.frame_id == "map"
        assert told[-1].robot_pose.pose.position.x == pytest.approx(car.x, abs=0.2)
        assert told[0].position_tracking_error == pytest.approx(0.1, abs=0.02)
        assert told[0].heading_tracking_error == pytest.approx(0.2, abs=0.02)
    code, said = (getattr(results[1].result, name, None) for name in ("error_code", "error_msg"))
    assert code == (None if distribution == "humble" else 103)
    assert (said is not None) == (distribution in ("jazzy", "lyrical"))
    car.close()


def request(count: int) -> Any:
    found = FollowPath.Impl.SendGoalService.Request()
    found.goal.path.header.frame_id, found.goal.controller_id = "map", "FollowPath"
    for k in range(count):
        pose = PoseStamped()
        pose.header.frame_id = k % 3 * "m"
        pose.pose.position.x, pose.pose.orientation.z, pose.pose.orientation.w = 0.1 * k, 0.6, 0.8
        found.goal.path.poses.append(pose)
    return found


@pytest.mark.parametrize("count", [0, 1, 2, 1000])
def test_poses_of_a_goal_as_an_array_are_those_of_the_messages(count: int) -> None:
    light = goals.light(FollowPath)
    assert light is not FollowPath  # else nothing is told here
    plain = request(count)
    found = deserialize_message(serialize_message(plain), light.Impl.SendGoalService.Request)
    assert isinstance(found.goal.path.poses, np.ndarray)
    wanted = goals.poses_of(plain.goal.path)
    assert np.array_equal(goals.poses_of(found.goal.path), wanted)
    assert (found.goal.controller_id, found.goal.path.header.frame_id) == ("FollowPath", "map")
    assert (found.goal_id.uuid == plain.goal_id.uuid).all()


def test_goal_of_10000_poses_makes_no_objects_of_them() -> None:
    data = serialize_message(request(10_000))
    made = []
    for kind in (FollowPath, goals.light(FollowPath)):
        gc.collect()
        before = len(gc.get_objects())
        found = deserialize_message(data, kind.Impl.SendGoalService.Request)
        made.append(len(gc.get_objects()) - before)
        assert len(found.goal.path.poses) == 10_000
    plain, light = made
    assert plain > 10_000
    assert light < 100


def test_replanning_keeps_no_goals_and_no_poses(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("popsteer_ros.follow_path._KEPT", 2)
    car = Car().start()
    course = path(0.0, 5000.0)
    assert len(course.poses) > 10_000
    goal = FollowPath.Goal(path=course)
    assert car.until(car.client.server_is_ready)
    there = car.track.follow._server._goal_handles
    objects: list[int] = []
    for _ in range(20):
        sent = car.client.send_goal_async(goal)
        assert car.until(sent.done)
        car.rest(0.3)
        gc.collect()
        objects.append(len(gc.get_objects()))
    assert len(there) < 12
    # Nothing grows; what is kept of a goal has no object a pose, whose collection takes a step.
    assert max(objects[8:]) < objects[7] + len(course.poses) // 2
    assert car.state == "driving"
    car.close()
