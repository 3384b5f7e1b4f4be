"""Sensors of PhysX: a rotating lidar and a curtain of light beams, which nodes poll without a render product."""
