"""The node library. Importing this package registers every type that ships; a new family is one more name here."""

from importlib import import_module

FAMILIES = (
    "action.events",
    "action.flow",
    "action.latent",
    "action.log",
    "action.loops",
    "data.arithmetic",
    "data.arrays",
    "data.comparison",
    "data.constants",
    "data.conversions",
    "data.logic",
    "data.variables",
    "data.vectors",
    "isaac.annotator_clocks",
    "isaac.articulation",
    "isaac.articulation_state",
    "isaac.clocks",
    "isaac.copying",
    "isaac.gates",
    "isaac.joint_names",
    "isaac.odometry",
    "isaac.physics_step",
    "isaac.poses",
    "isaac.render_products",
    "isaac.stage_units",
    "isaac.transform_tree",
    "lidar.extract",
    "lidar.flat_scan",
    "lidar.scan_buffer",
    "robots.differential",
    "ros2.clock",
    "ros2.context",
    "ros2.lidar_helper",
    "ros2.point_cloud_config",
    "ros2.publish_laser_scan",
    "ros2.publish_point_cloud",
    "ros2.transforms",
)

for _family in FAMILIES:
    import_module(f".{_family}", __name__)
