"""MuJoCo as the physics engine. Only this package and `graph.sim.mjcf` know MuJoCo's models and data."""
