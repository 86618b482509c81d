"""The node in a ROS installation, with a kinematic car: lifecycle, parameters, tf, FollowPath."""

from __future__ import annotations

import itertools
import math
from typing import Any

import pytest

pytest.importorskip("ready")  # before all that is ROS's

import rclpy
import rclpy.clock
from ackermann_msgs.msg import AckermannDrive, AckermannDriveStamped
from builtin_interfaces.msg import Time
from geometry_msgs.msg import TransformStamped, TwistStamped
from nav2_msgs.action import FollowPath
from nav_msgs.msg import Path
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile
from rosgraph_msgs.msg import Clock
from tf2_ros import StaticTransformBroadcaster
from world import WHEELBASE, Car, path

import popsteer
from popsteer.adapters.ros2 import messages
from tests.bags import recorded

SUCCEEDED, CANCELED, ABORTED = 4, 5, 6


def test_lifecycle_goes_both_ways_and_ends_with_a_command_to_stand() -> None:
    car = Car()
    state = lambda: car.track._state_machine.current_state[1]  # noqa: E731
    assert state() == "unconfigured"
    car.start()
    assert state() == "active"
    assert car.until(lambda: car.odometry.get_subscription_count() > 0)
    assert car.until(lambda: car.track.core.intake.measured is not None)
    assert car.until(lambda: car.paths.get_subscription_count() > 0)
    car.paths.publish(path(0.0, 50.0))
    assert car.until(lambda: car.speed > 0.5)
    car.track.trigger_deactivate()
    assert state() == "inactive"
    assert car.until(lambda: car.commands[-1].drive.speed == 0.0)
    assert car.until(lambda: car.node.count_publishers("/drive") == 0)
    car.track.trigger_cleanup()
    assert state() == "unconfigured"
    car.start()
    assert state() == "active"
    car.close()


def test_vehicle_that_is_none_is_refused_when_configured() -> None:
    car = Car(vehicle="nowhere.toml")
    car.track.trigger_configure()
    assert car.track._state_machine.current_state[1] == "unconfigured"
    car.close()


def test_activation_that_fails_says_why_and_can_be_tried_again(
    capfd: pytest.CaptureFixture[str], tmp_path: Any
) -> None:
    car = Car(record=str(tmp_path / "drive.bag"))
    car.track.trigger_configure()
    car.track.trigger_activate()
    assert car.track._state_machine.current_state[1] == "inactive"
    assert "not activated" in (said := capfd.readouterr().err)
    assert "drive.bag" in said
    car.track.set_parameters([Parameter("record", value=str(tmp_path / "drive.mcap"))])
    car.track.trigger_activate()
    assert car.track._state_machine.current_state[1] == "active"
    assert car.until(lambda: car.track.core.intake.measured is not None)
    car.track.trigger_deactivate()
    from popsteer import logs

    with pytest.raises(popsteer.PopsteerError):  # no steering in it, but it is a file of messages
        logs.read(tmp_path / "drive.mcap")
    assert (tmp_path / "drive.mcap").stat().st_size > 1000
    car.close()


def test_drive_is_recorded_to_its_last_command(tmp_path: Any) -> None:
    file = tmp_path / "drive.mcap"
    car = Car(record=str(file)).drive()
    taken = car.track.core.intake.odometry
    assert car.until(lambda: taken.received > 50 and car.track.core.loop.cycles > 50)
    car.track.trigger_deactivate()
    commands, odometry = recorded(file, messages.ACKERMANN), recorded(file, messages.ODOMETRY)
    assert max(each.drive.speed for each in commands) > 1.0
    assert commands[-1].drive.speed == 0.0
    assert len(odometry) > 25
    assert len(recorded(file, messages.PATH)) > 1  # what was planned, and what was intended
    car.close()


def test_controller_preset_parameters_adaptation_and_monitor_are_parameters(tmp_path: Any) -> None:
    file = tmp_path / "tuned.toml"
    car = Car(controller="stanley", set=["cross_track_gain=1.7"], adapt=False, monitor=False)
    driver = car.drive().track.core.driver
    assert driver.controller == popsteer.StanleyParams(cross_track_gain=1.7)
    assert (driver.adapt, driver.monitor) == (None, None)
    car.track.trigger_deactivate()
    watched = {"monitor": True, "set": ["deviation_limit=0.7"]}
    car.track.set_parameters([Parameter(name, value=value) for name, value in watched.items()])
    make, _ = car.track._named
    assert make(popsteer.Path([(0.0, 0.0), (9.0, 0.0)])).monitor.deviation_limit == 0.7
    changed = car.track.set_parameters([Parameter("set", value=["no_gain=1.0"])])[0]
    assert "no_gain" in changed.reason
    changed = car.track.set_parameters([Parameter("params", value=str(file))])[0]
    assert not changed.successful
    car.close()


def test_start_in_a_bend_goes_on_from_the_angle_of_the_wheels() -> None:
    for reported in (True, False):
        car = Car(steering="steering" if reported else "", max_speed=4.0)
        if reported:
            report = car.node.create_publisher(AckermannDriveStamped, "steering", 1)
            drive = AckermannDrive(steering_angle=0.13)
            tell = lambda r=report, d=drive: r.publish(AckermannDriveStamped(drive=d))  # noqa: E731
            car.node.create_timer(0.02, tell)
        car.turns = not reported
        car.speed, car.steer = 3.0, 0.13
        car.start()
        assert car.until(lambda c=car: c.paths.get_subscription_count() > 0)
        assert car.until(lambda c=car: c.track.core.intake.measured is not None)
        if reported:
            signals, now = car.track.core.signals, car.track.now
            assert car.until(lambda s=signals, n=now: s.steer(1e-9 * n(), 0.3) is not None)
        car.paths.publish(circle(car, 0.13))
        assert car.until(lambda c=car: c.commands)
        assert car.commands[0].drive.steering_angle == pytest.approx(0.13, abs=0.02)
        car.close()


def circle(car: Car, steer: float) -> Path:
    found = path(0.0, 20.0)
    radius = WHEELBASE / math.tan(steer)
    for k, each in enumerate(found.poses):
        turn = car.yaw + 0.5 * k / radius
        place = each.pose.position
        place.x = car.x + radius * (math.sin(turn) - math.sin(car.yaw))
        place.y = car.y - radius * (math.cos(turn) - math.cos(car.yaw))
    return found


def test_parameters_change_while_it_drives_and_are_checked() -> None:
    car = Car().start()
    change = lambda **values: car.track.set_parameters(  # noqa: E731
        [Parameter(name, value=value) for name, value in values.items()]
    )[0]
    assert change(hold=0.5).successful
    assert car.track.core.options.hold == 0.5
    assert not change(hold=-1.0).successful
    assert not change(hold="long").successful
    refused = change(controller="pop")
    assert (refused.successful, refused.reason) == (
        False,
        "controller can be changed while the node is inactive",
    )
    car.close()


def test_parameters_that_are_set_together_are_all_taken_or_none() -> None:
    car = Car().start()
    both = [Parameter("hold", value=0.5), Parameter("controller", value="pop")]
    assert not car.track.set_parameters_atomically(both).successful
    assert (car.track.value("hold"), car.track.core.options.hold) == (0.2, 0.2)
    car.close()


def test_parameters_that_change_while_it_is_inactive_are_checked_and_count() -> None:
    car = Car()
    car.track.trigger_configure()
    for name, value, said in (
        ("command_type", "sail", "unknown command_type"),
        ("controller", "sail", "unknown controller"),
        ("vehicle", "nowhere.toml", "nowhere.toml"),
        ("path_file", "nowhere.csv", "nowhere.csv"),
    ):
        refused = car.track.set_parameters([Parameter(name, value=value)])[0]
        assert not refused.successful
        assert said in refused.reason
    car.track.set_parameters([Parameter("base_frame", value="axle")])
    car.track.trigger_activate()
    assert car.track.frames.base == "axle"
    car.close()


def test_path_file_that_is_none_is_refused_when_configured() -> None:
    car = Car(path_file="nowhere.csv")
    car.track.trigger_configure()
    assert car.track._state_machine.current_state[1] == "unconfigured"
    car.close()


def test_steps_go_on_at_the_rate_where_no_odometry_comes() -> None:
    car = Car().start()
    core = car.track.core
    assert car.until(lambda: core.intake.measured is not None)
    car.publishes = False
    assert car.until(lambda: core.waits == "no odometry on /odom for 0.3 s")
    cycle, taken = core.cycle, []

    def counted(now: int, dt: float, missed: int = 0) -> Any:
        taken.append((now, dt, missed))
        return cycle(now, dt, missed)

    core.cycle = counted
    assert car.until(lambda: len(taken) > 100, 60.0)
    due, begun = 0.0, taken[0][0]
    for now, _, missed in taken[1:]:
        due += 0.02 * (1 + missed)  # a machine that is busy misses some
        assert abs(1e-9 * (now - begun) - due) < 0.02
    assert 1e-9 * (now - begun) == pytest.approx(sum(dt for _, dt, _ in taken[1:]))
    car.close()


def test_localisation_that_dies_is_stopped_for_and_gone_on_with() -> None:
    car = Car(drifts=True).start()
    assert car.until(lambda: car.paths.get_subscription_count() > 0)
    assert car.until(lambda: car.track.core.intake.measured is not None)
    car.paths.publish(path(0.0, 200.0))
    assert car.until(lambda: car.speed > 1.0)
    car.localised = False  # odometry goes on
    assert car.until(lambda: car.track.core.state == "standing")
    assert "transform from 'odom' to 'map' is" in car.track.core.reason
    car.localised = True
    assert car.until(lambda: car.speed > 1.0)
    car.close()


def test_rear_axle_is_where_tf_has_it_and_is_waited_for() -> None:
    car = Car(base_frame="front", rear_axle_frame="wheels").start()
    assert car.until(lambda: car.paths.get_subscription_count() > 0)
    assert car.until(lambda: car.odometry.get_subscription_count() > 0)
    car.paths.publish(path(0.0, 200.0))
    said = lambda: car.track.core.waits  # noqa: E731
    assert car.until(lambda: "no transform from 'front' to 'base_link'" in said())
    broadcaster = StaticTransformBroadcaster(car.node)

    def tell(parent: str, child: str, ahead: float) -> TransformStamped:
        found = TransformStamped()
        found.header.frame_id, found.child_frame_id = parent, child
        found.transform.translation.x, found.transform.rotation.w = ahead, 1.0
        return found

    broadcaster.sendTransform([tell("base_link", "chassis", -0.5), tell("base_link", "front", 2.4)])
    assert car.until(lambda: "no transform from 'wheels' to 'front'" in said())
    assert car.speed == 0.0
    broadcaster.sendTransform(tell("chassis", "wheels", 0.2))
    assert car.until(lambda: car.speed > 1.0)
    assert car.track.core.driver.vehicle.rear_axle == pytest.approx(-2.7)
    assert car.track.core.intake.measured.x == pytest.approx(car.x + 2.4, abs=0.3)
    car.close()


@pytest.mark.parametrize("durability", ["volatile", "transient_local"])
def test_path_that_was_sent_before_is_heard_by_an_override_of_the_qos_alone(
    durability: str,
) -> None:
    kept = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    car = Car(**{"qos_overrides./path.subscription.durability": durability})
    planner = car.node.create_publisher(Path, "path", kept)
    planner.publish(path(0.0, 50.0))
    car.start()
    assert car.until(lambda: car.track.core.intake.measured is not None)
    hears = durability == "transient_local"
    assert car.until(lambda: car.speed > 0.5, 20.0 if hears else 3.0) == hears
    car.close()


def test_last_path_stays_for_a_time_where_those_after_it_are_refused() -> None:
    car = Car(keep_path=3.0).drive()
    core, states = car.track.core, []
    cycle = core.cycle

    def noted(now: int, dt: float, missed: int = 0) -> Any:
        done = cycle(now, dt, missed)
        since = core.intake.course_refused_at
        states.extend([(1e-9 * now - since, core.state)] if core.intake.course_refused else [])
        return done

    core.cycle = noted
    car.paths.publish(Path())
    assert car.until(lambda: core.state == "standing")
    # By the node's clock, however late this process sees it.
    assert {state for after, state in states if after <= 3.0} == {"driving"}
    assert "driving" not in {state for after, state in states if after > 3.0}
    assert "refused" in core.reason
    car.paths.publish(path(car.x, 200.0))
    assert car.until(lambda: car.speed > 1.0)
    car.close()


def test_goal_in_a_map_that_odometry_drifts_in_is_reached() -> None:
    car = Car(drifts=True).start()
    handle = car.goal()
    assert handle.accepted
    assert car.outcome(handle) == (SUCCEEDED, 0)
    assert car.farthest < 0.1
    assert abs(car.x - 12.0) < 0.4
    assert [each.distance_to_goal for each in car.feedback][-1] < 0.5
    assert car.until(lambda: car.track.core.state == "standing")
    assert car.track.core.reason == "the goal has ended"
    car.close()


def test_goal_that_is_cancelled_stands_and_the_next_one_drives() -> None:
    car = Car().start()
    handle = car.goal(40.0)
    assert car.until(lambda: car.speed > 1.0)
    cancelled = handle.cancel_goal_async()
    assert car.until(cancelled.done)
    assert car.outcome(handle)[0] == CANCELED
    assert car.until(lambda: car.speed == 0.0)
    assert car.outcome(car.goal(4.0)) == (SUCCEEDED, 0)
    car.close()


def test_goal_is_preempted_by_another_which_is_driven(capfd: pytest.CaptureFixture[str]) -> None:
    car = Car().start()
    first = car.goal(40.0)
    assert car.until(lambda: car.speed > 1.0)
    second = car.goal(12.0)
    assert car.outcome(first)[0] == ABORTED
    speed = car.speed
    assert speed > 0.5  # it does not stop in between
    assert car.outcome(second) == (SUCCEEDED, 0)
    assert "goal ended" not in capfd.readouterr().err  # a planner sends one each second
    car.close()


def test_goals_that_cannot_be_driven_are_aborted_with_their_codes() -> None:
    codes = FollowPath.Result
    car = Car(progress_time=1.5).start()
    assert car.outcome(car.goal(0.0)) == (ABORTED, codes.INVALID_PATH)
    lost = car.goal(40.0)
    assert car.until(lambda: car.speed > 1.0)
    car.publishes = False  # the odometry dies
    assert car.outcome(lost) == (ABORTED, codes.TF_ERROR)
    car.publishes = True
    assert car.outcome(car.goal(4.0)) == (SUCCEEDED, 0)
    assert car.outcome(car.goal(4.0, "nowhere")) == (ABORTED, codes.TF_ERROR)
    car.publishes = False
    assert not car.until(lambda: False, 0.5)
    # It does not know its place: that it stands at the end of the last path is no success.
    assert car.outcome(car.goal(40.0)) == (ABORTED, codes.TF_ERROR)
    car.publishes = True
    stuck = car.goal(40.0)
    car.obey = lambda _: None  # type: ignore[method-assign]
    car.node.destroy_subscription(next(iter(car.node.subscriptions)))
    car.speed = 0.0
    assert car.outcome(stuck) == (ABORTED, codes.FAILED_TO_MAKE_PROGRESS)
    car.close()


def test_goals_of_a_planner_that_plans_anew_make_progress_together() -> None:
    given = {"progress_time": 2.0, "progress_distance": 0.5, "max_speed": 0.6}
    car = Car(use_sim_time=True, **given).simulate()

    def planned(ticks: int) -> Any:
        """The result of a goal on which the next follows after half a second, 0.3 m at most."""
        ended = car.goal(400.0).get_result_async()
        for _ in range(ticks):
            car.tick()
        assert car.until(lambda: car.feedback)
        return ended

    goals = [planned(25) for _ in range(10)]
    assert car.speed > 0.5
    assert car.x > 1.5
    assert car.until(lambda: all(each.done() for each in goals[:-1]))
    said = {each.result().result.error_msg for each in goals[:-1]}
    assert said == {"preempted by another goal"}
    assert not goals[-1].done()
    car.stall()
    # It came nearer by 0.5 m within the last 0.9 s: it fails after 1.1 to 2 s, not before.
    goals = [planned(25) for _ in range(2)]
    assert not goals[-1].done()
    ended = planned(60)
    assert car.until(ended.done)
    assert ended.result().result.error_code == FollowPath.Result.FAILED_TO_MAKE_PROGRESS
    car.close()


def test_twist_turns_by_the_wheelbase() -> None:
    car = Car(command_type="twist_stamped").start()
    twists: list[Any] = []
    car.node.create_subscription(TwistStamped, "cmd_vel", twists.append, 10)
    drives: list[Any] = []
    core = car.track.core
    cycle = core.cycle

    def kept(*given: Any) -> Any:
        drives.extend([each for each in [cycle(*given)] if each is not None])
        return core.drive

    core.cycle = kept
    car.y = 0.5  # it steers to the right
    assert car.until(lambda: car.track.core.intake.measured is not None)
    car.speed = 1.0
    car.paths.publish(path(0.0, 50.0))
    assert car.until(lambda: len(twists) > 3)
    twist, wheelbase = twists[-1], car.track.core.driver.vehicle.wheelbase
    assert twist.header.frame_id == "base_link"
    assert twist.twist.angular.z < 0.0
    rates = [each.speed * math.tan(each.steer) / wheelbase for each in drives]
    assert min(abs(each - twist.twist.angular.z) for each in rates) < 1e-6
    car.close()


def test_simulated_time_gives_the_periods_and_one_that_begins_anew_is_driven_on() -> None:
    car = Car(use_sim_time=True)
    car.node.set_parameters([Parameter("use_sim_time", value=True)])
    clock = car.node.create_publisher(Clock, "/clock", 1)
    ticks = itertools.count()

    def tick() -> None:
        k = next(ticks)
        begin, at = (100, k) if k < 300 else (50, k - 300)
        now = begin * 10**9 + at * 20_000_000
        clock.publish(Clock(clock=Time(sec=now // 10**9, nanosec=now % 10**9)))

    steady = rclpy.clock.Clock(clock_type=rclpy.clock.ClockType.STEADY_TIME)
    car.node.create_timer(0.01, tick, clock=steady)  # twice as fast as real time
    assert car.until(lambda: car.track.now() > 100 * 10**9)
    car.start()
    assert car.until(lambda: car.paths.get_subscription_count() > 0)
    assert car.until(lambda: car.track.core.intake.measured is not None)
    car.paths.publish(path(0.0, 200.0))
    assert car.until(lambda: car.speed > 0.5)
    assert car.track.core.loop.mean_period < 0.2
    assert car.until(lambda: car.track.core.loop.jumps > 0)
    assert car.until(lambda: car.track.core.state == "driving")
    car.close()


def test_bond_tells_the_manager_that_the_node_lives_while_it_is_active() -> None:
    bond = pytest.importorskip("bond.msg")
    car = Car()
    heard: list[Any] = []
    car.node.create_subscription(bond.Status, "bond", heard.append, 10)
    car.start()
    assert car.until(lambda: len(heard) > 3)
    assert {(each.id, each.active, each.instance_id) for each in heard} == {
        ("popsteer", True, heard[0].instance_id)
    }
    car.track.trigger_deactivate()
    assert car.until(lambda: not heard[-1].active)
    car.close()


def test_autoware_takes_another_type_of_command_where_that_is_asked_for() -> None:
    car = Car(autoware=True, command_type="twist").start()
    topics = car.track.core.options.topics
    assert (topics.command_type, topics.path_type) == (
        "geometry_msgs/msg/Twist",
        "autoware_planning_msgs/msg/Trajectory",
    )
    car.close()
    car = Car(autoware=True).start()
    assert car.track.core.options.topics.command_type == "autoware_control_msgs/msg/Control"
    assert car.track.core.options.topics.operation_mode == "/system/operation_mode/state"
    car.close()


def test_raceline_of_f1tenth_is_read_once_and_driven_at_its_speeds(
    tmp_path: Any, capfd: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "line.csv"
    head = "# s_m; x_m; y_m; psi_rad; kappa_radpm; vx_mps; ax_mps2\n"
    file.write_text(f"{head}0; 0; 0; 0; 0; 3; 0\n25; 25; 0; 0; 0; 3; 0\n50; 50; 0; 0; 0; 3; 0\n")
    car = Car(path_file=str(file)).start()
    assert capfd.readouterr().err.count("read line.csv") == 1
    assert car.until(lambda: car.speed > 2.9)
    assert not car.until(lambda: car.speed > 3.3, 1.0)
    car.close()
