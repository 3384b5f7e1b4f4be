"""Wheeled-robot controllers (`isaacsim.robot.wheeled_robots`)."""
