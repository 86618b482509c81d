"""ros2 launch popsteer_ros track.launch.py vehicle:=car.toml: configures and activates the node."""

from __future__ import annotations

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, EmitEvent, RegisterEventHandler
from launch.events import matches_action
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import LifecycleNode
from launch_ros.event_handlers import OnStateTransition
from launch_ros.events.lifecycle import ChangeState
from launch_ros.parameter_descriptions import ParameterValue
from lifecycle_msgs.msg import Transition

ARGUMENTS = {
    "vehicle": (None, str),
    "namespace": ("", str),
    "controller": ("preview-pop", str),
    "max_speed": ("5.0", float),
    "command_type": ("ackermann", str),
    "path_file": ("", str),
    "use_sim_time": ("false", bool),
}


def generate_launch_description() -> LaunchDescription:
    """Give the node with its arguments."""
    own = ("namespace",)
    given = {
        name: ParameterValue(LaunchConfiguration(name), value_type=kind)
        for name, (_, kind) in ARGUMENTS.items()
        if name not in own
    }
    node = LifecycleNode(
        package="popsteer_ros",
        executable="track",
        name="popsteer",
        namespace=LaunchConfiguration("namespace"),
        parameters=[given],
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
    declared = [
        DeclareLaunchArgument(name, **({} if default is None else {"default_value": default}))
        for name, (default, _) in ARGUMENTS.items()
    ]
    configure = change(Transition.TRANSITION_CONFIGURE)
    return LaunchDescription([*declared, activate, node, configure])
