"""popsteer as a node of a ROS 2 installation: transport over rclpy, all else is popsteer's."""
