"""Sensors: ideal measurements of the world, their schedules, buffers and configurations."""
