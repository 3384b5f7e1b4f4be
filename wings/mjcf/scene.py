"""An MJCF model as the scene of an App: its stage and its physics."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from graph.base import exact
from graph.base.errors import UserError
from graph.sim import transforms
from graph.sim.physics.mujoco.library import WIDTHS, forward, mujoco, state_of
from graph.sim.physics.solver import SolverOptions
from graph.sim.physics.world_model import Body, Joint, Volume, WorldModel
from graph.sim.scene.mechanisms import JointKind
from graph.sim.scene.stage import Warn, ignore_warning, register_schemas
from graph.sim.transforms import Floats
from graph.sim.usd import EARLIEST, UsdGeom

from .files import Document, read_model
from .loading import keyframe_number, load
from .naming import ROOT, Paths, flex_name, prim_paths

if TYPE_CHECKING:
    from graph.sim.phases import Phases
    from graph.sim.state.playing_world import PlayingWorld

MOVED = 1e-9
"""The least difference between a prim's pose and the model's [m or rad] to count as moved by the user."""
IGNORED = ("rigid_body", "mass", "density", "collision")
"""Keys of inline prims that have no effect on prims of the model, which defines the simulation itself."""


class MjcfScene:
    """A loaded model: `stage` mirrors it, `model` and `spec` are MuJoCo's own; paths name its parts on the stage."""

    def __init__(self, document: Document, keyframe: str | int | None = None, warn: Warn = ignore_warning) -> None:
        from .mirror import mirror

        register_schemas()
        self.file, self.speeds = document.file, document.speeds
        self.spec, self.model = load(document, warn)
        self.key = None if keyframe is None else keyframe_number(self.model, keyframe, document.file)
        self.paths: Paths = prim_paths(self.model)
        self.moved: dict[int, Floats] = {}
        """Poses that users gave to bodies attached to the world: rigid (4, 4) by number; see `settle`."""
        self._last: dict[int, Floats] = {}
        self.listeners: list[Any] = []
        """Callbacks that USD itself holds only weakly."""
        data = state_of(self.model)
        if self.key is not None:
            mujoco.mj_resetDataKeyframe(self.model, data, self.key)
        forward(self.model, data)
        self.flexes = {path: (flex_name(self.model, n), _vertices(self.model, data, n)) for n, path in self._meshes()}
        """Soft parts by their prims: name in the model, initial vertices (n, 3) [m]."""
        self.stage = mirror(self.model, data, self.paths, warn)
        self._home = transforms.pose_matrices(data.xpos, data.xquat)
        self.parts = frozenset(path for group in self._groups() for path in group if path)

    def _meshes(self) -> Iterable[tuple[int, str]]:
        """Flexes with faces, by number, and their prims."""
        return [(n, path) for n, path in enumerate(self.paths.flexes) if self.model.flex_dim[n] > 1]

    def _groups(self) -> Iterable[Sequence[str]]:
        paths = self.paths
        yield from (paths.bodies, paths.joints, paths.geoms, paths.sites, paths.cameras, paths.actuators)
        yield from (paths.sensors, paths.materials, paths.flexes)

    @property
    def physics_rate(self) -> Fraction:
        """Steps per second of the model's time step [Hz], exact."""
        return 1 / exact.duration(float(self.model.opt.timestep))

    @property
    def moves(self) -> bool:
        """Whether anything in the model can move."""
        return bool(self.model.nv)

    def serve(self, world: PlayingWorld, phases: Phases) -> None:
        """Connects a world's Fabric and stage to the model's actuators and sensors, until the world closes."""
        from .controls import serve

        serve(self, world, phases)

    def start(self, model: Any, data: Any) -> None:
        """Puts data of this model, or of a grown copy, into the initial state of the scene.

        The initial state is the chosen keyframe, else the reference pose, with the bodies that users have moved in
        their places, and with the controls of the stage.
        """
        source = state_of(self.model)
        if self.key is not None:
            mujoco.mj_resetDataKeyframe(self.model, source, self.key)
        carry_state(self.model, source, model, data)
        for number, pose in self.moved.items():
            body = model.body(self.model.body(number).name).id
            mocap = int(model.body_mocapid[body])
            joint = int(model.body_jntadr[body])
            if mocap >= 0:
                data.mocap_pos[mocap], data.mocap_quat[mocap] = _parts(pose)
            elif joint >= 0 and model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_FREE:
                first = int(model.jnt_qposadr[joint])
                data.qpos[first : first + 3], data.qpos[first + 3 : first + 7] = _parts(pose)
        for number, path in enumerate(self.paths.actuators):
            control = self.stage.GetPrimAtPath(path).GetAttribute("mjc:ctrl").Get()
            there = model.actuator(self.model.actuator(number).name).id
            first, count = int(model.actuator_ctrladr[there]), int(model.actuator_ctrlnum[there])
            data.ctrl[first : first + count] = np.asarray(control, dtype=np.float64)

    def roots(self) -> list[int]:
        """The numbers of the bodies that are attached to the world."""
        return [number for number in range(1, self.model.nbody) if self.model.body_parentid[number] == 0]

    def settle(self, warn: Warn) -> None:
        """Takes over the poses that users gave to prims: a body attached to the world takes its descendants with it.

        A body behind a joint cannot be moved: it is put back, with the warning `mjcf-body-held`.
        """
        model, moved = self.model, self.moved
        moved.clear()
        roots = self.roots()
        for number in roots:
            pose = self._pose(number)
            if np.abs(pose - self._home[number]).max() > MOVED:
                moved[number] = pose
        for number in range(1, model.nbody):
            root = int(model.body_rootid[number])
            if number in roots or number in self.paths.points:
                continue
            wanted = self._home[number]
            if root in moved:
                wanted = moved[root] @ transforms.inverse_rigid(self._home[root]) @ wanted
            here = self._pose(number)
            if np.abs(here - wanted).max() <= MOVED:
                continue
            if np.abs(here - self._home[number]).max() > MOVED and not self._settled(number, here):
                warn(
                    "mjcf-body-held",
                    self.paths.bodies[number],
                    f"a joint holds this body, so it stays where the model has it; place {self.paths.bodies[root]}",
                )
            self._put(number, wanted)
        self._last = {number: self._pose(number) for number in range(1, model.nbody) if number not in self.paths.points}

    def _settled(self, number: int, pose: Floats) -> bool:
        """Whether a pose is the one that an earlier call gave the body."""
        last = self._last.get(number)
        return last is not None and bool(np.abs(pose - last).max() <= MOVED)

    def _pose(self, number: int) -> Floats:
        prim = self.stage.GetPrimAtPath(self.paths.bodies[number])
        if not prim:
            return np.array(self._home[number])
        world = transforms.from_usd(UsdGeom.Xformable(prim).ComputeLocalToWorldTransform(EARLIEST))
        return transforms.rigid_part(world)

    def _put(self, number: int, pose: Floats) -> None:
        from graph.sim.scene.prim_attributes import set_transform

        prim = self.stage.GetPrimAtPath(self.paths.bodies[number])
        if prim:
            set_transform(prim, translate=pose[:3, 3].tolist(), orient=transforms.quaternion(pose[:3, :3]).tolist())

    def compiled(
        self, world: WorldModel, dt: Fraction, options: SolverOptions, warn: Warn, volumes: dict[Any, Volume]
    ) -> Any:
        """The model with time step `dt` [s] and the additions of `world`; see `playing.compile_scene`."""
        from .playing import compile_scene

        return compile_scene(self, world, dt, options, warn, volumes)

    def bodies(self) -> tuple[Body, ...]:
        """The model's bodies in its order, in their initial poses."""
        model, poses = self.model, self.moved
        out = []
        for number in range(1, model.nbody):
            root = int(model.body_rootid[number])
            pose = self._home[number]
            if root in poses:
                pose = poses[root] @ transforms.inverse_rigid(self._home[root]) @ pose
            kinematic = bool(model.body_mocapid[number] >= 0)
            out.append(Body(self.paths.bodies[number], pose, kinematic, name=model.body(number).name))
        return tuple(out)

    def joints(self) -> tuple[Joint, ...]:
        """The model's joints except free ones.

        A body without a joint gets a fixed one, so that a mechanism is connected.
        """
        from .mirror import joint_frames

        model, paths = self.model, self.paths
        kinds: dict[int, JointKind] = {
            int(mujoco.mjtJoint.mjJNT_HINGE): "revolute",
            int(mujoco.mjtJoint.mjJNT_SLIDE): "prismatic",
            int(mujoco.mjtJoint.mjJNT_BALL): "spherical",
        }
        out = []
        for body in range(1, model.nbody):
            if body in paths.points:
                continue
            ends = paths.bodies[model.body_parentid[body]] or None, paths.bodies[body]
            first, count = int(model.body_jntadr[body]), int(model.body_jntnum[body])
            if body in paths.welds:
                out.append(Joint(paths.welds[body], "fixed", ends, (np.eye(4), np.eye(4))))
            for number in range(first, first + count):
                if not paths.joints[number]:
                    continue
                low, high = -np.inf, np.inf
                if model.jnt_limited[number]:
                    low, high = map(float, model.jnt_range[number])
                kind = kinds[int(model.jnt_type[number])]
                frames = joint_frames(model, number)
                name = model.joint(number).name
                speed = self.speeds.get(name, np.inf)
                out.append(Joint(paths.joints[number], kind, ends, frames, 0, low, high, max_speed=speed, name=name))
        return tuple(out)

    def overridden(self, prims: Mapping[str, Mapping[str, Any]], warn: Warn) -> None:
        """Warns of keys of inline prims that have no effect, because the model defines them (`mjcf-key-ignored`)."""
        for path, keys in prims.items():
            wrong = [key for key in IGNORED if key in keys] if path in self.parts else []
            if wrong:
                warn("mjcf-key-ignored", path, f"{', '.join(wrong)}: the model itself says that; change it there")


def open_mjcf(
    path: str | Path,
    allow_roots: Iterable[str | Path] | None = None,
    keyframe: str | int | None = None,
    warn: Warn = ignore_warning,
    *,
    is_urdf: bool | None = None,
) -> MjcfScene:
    """The scene of an MJCF or URDF file; only files below `allow_roots` (default: its own folder) are read.

    is_urdf: None decides by the file's name.

    keyframe: name or number of the initial keyframe. Raises UserError, one line for each problem with file and line.
    """
    file = Path(path).expanduser().absolute()
    is_urdf = file.suffix.lower() == ".urdf" if is_urdf is None else is_urdf
    if not file.is_file():
        raise UserError(f"{path}: no such {'URDF' if is_urdf else 'MJCF'} file")
    roots = [file.parent] if allow_roots is None else [Path(root) for root in allow_roots]
    return MjcfScene(read_model(file, roots, is_urdf=is_urdf), keyframe, warn)


def carry_state(model: Any, data: Any, to: Any, target: Any) -> None:
    """Copies the state of a model to a grown copy of it, part by part by name."""
    for number in range(model.njnt):
        there = to.joint(model.joint(number).name).id
        widths = WIDTHS.get(int(model.jnt_type[number]), (1, 1))
        for field, address, width in zip(("qpos", "qvel"), ("jnt_qposadr", "jnt_dofadr"), widths, strict=True):
            first, second = int(getattr(model, address)[number]), int(getattr(to, address)[there])
            getattr(target, field)[second : second + width] = getattr(data, field)[first : first + width]
    for number in range(model.nbody):
        if model.body_mocapid[number] >= 0:
            mine, other = model.body_mocapid[number], to.body_mocapid[to.body(model.body(number).name).id]
            target.mocap_pos[other], target.mocap_quat[other] = data.mocap_pos[mine], data.mocap_quat[mine]
    for number in range(model.nactuator):
        there = to.actuator(model.actuator(number).name).id
        first, second = int(model.actuator_actadr[number]), int(to.actuator_actadr[there])
        count = int(model.actuator_actnum[number])
        if count:
            target.act[second : second + count] = data.act[first : first + count]
    target.time = data.time


def _vertices(model: Any, data: Any, number: int) -> Floats:
    first, count = model.flex_vertadr[number], model.flex_vertnum[number]
    return np.array(data.flexvert_xpos[first : first + count])


def _parts(pose: Floats) -> tuple[Floats, Floats]:
    return pose[:3, 3], transforms.quaternion(pose[:3, :3])


__all__ = ["ROOT", "MjcfScene", "open_mjcf"]
