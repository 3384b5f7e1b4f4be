"""The devices on which a test runs: Warp's processor code everywhere, a card where there is one."""

import pytest

from graph.sim.devices import WARP_HOST, warp

CARDS = bool(warp().get_cuda_devices())
if not CARDS:
    warp().config.optimization_level = 0  # compiling mujoco-warp takes most of the time, and half as long
DEVICES = [
    WARP_HOST,
    pytest.param("cuda", marks=pytest.mark.skipif(not CARDS, reason="no CUDA device is there")),
]
on_each = pytest.mark.parametrize("device", DEVICES)

WORLD = """\
tickgraph: 1
scene:
  prims:
    /World/Ground: {type: Plane}
    /World/Wall: {type: Cube, size: 1.0, translate: [3, 1, 0.5]}
    /World/Ball: {type: Sphere, radius: 0.2, translate: [2, 0, 0.4], rigid_body: true, mass: 1.0}
    /World/Mast: {translate: [0, 0, 0.25], rigid_body: true, mass: 2.0}
    /World/Mast/knob: {type: Sphere, radius: 0.05, translate: [0, 0, -0.15]}
    /World/Mast/lidar: {type: OmniLidar, config: Example_Rotary_2D}
    /World/turn:
      type: PhysicsRevoluteJoint
      schemas: [PhysicsDriveAPI:angular]
      attributes:
        physics:axis: Z
        physics:body1: /World/Mast
        physics:localPos0: [0, 0, 0.25]
        drive:angular:physics:damping: 5.0
clock: {physics_hz: 60, loop_hz: 60}
"""
"""A graph file with a driven mast that carries a lidar, a ball and a wall. Its contacts have closed forms, of which
mujoco-warp compiles the fewest kernels."""
