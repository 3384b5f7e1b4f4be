"""Radar: from surfaces and their motion to a range-velocity-angle cube and its detections."""
