"""What the launch file starts, by stand-ins of launch and launch_ros, which have no wheels."""

from __future__ import annotations

import runpy
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import pytest

pytest.importorskip("ready")  # before all that is ROS's

from lifecycle_msgs.msg import Transition
from popsteer_ros.node import PARAMETERS

FILE = Path(__file__).parents[1] / "launch" / "track.launch.py"
STAND_INS = {
    "launch": ["LaunchDescription"],
    "launch.actions": [
        "DeclareLaunchArgument",
        "EmitEvent",
        "OpaqueFunction",
        "RegisterEventHandler",
    ],
    "launch.events": ["matches_action"],
    "launch.substitutions": ["LaunchConfiguration"],
    "launch_ros": [],
    "launch_ros.actions": ["LifecycleNode"],
    "launch_ros.event_handlers": ["OnStateTransition"],
    "launch_ros.events": [],
    "launch_ros.events.lifecycle": ["ChangeState"],
    "launch_ros.parameter_descriptions": ["ParameterFile", "ParameterValue"],
}
TOPICS = {
    "odom": "odom",
    "path": "path",
    "drive": "drive",
    "cmd_vel": "cmd_vel",
    "speed_limit": "speed_limit",
    "tf": "/tf",  # where tf2 looks for it whatever the namespace
    "tf_static": "/tf_static",
}


class Recorded:
    """An object of launch: what it was made with."""

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        self.args, self.kwargs = args, kwargs


@pytest.fixture
def described(monkeypatch: pytest.MonkeyPatch) -> Any:
    """What the launch file describes."""
    for name, classes in STAND_INS.items():
        module = ModuleType(name)
        vars(module).update({each: type(each, (Recorded,), {}) for each in classes})
        monkeypatch.setitem(sys.modules, name, module)
    return runpy.run_path(str(FILE))["generate_launch_description"]()


def started(described: Any, **given: str) -> list[Any]:
    """What is started with these arguments; all others have their default, as in launch."""
    *arguments, opaque = described.args[0]
    values = {each.args[0]: each.kwargs["default_value"] for each in arguments}
    assert set(given) <= set(values)
    context = SimpleNamespace(launch_configurations=values | given)
    found: list[Any] = opaque.kwargs["function"](context)
    return found


def node(described: Any, **given: str) -> dict[str, Any]:
    (found,) = [
        each for each in started(described, **given) if type(each).__name__ == "LifecycleNode"
    ]
    return dict(found.kwargs)


def test_each_topic_is_remapped_where_it_is_given_and_there_alone(described: Any) -> None:
    assert node(described)["remappings"] == []
    for argument, topic in TOPICS.items():
        assert node(described, **{argument: "/car/it"})["remappings"] == [(topic, "/car/it")]
    both = node(described, tf="tf", tf_static="tf_static", namespace="ego")
    assert both["remappings"] == [("/tf", "tf"), ("/tf_static", "tf_static")]


def test_node_has_the_name_and_the_namespace_that_are_given(described: Any) -> None:
    plain, other = node(described), node(described, name="steer", namespace="ego")
    assert (plain["name"], plain["namespace"]) == ("popsteer", "")
    assert (other["name"], other["namespace"]) == ("steer", "ego")
    assert (plain["package"], plain["executable"]) == ("popsteer_ros", "track")


def test_parameters_that_are_given_go_after_the_file_and_have_their_kind(described: Any) -> None:
    assert node(described)["parameters"] == [{}]
    file, given = node(described, params_file="a.yaml", hold="0.4", use_sim_time="true")[
        "parameters"
    ]
    assert file.args == ("a.yaml",)
    kinds = {name: each.kwargs["value_type"] for name, each in given.items()}
    assert kinds == {"hold": float, "use_sim_time": bool}
    assert {each.args[0].args[0] for each in given.values()} == set(kinds)


def test_every_parameter_and_topic_is_an_argument_that_says_what_it_is(described: Any) -> None:
    said = {each.args[0]: each.kwargs["description"] for each in described.args[0][:-1]}
    others = {"use_sim_time", "name", "namespace", "params_file"}
    assert set(said) == {*PARAMETERS, *others, *TOPICS}
    assert all(said.values())


def test_node_is_configured_and_activated_once_it_is(described: Any) -> None:
    activate, made, configure = started(described)

    def change(event: Any) -> int:
        matcher = event.kwargs["event"].kwargs
        assert matcher["lifecycle_node_matcher"].args == (made,)
        return int(matcher["transition_id"])

    assert change(configure) == Transition.TRANSITION_CONFIGURE
    when = activate.args[0].kwargs
    assert when["target_lifecycle_node"] is made
    assert (when["start_state"], when["goal_state"]) == ("configuring", "inactive")
    assert [change(each) for each in when["entities"]] == [Transition.TRANSITION_ACTIVATE]
