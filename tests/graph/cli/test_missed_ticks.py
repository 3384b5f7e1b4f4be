"""Ticks that no update renders are warned of, with their cause, and fail a strict run.

1000 Hz physics, 60 Hz loop and sensor: update u ends at floor(1000 u / 60) ms. Ticks k/60 s fall into updates 2, 3
(two of them: 2/60 and 3/60 s), 5, 6 (two), ...: of every three one is passed over.
"""

FILE = """
tickgraph: 1
scene:
  prims:
    /World/Ground: {{type: Plane}}
    /World/Ball: {{type: Sphere, radius: 0.2, translate: [3, 0, 2], rigid_body: true}}
    /World/Lidar:
      type: OmniLidar
      config: Example_Rotary_2D
      translate: [0, 0, 1]
      attributes: {{"omni:sensor:tickRate": {rate}, "omni:sensor:Core:scanRateBaseHz": {rate}}}
clock: {{physics_hz: {physics}, loop_hz: 60}}
graphs:
  /World/G:
    nodes:
      tick: OnPlaybackTick
      product: {{type: IsaacCreateRenderProduct, inputs: {{cameraPrim: /World/Lidar}}}}
      cloud: {{type: ROS2RtxLidarHelper, inputs: {{type: point_cloud, topicName: points, frameId: lidar}}}}
    connections:
      - tick.tick -> product.execIn
      - product.execOut -> cloud.execIn
      - product.renderProductPath -> cloud.renderProductPath
"""


def test_ticks_between_physics_steps_are_warned_of_with_their_cause(graph, folder):
    (folder / "off.yaml").write_text(FILE.format(rate=60, physics=1000))
    ran = graph("run", "off.yaml", "--updates", 30, "--strict")
    assert ran.code == 1
    cause = "make physics_hz a multiple of both loop_hz (60 Hz) and the tick rate (60 Hz)"
    assert "warning sensor-ticks-off-grid: /World/Lidar: 10 of 30 ticks are passed over: " in ran.err
    assert ran.err.count(cause) == 2  # the warning, and the line of --strict
    assert (
        "sensor-ticks-off-grid: /World/Lidar: 100 of 300 ticks are passed over: updates end "
        in graph("explain", "off.yaml").out
    )


def test_a_sensor_faster_than_the_loop_is_warned_of(graph, folder):
    (folder / "fast.yaml").write_text(FILE.format(rate=120, physics=240))
    ran = graph("run", "fast.yaml", "--updates", 30)
    assert ran.code == 0
    assert "warning sensor-faster-than-loop: /World/Lidar: 30 of 60 ticks are passed over: " in ran.err


def test_a_schedule_that_is_kept_is_not_a_fault(graph, folder):
    (folder / "kept.yaml").write_text(FILE.format(rate=20, physics=240))
    ran = graph("run", "kept.yaml", "--updates", 30, "--strict")
    assert (ran.code, ran.err) == (0, "")
