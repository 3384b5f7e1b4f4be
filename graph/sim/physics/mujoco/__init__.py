"""MuJoCo as the physics engine. Only this package and wings use MuJoCo's models and data."""
