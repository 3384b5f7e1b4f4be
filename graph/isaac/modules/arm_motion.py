"""Motion of the Franka: inverse kinematics, and controllers that lead its hand to a pose.

They stand for RMPflow and Lula of Isaac Sim: joint positions that reach a pose are found on the physics engine's own
model of the arm, and the joints turn there at a limited speed. Obstacles are not avoided.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from graph.isaac.outcomes import inert, tell_inert
from graph.isaac.session import app
from graph.sim import transforms
from graph.sim.transforms import Floats

from .values import ArticulationAction

__all__ = ["KinematicsSolver", "RMPFlowController"]
GRIP = 0.1
"""From the hand's frame along its z axis to the point between the fingertips [m]; Isaac Sim's frame there,
right_gripper, is turned by half a turn about z.
"""
REST = (0.0, -0.57, 0.0, -2.2, 0.0, 1.7, 0.741)
"""Where the search for joint positions begins, the base turned towards the target [rad]."""
TURNS, DAMPING, STRIDE = 120, 0.02, 0.3
"""Steps of a search, their damping, and the longest step of a joint [rad]."""
NEAR, STRAIGHT = 1e-4, 1e-3
"""What counts as reached [m, rad]."""
POSTURE = 0.2
"""Share of the way to the start by which a step turns the elbow, as far as the hand stays where it is."""
FASTEST, QUICKEST, EAGERNESS = 1.5, 6.0, 6.0
"""Speed [rad/s] and acceleration [rad/s2] of the joints, and their speed per error [1/s]."""
DOWN = np.array([0.0, 0.0, 1.0, 0.0])
"""Orientation w, x, y, z of a hand that points down."""


class Arm:
    """The seven turning joints of a Franka in the playing world, its hand and the point between its fingertips."""

    def __init__(self, robot: Any) -> None:
        view = robot._view
        names = list(view.dof_names)
        self.joints = [row for row, name in enumerate(names) if "finger" not in name]
        hands = [path for path in view.link_paths[0] if path.endswith("_hand")]
        if len(self.joints) != len(REST) or not hands:
            raise ValueError(f"{robot.prim_path}: these controllers move a Franka; it has joints {', '.join(names)}")
        self.robot, self.count, self.hand = robot, len(names), hands[0]

    @property
    def live(self) -> Any:
        found = self.robot._view._live(0)
        if found is None:
            raise RuntimeError(f"{self.robot.prim_path}: its joints move while the timeline plays; play or reset first")
        return found

    @property
    def positions(self) -> Floats:
        """(7,) [rad]."""
        out: Floats = self.live.positions[self.joints]
        return out

    def grip_at(self, positions: Floats) -> tuple[Floats, Floats]:
        """The pose (4, 4) of the point between the fingertips with the joints at positions, and its Jacobian [m]."""
        pose, jacobian = self.live.pose_at(self.hand, positions, self.joints)
        arm = pose[:3, 2] * GRIP
        jacobian[:3] += np.cross(jacobian[3:].T, arm).T
        pose[:3, 3] += arm
        pose[:3, :2] *= -1
        return pose, jacobian

    def reach(self, position: Any, orientation: Any, *starts: Any) -> tuple[Floats, bool]:
        """(7,) joint positions that bring the grip to a pose, and whether they do; those that come nearest if none do.

        position [stage units]; orientation w, x, y, z, None for any. Damped least squares within the joints' limits
        (Buss, Introduction to Inverse Kinematics, 2004), from each of the starts and from rest.
        """
        target = np.asarray(position, np.float64).reshape(3) * app().meters_per_unit
        turn = None if orientation is None else transforms.rotation_matrices(np.asarray(orientation, np.float64))
        place, standing = (one.numpy()[0] for one in self.robot._view.get_world_poses())
        way = (target - place * app().meters_per_unit) @ transforms.rotation_matrices(standing)
        towards = np.array(REST)
        towards[0] = np.arctan2(way[1], way[0])
        best: tuple[float, Floats] = (np.inf, towards)
        for start in (towards, *starts):
            best = min(best, self._search(np.array(start, np.float64), target, turn), key=lambda one: one[0])
            if best[0] <= 1:
                break
        return best[1], best[0] <= 1

    def _search(self, now: Floats, target: Floats, turn: Floats | None) -> tuple[float, Floats]:
        """The error that is left, 1 for one that just counts as reached, and the joint positions."""
        low, high = self.live.limits[self.joints].T
        rows, start = 3 if turn is None else 6, now
        for _ in range(TURNS):
            pose, jacobian = self.grip_at(now)
            error = np.zeros(6)
            error[:3] = target - pose[:3, 3]
            if turn is not None:
                error[3:] = _rotation(turn @ pose[:3, :3].T)
            left = max(np.linalg.norm(error[:3]) / NEAR, np.linalg.norm(error[3:]) / STRAIGHT)
            if left <= 1:
                break
            part = jacobian[:rows]
            step = part.T @ np.linalg.solve(part @ part.T + DAMPING**2 * np.eye(rows), error[:rows])
            still = np.eye(len(now)) - np.linalg.pinv(part, rcond=1e-3) @ part
            step += POSTURE * still @ (start - now)
            step *= min(1.0, STRIDE / max(np.abs(step).max(), 1e-12))
            now = np.clip(now + step, low, high)
        return float(left), now

    def action(self, positions: Floats) -> ArticulationAction:
        """An action of the whole robot; the fingers are left as they are."""
        row: list[Any] = [None] * self.count
        for joint, value in zip(self.joints, positions, strict=True):
            row[joint] = float(value)
        return ArticulationAction(joint_positions=row)


def _rotation(matrix: Floats) -> Floats:
    """The rotation vector [rad] of a matrix."""
    w, *axis = transforms.quaternion(matrix)
    length = float(np.linalg.norm(axis))
    if length < 1e-12:
        return np.zeros(3)
    angle = 2 * np.arctan2(length, abs(w))
    out: Floats = np.asarray(axis) / length * (angle if w >= 0 else -angle)
    return out


class KinematicsSolver:
    """Joint positions of a Franka for a pose of the point between its fingertips, and the other way round."""

    def __init__(self, robot_articulation: Any, attach_gripper: bool = False) -> None:
        self._robot = robot_articulation
        self._arm: Arm | None = None

    @property
    def _solver(self) -> Arm:
        if self._arm is None:
            self._arm = Arm(self._robot)
        return self._arm

    def compute_inverse_kinematics(
        self,
        target_position: Any,
        target_orientation: Any = None,
        position_tolerance: float | None = None,
        orientation_tolerance: float | None = None,
    ) -> tuple[ArticulationAction, bool]:
        """The action, and whether it reaches the pose."""
        found, reached = self._solver.reach(target_position, target_orientation, self._solver.positions)
        return self._solver.action(found), reached

    def compute_end_effector_pose(self, position_only: bool = False) -> tuple[Any, Any]:
        """(3,) [stage units] and (3, 3), in the world."""
        pose, _ = self._solver.grip_at(self._solver.positions)
        return pose[:3, 3] / app().meters_per_unit, None if position_only else pose[:3, :3]

    def get_end_effector_frame(self) -> str:
        return "right_gripper"


class RMPFlowController:
    """Leads the point between the fingertips to a pose, a step of physics at each call of `forward`."""

    def __init__(
        self, name: str, robot_articulation: Any, physics_dt: float = 1.0 / 60.0, attach_gripper: bool = False
    ) -> None:
        self.name, self._robot, self._dt = name, robot_articulation, physics_dt
        tell_inert("RMPFlowController", "the arm goes to its target by inverse kinematics; it does not avoid obstacles")
        self.reset()

    def reset(self) -> None:
        self._arm: Arm | None = None
        self._command: Any = None
        self._goal: Any = None
        self._asked: Any = None
        self._speed = np.zeros(len(REST))

    def forward(
        self, target_end_effector_position: Any, target_end_effector_orientation: Any = None
    ) -> ArticulationAction:
        """Targets of the arm's joints; position [stage units] and orientation w, x, y, z in the world."""
        if self._arm is None:
            self._arm = Arm(self._robot)
            self._command = self._arm.positions
        asked = (*map(float, np.asarray(target_end_effector_position).reshape(-1)),)
        if target_end_effector_orientation is not None:
            asked += (*map(float, np.asarray(target_end_effector_orientation).reshape(-1)),)
        if asked != self._asked:
            starts = [self._command] if self._goal is None else [self._goal, self._command]
            found, reached = self._arm.reach(target_end_effector_position, target_end_effector_orientation, *starts)
            self._asked = asked
            if reached or self._goal is None:
                self._goal = found
        wanted = (self._goal - self._command) * EAGERNESS
        wanted *= min(1.0, FASTEST / max(np.abs(wanted).max(), 1e-12))
        change = wanted - self._speed
        self._speed = self._speed + change * min(1.0, QUICKEST * self._dt / max(np.abs(change).max(), 1e-12))
        self._command = self._command + self._speed * self._dt
        return self._arm.action(self._command)

    @inert("RMPFlowController")
    def add_obstacle(self, obstacle: Any, static: bool = False) -> bool:
        return False

    @inert("RMPFlowController")
    def remove_obstacle(self, obstacle: Any) -> bool:
        return False
