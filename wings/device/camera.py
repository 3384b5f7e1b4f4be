"""The colours of one camera on a device: one ray a pixel, plain surfaces, lights without an image."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from graph.sim.devices import warp
from sensors.camera.config import CameraConfig
from sensors.camera.lights import Lighting
from sensors.camera.looks import Looks
from sensors.camera.rays import lens_rays
from sensors.camera.shading import SRGB
from sensors.raycast.world import anchor_of

from . import lamps
from .devices import refuse_beyond
from .replay import Inputs, Replay, finish, host_array

if TYPE_CHECKING:
    from .world import DeviceWorld

BYTES_A_PIXEL = 64
"""Way, origin, hit and colours of a pixel on the device."""


class DeviceCamera:
    """Colours of a camera in a world. exclude: what it does not see, and what throws no shadow."""

    def __init__(self, world: DeviceWorld, config: CameraConfig, exclude: frozenset[str], looks: Looks) -> None:
        self.world, self.config, self.looks, self.lens = world, config, looks, lens_rays(config.lens)
        self._exclude, self._dark = exclude, exclude | looks.clear
        self._plain = self.lens.dark is None and not (looks.vary or looks.cut or looks.planes)
        self._film: tuple[Any, _Film] | None = None

    def fits(self, lighting: Lighting) -> bool:
        """Whether the device can shade what the camera sees."""
        return self._plain and lamps.simple(lighting)

    def shade(self, pose: np.ndarray, state: Any, lighting: Lighting, *, light: bool, aces: bool) -> np.ndarray | None:
        """(n, 3) of each pixel from a pose (4, 4) float64 [m]: uint8 of sRGB, or float32 [nit] of `light`.

        None if something is nearer than the near distance: rays must look behind it.
        """
        anchor = anchor_of(pose[:3, 3])
        key = anchor.tobytes(), lamps.size_of(lighting), light, aces
        if self._film is None or self._film[0] != key:
            self._film = key, _Film(self, anchor, lamps.size_of(lighting), light=light, aces=aces)
        return self._film[1].shot(pose, state, lighting)

    def made(self, anchor: np.ndarray) -> tuple[Any, Any]:
        """The geometry that is seen and the one that throws shadows, about an anchor."""
        return self.world.geometry(anchor, self._exclude), self.world.facets.geometry(anchor, self._dark)


class _Film:
    """Pictures about one anchor with so many lights and patches: replayed by one call."""

    def __init__(
        self, camera: DeviceCamera, anchor: np.ndarray, sizes: tuple[int, int], *, light: bool, aces: bool
    ) -> None:
        from . import kernels, shade_kernels

        wp, world, config, lens = warp(), camera.world, camera.config, camera.lens
        device = self._device = world.device
        count = self._count = lens.local.shape[1]
        refuse_beyond(device, count * BYTES_A_PIXEL, f"a picture of {count:,} pixels")
        self._world = world
        self._seen, self._dark = camera.made(anchor)
        lights, patches = sizes
        self._inputs = Inputs(
            device,
            {
                "frames": (wp.mat44d, (1,)),
                "bodies": (wp.mat44d, (1, len(world.bodies))),
                **dict.fromkeys(("color", "place", "axis", "cone"), (wp.vec3, (lights,))),
                **{"patches": (wp.vec3, (patches,)), "sky": (wp.vec3, (1,))},
                **{"kind": (wp.int32, (lights,)), "first": (wp.int32, (lights + 1,))},
            },
        )

        def upload(values: Any, dtype: Any, kind: Any = None) -> Any:
            return wp.array(np.ascontiguousarray(values, dtype), dtype=kind, device=device)

        there = self._inputs.there
        self._rays = self._seen.rays(lens.local.T, lens.origins)
        self._rays.frames = there["frames"]
        self._lamps, self._looks, film = shade_kernels.Lamps(), shade_kernels.Looks(), shade_kernels.Film()
        for name in ("color", "place", "axis", "cone", "patches", "sky", "kind", "first"):
            setattr(self._lamps, name, there[name])
        self._looks.base = upload(camera.looks.base, np.float32, wp.vec3)
        self._looks.emitted = upload(camera.looks.emitted, np.float32, wp.vec3)
        along = np.zeros(0) if lens.wide or lens.along is None else lens.along
        film.along, film.table = upload(along, np.float32, wp.float32), upload(SRGB, np.uint8, wp.uint8)
        film.near, film.far, film.exposure, film.aces = config.near, config.far, config.exposure, int(aces)
        self._film = film
        self._every = wp.zeros(1, dtype=wp.int32, device=device)
        self._distance = wp.empty(count, dtype=wp.float32, device=device)
        self._surface = wp.empty(count, dtype=wp.int32, device=device)
        self._normal = wp.empty(count, dtype=wp.vec3, device=device)
        begin = lamps.HEADER
        self._picture = wp.zeros(begin + (0 if light else 3 * count), dtype=wp.uint8, device=device)
        self._light = wp.empty(count if light else 0, dtype=wp.vec3, device=device)
        self._picture_host = host_array(device, self._picture.size, wp.uint8)
        self._light_host = host_array(device, self._light.size, wp.vec3)
        self._cast = kernels.cast_of(*self._seen.kinds)
        self._shade = shade_kernels.shade_of(*self._dark.kinds)
        self._replay = Replay(device, self._work, recorded=not world.soft)

    def shot(self, pose: np.ndarray, state: Any, lighting: Lighting) -> np.ndarray | None:
        """See `DeviceCamera.shade`."""
        host = self._inputs.host
        for geometry in self._geometries():
            self._world.deform(geometry, state)
        self._world.write_bodies(host["bodies"][0], self._seen.anchor, state)
        host["frames"][0] = pose
        host["frames"][0, :3, 3] -= self._seen.anchor
        lamps.write(lighting, host)
        self._replay()
        finish(self._device)
        picture = self._picture_host.numpy()
        if picture[0]:
            return None
        if self._light.size:
            return np.array(self._light_host.numpy())
        return np.array(picture[lamps.HEADER :]).reshape(self._count, 3)

    def _geometries(self) -> tuple[Any, ...]:
        return (self._seen,) if self._dark is self._seen else (self._seen, self._dark)

    def _work(self) -> None:
        wp, bodies, seen, dark = warp(), self._inputs.there["bodies"], self._seen, self._dark
        self._inputs.bring()
        for geometry in self._geometries():
            geometry.settle(bodies)
        met = seen.trace(self._rays, self._every, 1e30)
        hits = [self._distance, self._surface, self._normal]
        wp.launch(
            self._cast,
            dim=self._count,
            inputs=[seen.ground, seen.items, seen.placed, bodies, seen.skip, self._rays, met],
            outputs=hits,
            device=self._device,
        )
        self._picture[:1].zero_()
        wp.launch(
            self._shade,
            dim=self._count,
            inputs=[
                *(dark.ground, dark.items, dark.placed, bodies, dark.skip, self._rays, *hits),
                *(self._looks, self._lamps, self._film),
            ],
            outputs=[self._light, self._picture],
            device=self._device,
        )
        wp.copy(self._picture_host, self._picture)
        if self._light.size:
            wp.copy(self._light_host, self._light)
