"""Where popsteer plugs in: adapters to the frameworks that its users drive with.

Each is a module of its own with an extra of its own, imported nowhere else. An adapter converts and
calls the API; none has a control law, a unit or a sign of its own.

`popsteer.adapters.carla`
    A local planner for CARLA's agents, extra ``carla``.
`popsteer.adapters.gymnasium`
    Environments for reinforcement learning, extra ``gym``.
`popsteer.adapters.ros2`
    A ROS 2 node that steers, without a ROS installation, extra ``ros2``.
"""
