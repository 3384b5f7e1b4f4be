"""What `graph run --live` knows of the transports before it opens one; their names are those of the extras."""

from graph.recording.transports.transport import Kind

FOXGLOVE = Kind("wings.transports.foxglove", ("foxglove",), port=8765, control=True)
RERUN = Kind("wings.transports.rerun", ("rerun",), port=9876)
DDS = Kind("wings.transports.dds", ("cyclonedds",), domain=True)
ZENOH = Kind("wings.transports.zenoh", ("zenoh", "xxhash"), port=7447, domain=True)
