"""ROS 2 nodes (`isaacsim.ros2.bridge`): publishers, sensor helpers, and the messages they build."""
