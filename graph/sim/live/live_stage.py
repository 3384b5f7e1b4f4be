"""A playing stage: what its edits do to physics, Fabric and sensors, and which edits are refused."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import numpy as np

from graph.base.errors import RunError
from graph.sim import transforms
from graph.sim.scene.scan import scan_stage
from graph.sim.state.tensors import Tensors
from graph.sim.transforms import Floats
from graph.sim.usd import EARLIEST, Usd, UsdGeom

from .live_attributes import apply_live
from .roles import StageRoles, role_of
from .stage_watch import PROTOTYPE, StageWatch, describe

if TYPE_CHECKING:
    from graph.sim.state.playing_world import PlayingWorld

ADVICE = (
    'Undo it, or stop; to change the world while it plays, edit inside `with app.edit(when_playing="recompile"):` (or '
    '"restart"), make App(when_playing="recompile"), or run with --/tickgraph/whenPlaying=recompile'
)


class LiveStage:
    """Handles edits of the stage between play and stop.

    A new transform takes effect at once: it moves a free or kinematic body, or the surfaces and colliders of a static
    prim. Surfaces, colliders, bodies and joints that were added, removed, changed in kind or scaled are refused at the
    next update, or compiled in, as `App.when_playing` says; so are colliders of another shape. Other changes of look or
    shape are seen from the next scan on. New targets of drives and velocities of free bodies take effect in the next
    update; other physics attributes at the next play, with the warning `edit-not-live`.
    """

    def __init__(self, world: PlayingWorld) -> None:
        self._world = world
        self._fabric = world.fabric
        self._tensors = Tensors(world)
        self.roles = StageRoles(world.stage)
        self._known = self.roles.paths
        self._staged: dict[str, Floats] = {}
        self.origin = self._poses()
        """Rigid pose [m] of each body at play, or when it was added."""
        self.watch = StageWatch(world.stage, world.fabric, self.roles, self._transformed)
        self._fabric.promote = self._promote_placed
        if not self._fabric.enabled:
            self._fabric.carried = self._carry
            world.geometry()  # its surfaces start from the initial poses of the bodies, to the last bit

    def close(self) -> None:
        """Stops watching the stage."""
        self.watch.close()
        self._fabric.promote = None
        if not self._fabric.enabled:
            self._fabric.carried = None

    # -- at every update ---------------------------------------------------------------------------------------------

    def check(self) -> None:
        """Handles the edits since the last update. Raises RunError, at every call, for refused edits."""
        watch, world = self.watch, self._world
        if watch.looks:
            watch.looks = False
            world.forget_geometry()
        if not watch.pending:
            return
        failure = self.take_failure()
        if failure is not None:
            raise failure
        self._say_what_waits()
        words, paths = self._changes()
        if not words:
            return
        if world.when_playing == "recompile":
            self.recompile(paths)
            return
        raise RunError(
            f"edited while playing: {_listed(words)}; physics and sensors go on with what was there. {ADVICE}"
        )

    def take_failure(self) -> BaseException | None:
        """Why an edit of the stage could not be applied to the world; returned once."""
        failure, self.watch.failure = self.watch.failure, None
        return failure

    def _changes(self) -> tuple[list[str], set[str]]:
        watch = self.watch
        words, paths = describe(self._world.stage, self.roles, list(watch.structure))
        if not words:
            watch.structure.clear()
        for path in list(watch.shapes):
            prim, _, name = path.rpartition(".")
            if name == RESCALED and not self.roles.rescaled(prim):
                del watch.shapes[path]
            elif name != RESCALED and not self._collides(prim):
                del watch.shapes[path]
                self._world.forget_geometry()
            elif prim not in paths:
                odd = name == RESCALED and not self.roles.finite(prim)
                words.append(
                    f"{self._shown(prim)} got {'a transform that is not finite' if odd else f'another {name}'}"
                )
                paths.add(prim)
        return words, paths

    def _shown(self, prim: str) -> str:
        """A prim's path; for a prim shared by instances, the path in one of them."""
        if not prim.startswith(PROTOTYPE):
            return prim
        root, _, rest = prim[1:].partition("/")
        instances = self._world.stage.GetPrimAtPath(f"/{root}").GetInstances()
        return f"{instances[0].GetPath()}/{rest}" if instances else prim

    def _collides(self, prim: str) -> bool:
        """Whether physics has read the shape of a prim, or of one below a shared part of instances."""
        if self._world.physics is None:
            return False
        if not prim.startswith(PROTOTYPE):
            return "PhysicsCollisionAPI" in self.roles.roles.get(prim, "")
        shared = self._world.stage.GetPrimAtPath(prim)
        return any("PhysicsCollisionAPI" in role_of(each) for each in Usd.PrimRange(shared))

    def _say_what_waits(self) -> None:
        for path in self.watch.physics:
            prim, _, name = path.rpartition(".")
            if apply_live(self._world, self._tensors, prim, name):
                continue
            self._world.warn(
                "edit-not-live",
                prim,
                f"{name} was written while playing and counts from the next play on; to have it now, write it inside "
                '`with app.edit(when_playing="recompile"):`',
            )
        self.watch.physics.clear()

    # -- deliberate edits --------------------------------------------------------------------------------------------

    @contextmanager
    def edit(self) -> Iterator[Any]:
        """The stage; at the end, edits of it (these and earlier ones) are compiled in place.

        Unchanged bodies keep their state.
        """
        watch = self.watch
        watch.collecting = True
        try:
            yield self._world.stage
        except BaseException:
            watch.collecting = False
            for path, surely in list(watch.transforms.items()):
                self._transformed(path, surely)
            watch.transforms.clear()
            raise
        watch.collecting = False
        moved = dict(watch.transforms)
        before = {path: self._stage_pose(path) for path in moved if path in self.roles.paths}
        _, paths = self._changes()
        self.recompile(paths | {path.rpartition(".")[0] for path in watch.physics} | self._rescaled(moved))
        self._staged.update(before)
        for path, surely in moved.items():
            self._transformed(path, surely)

    def _rescaled(self, moved: Iterable[str]) -> set[str]:
        return {path for path in moved if self.roles.under(path) and self.roles.rescaled(path)}

    def recompile(self, touched: Iterable[str]) -> None:
        """Compiles the stage's dynamics again in place, and makes its surfaces be collected again.

        Raises UserError, with the physics unchanged, if the engine refuses the scene.
        """
        from graph.sim.physics import build_physics
        from graph.sim.physics.rebuild import rebuild
        from graph.sim.scene.stage_faults import repair_turns

        repair_turns(self._world.stage, self._world.warn)
        world, fabric, paths = self._world, self._fabric, tuple(touched)
        physics = world.physics
        gone: Any = None
        if physics is None:
            scan = scan_stage(world.stage, fabric.promoted)
            dt = 1 / world.steps_per_second
            physics = build_physics(
                world.stage, dt, world.fidelity, engine=world.engine, warn=world.warn, scan=scan, mjcf=world.mjcf
            )
        elif not rebuild(physics, world.stage, paths, world.warn, fabric.promoted):
            physics, gone = None, physics
        world.physics = physics
        fabric.rebind(physics, paths)
        if gone is not None:
            gone.close()
        self._renew()
        self.watch.clear()

    def restore(self) -> None:
        """Puts every body, and every static prim that was moved, back to its pose at play, or when it was added.

        They are at rest or have the velocity that the stage authors. Drives get the authored targets, grippers are
        open.
        """
        from graph.sim.physics.rebuild import restart

        world, fabric = self._world, self._fabric
        if world.physics is not None:
            restart(world.physics, world.stage, self.origin, world.warn, fabric.promoted)
        fabric.restore(self.origin)

    def remove_spawned(self) -> list[str]:
        """Removes the prims with a role that were added after play, and everything below them; returns their topmost
        paths.
        """
        new = sorted(path for path in StageRoles(self._world.stage).roles if path not in self._known)
        topmost: list[str] = []
        for path in new:
            root = path
            while (above := root.rpartition("/")[0]) and above not in self._known:
                root = above
            if not topmost or topmost[-1] != root:
                topmost.append(root)
        if not topmost:
            return []
        stage = self._world.stage
        with self.edit():
            for path in topmost:
                for layer in stage.GetLayerStack():
                    spec = layer.GetPrimAtPath(path)
                    if spec:
                        parent = spec.realNameParent
                        del parent.nameChildren[spec.name]
        return topmost

    def _renew(self) -> None:
        self._world.forget_geometry()
        # changes that physics itself writes to the stage are not watched
        known = self.roles.renew(self.watch.touched) if self._fabric.enabled else StageRoles(self._world.stage)
        self.roles = self.watch.roles = known
        poses = self._poses()
        self.origin = {path: self.origin.get(path, pose) for path, pose in poses.items()}

    def _poses(self) -> dict[str, Floats]:
        physics = self._world.physics
        paths = (*(physics.body_paths if physics is not None else ()), *self._fabric.promoted)
        found = dict(zip(paths, self._fabric.rigid_matrices(paths).copy(), strict=True)) if paths else {}
        if physics is not None:
            found.update({body.path: body.pose for body in physics.world.bodies})
        return found

    # -- transforms --------------------------------------------------------------------------------------------------

    def _transformed(self, path: str, surely: bool) -> None:
        """A prim's transform was written to the stage; `surely`: its pose changed, else perhaps only its scale."""
        if not self.roles.under(path):
            return
        if self.roles.rescaled(path):
            self.watch.shapes[f"{path}.{RESCALED}"] = None
            return
        fabric = self._fabric
        if fabric.is_body(path):
            if fabric.promoted.get(path) is False:
                self._promote(path, carries=True)
            if self._moved_on_stage(path) or surely or not fabric.enabled:
                fabric.take_from_stage(path, self._on_stage(path))
        elif fabric.body_of(path) is not None:
            self._moved_part(path)
        else:
            self._promote(path, carries=True)
        self._carry(path)
        fabric.settle()

    def _stage_pose(self, path: str) -> Floats:
        """The rigid pose [m] that the stage last gave a prim."""
        staged = self._staged.get(path)
        return self.roles.pose(path, self._world.meters_per_unit) if staged is None else staged

    def _moved_on_stage(self, path: str) -> bool:
        """Whether the stage has another pose for a prim than before."""
        pose = transforms.rigid_part(self._on_stage(path))
        pose[:3, 3] *= self._world.meters_per_unit
        before, self._staged[path] = self._stage_pose(path), pose
        return bool(np.abs(pose - before).max() > 1e-12)

    def _carry(self, path: str) -> None:
        """Moves the bodies below a prim that the stage has moved: all, or with Fabric on those that users move."""
        fabric, physics = self._fabric, self._world.physics
        left = []
        for body in fabric.bodies_below(path):
            if physics is None or body not in physics.body_paths or body in physics.kinematic:
                fabric.take_from_stage(body, self._on_stage(body))
            elif fabric.enabled:
                left.append(body)
            elif physics.can_place(body):
                fabric.take_from_stage(body, self._on_stage(body))
        if left:
            self._world.warn(
                "fabric-parent-moved",
                path,
                f"it was moved on the stage; {_listed(left)} below it stays where physics has it. Move the body "
                "itself, or switch Fabric off (fidelity fabric: off)",
            )

    def _moved_part(self, path: str) -> None:
        """A part of a body has another pose in it."""
        if any("PhysicsCollisionAPI" in self.roles.roles[each] for each in self.roles.under(path)):
            self.recompile((path,))
        else:
            self._world.forget_geometry()
            self.roles = self.watch.roles = StageRoles(self._world.stage)

    def _promote_placed(self, path: str) -> bool:
        """Whether a static prim to be placed, in Fabric (alone) or on the stage (with everything below), is now a
        body.
        """
        carries = not self._fabric.enabled
        if not (self.roles.under(path) if carries else path in self.roles.roles):
            return False
        self._promote(path, carries)
        return True

    def _promote(self, path: str, carries: bool) -> None:
        """From now on a static prim is a kinematic body, and so are its colliders in physics."""
        world, fabric = self._world, self._fabric
        fabric.promoted[path] = carries
        self.origin.setdefault(path, self.roles.pose(path, world.meters_per_unit))
        roles = self.roles.roles
        prims = self.roles.under(path) if carries else [path]
        if world.physics is not None and any("PhysicsCollisionAPI" in roles[each] for each in prims if each in roles):
            self.recompile((path,))
        else:
            fabric.add_frame(path)
            world.forget_geometry()

    def _on_stage(self, path: str) -> Floats:
        prim = self._world.stage.GetPrimAtPath(path)
        return transforms.from_usd(UsdGeom.XformCache(EARLIEST).GetLocalToWorldTransform(prim))


RESCALED = "scale"
"""The name for a change of a prim's scale among the changes of shape."""


def _listed(words: list[str]) -> str:
    return ", ".join(words[:3]) + (f" and {len(words) - 3} more" if len(words) > 3 else "")
