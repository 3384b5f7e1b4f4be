"""Texts of graph files with a lidar, for tests that are about something else than how it is wired."""


def lidar_graph(publishes="type: point_cloud, topicName: points"):
    """The `graphs:` of a file: in /World/G a tick makes the product of /World/Lidar, and "cloud" has these inputs."""
    return f"""\
graphs:
  /World/G:
    nodes:
      tick: OnPlaybackTick
      product: {{type: IsaacCreateRenderProduct, inputs: {{cameraPrim: /World/Lidar}}}}
      cloud: {{type: ROS2RtxLidarHelper, inputs: {{{publishes}}}}}
    connections:
      - tick.tick -> product.execIn
      - product.execOut -> cloud.execIn
      - product.renderProductPath -> cloud.renderProductPath
"""


# A whole file: a lidar before a wall, and a clock published in every update.
LIDAR_AND_CLOCK = """\
tickgraph: 1
scene:
  prims:
    /World/Wall: {type: Cube, size: 1.0, translate: [3, 0, 0]}
    /World/Lidar: {type: OmniLidar, config: Example_Rotary}
graphs:
  /World/G:
    nodes:
      tick: OnPlaybackTick
      clock: ROS2PublishClock
      product: {type: IsaacCreateRenderProduct, inputs: {cameraPrim: /World/Lidar}}
      cloud: {type: ROS2RtxLidarHelper, inputs: {type: point_cloud, topicName: points}}
    connections:
      - tick.tick -> [clock.execIn, product.execIn]
      - product.execOut -> cloud.execIn
      - product.renderProductPath -> cloud.renderProductPath
"""
