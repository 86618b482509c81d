"""The node as a process of its own: how it ends, its services, and names in a namespace."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from contextlib import contextmanager
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

import pytest

pytest.importorskip("ready")  # before all that is ROS's

from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState
from rcl_interfaces.srv import GetParameters, SetParameters
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy
from std_srvs.srv import Trigger
from world import Car, path

from tests.helpers import PATIENCE

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

ARGUMENTS = ["vehicle:=paper", "max_speed:=4.0"]
NODE = [sys.executable, "-c", "from popsteer_ros.node import main; main()", "--ros-args"]


@contextmanager
def started(command: list[str]) -> Iterator[Any]:
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, start_new_session=True
    ) as process:
        try:
            yield process
        finally:
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGKILL)


@pytest.fixture
def node() -> Iterator[Any]:
    """The node of `ARGUMENTS`, configured and active."""
    with started([*NODE, *(word for each in ARGUMENTS for word in ("-p", each))]) as process:
        car = Car(outside=True)
        for each in (Transition.TRANSITION_CONFIGURE, Transition.TRANSITION_ACTIVATE):
            assert call(car, ChangeState, "change_state", transition=Transition(id=each)).success
        car.close()
        yield process


def driving() -> Car:
    car = Car(outside=True)
    assert car.until(lambda: car.paths.get_subscription_count() > 0)
    car.paths.publish(path(0.0, 400.0))
    assert car.until(lambda: car.speed > 3.0)
    return car


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_node_that_is_ended_in_mid_drive_commands_to_stand(node: Any, number: int) -> None:
    car = driving()
    node.send_signal(number)
    node.send_signal(number)  # a terminal and `ros2 launch` may both send it
    assert car.until(lambda: car.commands[-1].drive.speed == 0.0)
    said, _ = node.communicate(timeout=PATIENCE)
    assert node.returncode == 0, said
    assert "Traceback" not in said
    car.close()


def call(car: Car, kind: Any, name: str, of: str = "/popsteer", **values: Any) -> Any:
    client = car.node.create_client(kind, f"{of}/{name}")
    assert car.until(client.service_is_ready)
    answer = client.call_async(kind.Request(**values))
    assert car.until(answer.done)
    return answer.result()


def test_services_change_states_and_parameters_of_the_process(node: Any) -> None:
    car = driving()
    hold = Parameter("hold", value=0.4).to_parameter_msg()
    assert call(car, SetParameters, "set_parameters", parameters=[hold]).results[0].successful
    hold.value.double_value = -1.0
    assert not call(car, SetParameters, "set_parameters", parameters=[hold]).results[0].successful
    assert call(car, Trigger, "reset").message == "there is no fault"
    change = Transition(id=Transition.TRANSITION_DEACTIVATE)
    assert call(car, ChangeState, "change_state", transition=change).success
    assert car.until(lambda: car.speed == 0.0)
    change = Transition(id=Transition.TRANSITION_ACTIVATE)
    assert call(car, ChangeState, "change_state", transition=change).success
    assert car.until(lambda: car.paths.get_subscription_count() > 0)
    car.paths.publish(path(car.x, 400.0))
    assert car.until(lambda: car.speed > 3.0)
    assert node.poll() is None
    car.close()


FILE = """/**:
  ros__parameters:
    hold: 0.1
    keep_path: 2.0
    qos_overrides:
      /path:
        subscription:
          durability: transient_local
"""


@pytest.mark.skipif(find_spec("launch_ros") is None, reason="launch_ros has no wheel")
def test_launch_file_takes_parameters_a_file_of_them_and_topics(tmp_path: Path) -> None:
    file = tmp_path / "params.yaml"
    file.write_text(FILE, encoding="utf-8")
    given = [*ARGUMENTS, f"params_file:={file}", "namespace:=ego", "odom:=/odom", "closed:=true"]
    given += ["hold:=0.4", "path:=/path", "drive:=/drive"]
    car = Car(outside=True)
    with started(["ros2", "launch", "popsteer_ros", "track.launch.py", *given]) as launched:
        assert car.until(lambda: car.node.count_subscribers("/path") > 0)
        wanted = ["hold", "keep_path", "max_speed", "closed", "stale"]
        values = call(car, GetParameters, "get_parameters", "/ego/popsteer", names=wanted).values
        hold, keep, fastest, closed, stale = values
        assert (hold.double_value, keep.double_value, fastest.double_value) == (0.4, 2.0, 4.0)
        assert (closed.bool_value, stale.double_value) == (True, 0.3)
        there = car.node.get_subscriptions_info_by_topic("/path")
        assert {each.qos_profile.durability for each in there} == {DurabilityPolicy.TRANSIENT_LOCAL}
        assert car.node.count_subscribers("/odom") > 0
        assert car.until(lambda: car.node.count_publishers("/drive") == 1)
        assert launched.poll() is None
    car.close()


def test_transitions_that_cannot_be_are_refused_and_end_no_drive(node: Any) -> None:
    car = driving()
    for label, number in (("", Transition.TRANSITION_CONFIGURE), ("", 99), ("fly", 0)):
        change = Transition(id=number, label=label)
        assert not call(car, ChangeState, "change_state", transition=change).success
    before = len(car.commands)
    assert car.until(lambda: len(car.commands) > before + 25)
    assert min(each.drive.speed for each in car.commands[before:]) > 3.0
    assert node.poll() is None
    car.close()


def test_goal_has_a_result_where_the_process_ends(node: Any) -> None:
    car = Car(outside=True)
    ended = car.goal(100.0).get_result_async()
    assert car.until(lambda: car.speed > 1.0)
    node.send_signal(signal.SIGTERM)
    assert car.until(ended.done)
    assert ended.result().result.error_msg == "the process ends"
    assert car.until(lambda: car.commands[-1].drive.speed == 0.0)
    car.close()
