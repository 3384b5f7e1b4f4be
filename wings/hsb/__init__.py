"""Holoscan sensor bridge: camera frames as the raw lines of a VB1940, on topics named by receiver and plane."""
