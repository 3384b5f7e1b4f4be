"""Small worlds for tests of lidars: boxes that stand, move and turn without gravity, and lidars of known beams."""

from fractions import Fraction

import numpy as np
from pxr import Gf, UsdGeom, UsdPhysics

from graph.sim import App
from graph.sim.scene import nonvisual
from sensors import LidarConfig
from sensors.lidar.config import EmitterState
from sensors.lidar.prim import write_config
from sensors.prim import write_aux_level
from sensors.products import render_product

NORMALS = "/app/sensors/nv/lidar/publishNormals"
EVERYTHING = {"xyz", "azimuth", "elevation", "distance", "scalar", "timeOffsetNs", "flags"} | {
    "emitterId", "channelId", "tickId", "echoId", "tickStates", "hitNormals", "velocities"
}  # fmt: skip


def weightless(physics_hz=240, loop_hz=60, settings=None, seed=0, **fidelity):
    """An App without gravity; fidelity knobs by name, "_" for the first "."."""
    knobs = {name.replace("_", ".", 1): value for name, value in fidelity.items()}
    app = App(
        None,
        physics_hz=physics_hz,
        loop_hz=loop_hz,
        fidelity=knobs,
        settings={NORMALS: True, **(settings or {})},
        seed=seed,
    )
    UsdPhysics.Scene.Define(app.stage, "/World/Physics").CreateGravityMagnitudeAttr(1e-12)
    return app


def add_box(app, path, size, position, velocity=None, spin=None):
    """A cube [m]; with a velocity [m/s] or a spin [deg/s] it is a body of 1 kg."""
    cube = UsdGeom.Cube.Define(app.stage, path)
    cube.CreateSizeAttr(size)
    UsdGeom.XformCommonAPI(cube).SetTranslate(Gf.Vec3d(*position))
    if velocity is not None or spin is not None:
        body = UsdPhysics.RigidBodyAPI.Apply(cube.GetPrim())
        body.CreateVelocityAttr(Gf.Vec3f(*(velocity or (0, 0, 0))))
        body.CreateAngularVelocityAttr(Gf.Vec3f(*(spin or (0, 0, 0))))
        UsdPhysics.CollisionAPI.Apply(cube.GetPrim())
        UsdPhysics.MassAPI.Apply(cube.GetPrim()).CreateMassAttr(1.0)
    return cube.GetPrim()


def bind(app, prim, base, coating="none", attributes="none"):
    """Gives a prim a non-visual material."""
    nonvisual.bind(app.stage, prim, (base, coating, attributes))


def rotary(ticks=360, scan_hz=Fraction(10), elevations=(0.0,), **fields):
    """A rotary lidar: clockwise from azimuth 0, one beam for each elevation [deg] in each of the ticks of a turn."""
    state = EmitterState(azimuth_deg=np.zeros(len(elevations)), elevation_deg=elevations)
    rate = Fraction(scan_hz)
    return LidarConfig(
        **{"scan_rate_base_hz": rate, "pattern_firing_rate_hz": rate * ticks, "emitter_states": (state,), **fields}
    )


def stare(times, azimuths=None, scan_hz=Fraction(10), **fields):
    """A solid state lidar that looks ahead (or to the azimuths [deg]) at times [s] of each scan."""
    azimuths = np.zeros(len(times)) if azimuths is None else azimuths
    state = EmitterState(
        azimuth_deg=azimuths,
        elevation_deg=np.zeros(len(times)),
        fire_time_ns=np.round(np.asarray(times) * 1e9).astype(np.int64),
    )
    fields = {"skip_dropping_invalid_points": True, **fields}
    return LidarConfig(
        scan_type="SOLID_STATE",
        scan_rate_base_hz=scan_hz,
        pattern_firing_rate_hz=Fraction(scan_hz),
        emitter_states=(state,),
        **fields,
    )


def define_lidar(app, path="/World/Lidar", config=None, level="FULL", tick_rate=None):
    """A lidar prim of this aux level, which nobody consumes yet."""
    prim = app.stage.DefinePrim(path, "OmniLidar")
    write_config(prim, config or rotary(), tick_rate=tick_rate)
    write_aux_level(prim, level)
    return prim


def add_lidar(
    app, path="/World/Lidar", position=(0, 0, 0), config=None, channels=EVERYTHING, tick_rate=None, level="FULL"
):
    """A lidar prim of this aux level and its render product, with a consumer of `channels`."""
    prim = define_lidar(app, path, config, level, tick_rate)
    UsdGeom.XformCommonAPI(prim).SetTranslate(Gf.Vec3d(*position))
    product = render_product(app, path)
    product.sensor.require("test", channels)
    return product


def frames_of(app, product, updates):
    """The frames of so many updates from play on."""
    found = []
    app.play()
    for _ in range(updates):
        app.update()
        if product.new_frame:
            found.append(product.frame)
    return found
