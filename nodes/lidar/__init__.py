"""Lidar annotator nodes (`isaacsim.sensors.rtx`): point clouds, scan buffers, flat scans from a product's frames."""
