"""The node as a process of its own, from its launch file: how it ends, and names in a namespace."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
import rclpy
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState
from rcl_interfaces.srv import GetParameters, SetParameters
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy
from std_srvs.srv import Trigger

sys.path.insert(0, str(Path(__file__).parent))
from test_track import Car, path

if TYPE_CHECKING:
    from collections.abc import Iterator


ARGUMENTS = ["vehicle:=paper", "max_speed:=4.0"]


@pytest.fixture
def launched(request: Any) -> Iterator[Any]:
    rclpy.init()
    arguments = getattr(request, "param", ARGUMENTS)
    command = ["ros2", "launch", "popsteer_ros", "track.launch.py", *arguments]
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, start_new_session=True
    ) as process:
        yield process
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)
    rclpy.try_shutdown()


def driving() -> Car:
    car = Car(outside=True)
    assert car.until(lambda: car.paths.get_subscription_count() > 0)
    car.paths.publish(path(0.0, 400.0))
    assert car.until(lambda: car.speed > 3.0)
    return car


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_node_that_is_ended_in_mid_drive_commands_to_stand(launched: Any, number: int) -> None:
    car = driving()
    children = Path(f"/proc/{launched.pid}/task/{launched.pid}/children")
    node = int(children.read_text(encoding="utf-8").split()[0])  # the launch file starts it
    os.kill(node, number)
    os.kill(node, number)  # a terminal and `ros2 launch` may both send it
    assert car.until(lambda: car.commands[-1].drive.speed == 0.0, 5.0)
    said, _ = launched.communicate(timeout=20.0)
    assert "finished cleanly" in said
    assert "Traceback" not in said
    car.close()


def call(car: Car, kind: Any, name: str, **values: Any) -> Any:
    client = car.node.create_client(kind, f"/popsteer/{name}")
    assert car.until(client.service_is_ready)
    answer = client.call_async(kind.Request(**values))
    assert car.until(answer.done)
    return answer.result()


def test_services_change_states_and_parameters_of_the_process(launched: Any) -> None:
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
    assert launched.poll() is None
    car.close()


FILE = Path(tempfile.gettempdir()) / "popsteer-launch.yaml"
FILE.write_text(
    """/**:
  ros__parameters:
    hold: 0.1
    keep_path: 2.0
    qos_overrides:
      /path:
        subscription:
          durability: transient_local
""",
    encoding="utf-8",
)
GIVEN = [*ARGUMENTS, f"params_file:={FILE}", "namespace:=ego", "odom:=/odom", "closed:=true"]


@pytest.mark.parametrize(
    "launched", [[*GIVEN, "hold:=0.4", "path:=/path", "drive:=/drive"]], indirect=True
)
def test_launch_file_takes_parameters_a_file_of_them_and_topics(launched: Any) -> None:
    car = Car(outside=True)
    assert car.until(lambda: car.node.count_subscribers("/path") > 0)
    wanted = ["hold", "keep_path", "max_speed", "closed", "stale"]
    request = GetParameters.Request(names=wanted)
    client = car.node.create_client(GetParameters, "/ego/popsteer/get_parameters")
    assert car.until(client.service_is_ready)
    answer = client.call_async(request)
    assert car.until(answer.done)
    hold, keep, fastest, closed, stale = answer.result().values
    assert (hold.double_value, keep.double_value, fastest.double_value) == (0.4, 2.0, 4.0)
    assert (closed.bool_value, stale.double_value) == (True, 0.3)
    there = lambda: car.node.get_subscriptions_info_by_topic("/path")  # noqa: E731
    durabilities = lambda: {each.qos_profile.durability for each in there()}  # noqa: E731
    # Until those of the test before are forgotten.
    assert car.until(lambda: durabilities() == {DurabilityPolicy.TRANSIENT_LOCAL})
    assert car.node.count_subscribers("/odom") > 0
    assert car.until(lambda: car.node.count_publishers("/drive") == 1)
    assert launched.poll() is None
    car.close()
