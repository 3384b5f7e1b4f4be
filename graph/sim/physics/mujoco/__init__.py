"""MuJoCo as the physics engine. Only this package and `graph.sim.mjcf` use MuJoCo's models and data."""
