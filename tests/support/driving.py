"""Drives the robots of graph files through their differential controllers, and measures how they move."""

from dataclasses import dataclass

import numpy as np

from graph.isaac.og import Controller
from graph.session.graph_links import Links

DRIVES = [(0.5, 0.0), (0.0, 0.0), (-0.5, 0.0), (0.0, 0.0), (0.0, 0.8), (0.0, -0.8), (0.5, 0.5), (0.0, 0.0)]
"""Forward speed [m/s] and turn rate [rad/s] of each part of a drive."""
UPDATES = 60
"""Of each part, at 60 Hz; speeds are means of its second half."""


@dataclass
class Driven:
    """A robot's drive: the largest tilt [rad], and (parts, 2) the speed and turn rate of its base and by its wheels."""

    tilt: float
    moved: np.ndarray
    rolled: np.ndarray


def controllers(app):
    """The differential controllers of an App."""
    nodes = [node for graph in app.graphs.values() for node in graph.nodes.values()]
    return [node for node in nodes if node.type.short_name == "DifferentialController"]


def drive(app, controller, drives=DRIVES):
    """Plays and drives the robot of a controller, in place of what feeds it in its file."""
    scripted = Controller(app=app)
    for link in Links(app.graphs.values()).into.get(controller, ()):
        if link.input in ("linearVelocity", "angularVelocity"):
            source = f"{link.source.path}.outputs:{link.output}"
            scripted.disconnect(source, f"{controller.path}.inputs:{link.input}")
    nodes = controller.graph.nodes.values()
    (motors,) = [node for node in nodes if node.type.short_name == "IsaacArticulationController"]
    radius, distance = controller.get("wheelRadius"), controller.get("wheelDistance")
    app.play()
    app.update(30)
    robot = app.physics.articulation(str(motors.get("targetPrim")[0]))
    wheels = [robot.joint_names.index(name) for name in motors.get("jointNames")]
    paths = [robot.joint_paths[wheel] for wheel in wheels]
    (base,) = {joint.bodies[0] for joint in app.physics.joints if joint.path in paths}
    row = app.physics.body_paths.index(base)
    up = app.physics.rotations[row].T @ (0, 0, 1)  # in the base's own axes
    tilt, moved, rolled = 0.0, [], []
    for speed, turn in drives:
        scripted.set(f"{controller.path}.inputs:linearVelocity", speed)
        scripted.set(f"{controller.path}.inputs:angularVelocity", turn)
        base_rates, wheel_rates = [], []
        for _ in range(UPDATES):
            app.update()
            turned, velocity = app.physics.rotations[row], app.physics.velocities()[row]
            tilt = max(tilt, float(np.arccos(min(1.0, (turned @ up)[2]))))
            left, right = radius * robot.velocities[wheels]
            base_rates.append((velocity[:3] @ turned[:, 0], velocity[5]))
            wheel_rates.append(((left + right) / 2, (right - left) / distance))
        moved.append(np.mean(base_rates[UPDATES // 2 :], axis=0))
        rolled.append(np.mean(wheel_rates[UPDATES // 2 :], axis=0))
    return Driven(tilt, np.array(moved), np.array(rolled))
