"""Explicit actuators of joints, as Newton has them: control laws, limits of motors, delayed commands."""
