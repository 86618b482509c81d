"""ros2 launch popsteer_ros track.launch.py vehicle:=car.toml: configures and activates the node.

Each of the node's parameters is an argument; `params_file` has others, as ROS's overrides of QoS.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, EmitEvent, OpaqueFunction, RegisterEventHandler
from launch.events import matches_action
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import LifecycleNode
from launch_ros.event_handlers import OnStateTransition
from launch_ros.events.lifecycle import ChangeState
from launch_ros.parameter_descriptions import ParameterFile, ParameterValue
from lifecycle_msgs.msg import Transition
from popsteer_ros.node import PARAMETERS

if TYPE_CHECKING:
    from launch import LaunchContext

KINDS = {
    name: list[str] if isinstance(default, list) else type(default)
    for name, (default, *_) in PARAMETERS.items()
} | {"use_sim_time": bool}
TOPICS = ("odom", "path", "drive", "cmd_vel", "speed_limit", "/tf", "/tf_static")


def start(context: LaunchContext) -> list[Any]:
    """Start the node; what is not given is as the node or the file has it."""
    given = {name: value for name, value in context.launch_configurations.items() if value}
    parameters: list[Any] = [
        {
            name: ParameterValue(LaunchConfiguration(name), value_type=kind)
            for name, kind in KINDS.items()
            if name in given
        }
    ]
    if "params_file" in given:
        parameters.insert(0, ParameterFile(given["params_file"]))
    node = LifecycleNode(
        package="popsteer_ros",
        executable="track",
        name=given.get("name", "popsteer"),
        namespace=given.get("namespace", ""),
        parameters=parameters,
        remappings=[(name, given[of]) for name in TOPICS if (of := name.strip("/")) in given],
        output="screen",
    )

    def change(transition: int) -> EmitEvent:
        return EmitEvent(
            event=ChangeState(lifecycle_node_matcher=matches_action(node), transition_id=transition)
        )

    activate = RegisterEventHandler(
        OnStateTransition(
            target_lifecycle_node=node,
            start_state="configuring",
            goal_state="inactive",
            entities=[change(Transition.TRANSITION_ACTIVATE)],
        )
    )
    return [activate, node, change(Transition.TRANSITION_CONFIGURE)]


def generate_launch_description() -> LaunchDescription:
    """Give the node with its arguments."""
    what = {
        **{name: f"{said}; {default!r}" for name, (default, said, *_) in PARAMETERS.items()},
        "use_sim_time": "whether time is that of the topic /clock",
        "name": "what the node is called; popsteer",
        "namespace": "the namespace that it is in",
        "params_file": "a YAML file of parameters, which the arguments go before",
        **{name.strip("/"): f"what the topic {name} is called" for name in TOPICS},
    }
    return LaunchDescription(
        [
            *(
                DeclareLaunchArgument(name, default_value="", description=what[name])
                for name in what
            ),
            OpaqueFunction(function=start),
        ]
    )
