"""PhysicsScene, PhysxScene and NewtonMjcScene, row by row; what of them the App follows."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import pytest

from graph.base.errors import RunError
from graph.isaac.managers.physics_scene import steps_per_second
from graph.sim import App, NewtonMjcScene, PhysicsScene, PhysxGpuCfg, PhysxScene
from graph.sim.attributes import applied_schemas
from graph.sim.scene.prims import author_prims
from graph.sim.scene.stage import open_stage
from graph.sim.usd import Gf, Sdf, UsdGeom, UsdPhysics

PRODUCT = "isaacsim-6.0.1"
BALL = {"/World/Ball": {"type": "Sphere", "radius": 0.2, "translate": [0, 0, 50], "rigid_body": True, "mass": 1.0}}


def ball(app):
    return app.physics.velocities()[0, 2]


# -- the prim ------------------------------------------------------------------------------------------------------


def test_physics_scene_creates_the_prim_if_absent():
    with App() as app:
        scene = PhysicsScene("/World/Scene")
        assert (scene.path, scene.prim.GetTypeName()) == ("/World/Scene", "PhysicsScene")
        assert scene.physics_scene.GetPrim() == app.stage.GetPrimAtPath("/World/Scene")
        assert PhysicsScene(scene.prim).path == scene.path


def test_physics_scene_value_error_if_the_prim_is_of_another_type():
    with App() as app:
        app.stage.DefinePrim("/World", "Xform")
        for prim in ("/World", app.stage.GetPrimAtPath("/World"), app.stage.GetPrimAtPath("/Nowhere")):
            with pytest.raises(ValueError, match="is not a PhysicsScene"):
                PhysicsScene(prim)


@pytest.mark.parametrize("path", ["Scene", "", "/", "/a b", "/A.size"])
def test_physics_scene_value_error_for_what_is_not_a_path(path):
    with App(), pytest.raises(ValueError, match="is not a prim path"):
        PhysicsScene(path)


def test_no_scene_is_made_while_playing():
    with App() as app:
        app.play()
        with pytest.raises(RunError, match=r"app\.stop\(\)"):
            PhysicsScene("/PhysicsScene")


def test_get_physics_scene_paths():
    with App() as app:
        assert PhysicsScene.get_physics_scene_paths() == []
        for path in ("/B", "/World/A"):
            PhysicsScene(path)
        assert PhysicsScene.get_physics_scene_paths() == ["/B", "/World/A"]
        assert PhysicsScene.get_physics_scene_paths(open_stage()) == []
        assert [type(scene) for scene in app.simulation.get_physics_scenes()] == [PhysxScene, PhysxScene]


def test_a_scene_of_a_stage_without_an_app_is_only_a_prim():
    stage = open_stage()
    scene = PhysxScene(UsdPhysics.Scene.Define(stage, "/Scene").GetPrim())
    assert scene.get_dt() == 1 / 60
    scene.set_dt(1 / 240)
    scene.set_broadphase_type("SAP")
    assert (scene.get_dt(), scene.is_active) == (1 / 240, False)


# -- dt ------------------------------------------------------------------------------------------------------------


def test_row_physics_scene_dt_default_60():
    with App():
        assert PhysicsScene("/A").get_dt() == PhysxScene("/B").get_dt() == 1 / 60
        assert PhysxScene("/B").get_steps_per_second() == 60


def test_row_physics_scene_without_physx_api_default_1000():
    stage = open_stage()
    prim = UsdPhysics.Scene.Define(stage, "/Scene").GetPrim()
    prim.AddAppliedSchema("NewtonSceneAPI")
    scene = PhysicsScene(prim)
    assert scene.get_dt() == 0.001
    scene.set_dt(1 / 500)
    assert prim.GetAttribute("newton:timeStepsPerSecond").Get() == 500
    with App(stage=stage) as app:
        assert app.simulation.steps_per_second == 500


def test_row_newton_mjc_scene_dt_default_and_stored_as_a_float():
    with App() as app:
        scene = NewtonMjcScene("/PhysicsScene")
        assert scene.get_dt() == 0.002
        scene.set_dt(0.0167)
        assert scene.get_dt() == 0.0167
        assert app.simulation.steps_per_second == Fraction(10000, 167)


@pytest.mark.parametrize("dt", [0, -0.001, float("nan")])
def test_row_newton_mjc_scene_value_error_unless_dt_above_0(dt):
    with App(), pytest.raises(ValueError, match=r"dt|finite"):
        NewtonMjcScene("/PhysicsScene").set_dt(dt)


@pytest.mark.parametrize("dt", [-1e-6, 1.0001, float("inf")])
@pytest.mark.parametrize("kind", [PhysicsScene, PhysxScene])
def test_row_set_dt_value_error_outside_0_to_1(kind, dt):
    with App(), pytest.raises(ValueError, match=r"dt|finite"):
        kind("/PhysicsScene").set_dt(dt)


def test_row_dt_0_stores_rate_0_and_get_dt_is_0():
    with App():
        scene = PhysxScene("/PhysicsScene")
        scene.set_dt(0)
        assert (scene.get_steps_per_second(), scene.get_dt()) == (0, 0.0)


@pytest.mark.parametrize(("dt", "rate"), [(0.0166, 60), (0.0167, 59), (0.03, 33), (0.7, 1), (1 / 99, 98), (1 / 60, 60)])
def test_truncation_of_the_product(dt, rate):
    with App(parity=PRODUCT) as app:
        scene = PhysxScene("/PhysicsScene")
        scene.set_dt(dt)
        assert (scene.get_steps_per_second(), scene.get_dt()) == (rate, 1 / rate)
        assert app.simulation.steps_per_second == rate


def test_truncation_loses_a_step_for_141_whole_rates_up_to_2000():
    lost = [n for n in range(1, 2001) if steps_per_second(1 / n, truncate=True) != n]
    assert len(lost) == 141
    assert lost[:9] == [93, 99, 105, 117, 123, 186, 198, 210, 211]
    assert {steps_per_second(1 / n, truncate=True) - n for n in lost} == {-1}


def test_no_rate_is_lost_in_documented():
    assert all(steps_per_second(1 / n) == n for n in range(1, 2001))


def test_the_active_scene_speaks_of_the_app():
    """`physics_hz` beats what the stage authors, so the scene says what runs, not what is written."""
    stage = open_stage()
    UsdPhysics.Scene.Define(stage, "/Scene").GetPrim().CreateAttribute(
        "physxScene:timeStepsPerSecond", Sdf.ValueTypeNames.UInt
    ).Set(60)
    with App(stage=stage, physics_hz=240):
        assert PhysicsScene("/Scene").get_dt() == 1 / 240


def test_set_dt_of_the_active_scene_counts_from_the_next_step_on():
    with App() as app:
        scene = PhysicsScene("/PhysicsScene")
        scene.set_dt(1 / 120)
        app.play()
        app.update()
        assert app.simulation.get_num_physics_steps() == 2
        scene.set_dt(1 / 240)
        app.update()
        assert app.simulation.get_num_physics_steps() == 6


def test_set_dt_of_another_scene_is_kept_on_its_prim_and_said():
    with App() as app:
        PhysicsScene("/A")
        other = PhysicsScene("/B")
        other.set_dt(1 / 240)
        assert (other.get_dt(), app.simulation.steps_per_second) == (1 / 240, 60)
        assert "physics-scene-inactive" in app.warnings.codes()


@pytest.mark.parametrize("steps", [-1, float("nan")])
def test_row_set_steps_per_second_value_error_below_0(steps):
    with App(), pytest.raises(ValueError, match=r"steps|finite"):
        PhysxScene("/PhysicsScene").set_steps_per_second(steps)


@pytest.mark.parametrize(("parity", "rate"), [("documented", 59.94), (PRODUCT, 59)])
def test_set_steps_per_second(parity, rate):
    with App(parity=parity) as app:
        scene = PhysxScene("/PhysicsScene")
        scene.set_steps_per_second(59.94)
        assert scene.get_steps_per_second() == rate
        assert app.simulation.steps_per_second == Fraction(str(rate))


def test_trap_17_a_live_change_to_0_keeps_the_rate_and_is_reported():
    with App() as app:
        scene = PhysicsScene("/PhysicsScene")
        app.play()
        scene.set_dt(0)
        app.update(6)
        assert (app.simulation.get_num_physics_steps(), scene.get_dt()) == (6, 0.0)
        assert "physics-rate-zero" in app.warnings.codes()


@pytest.mark.parametrize(("parity", "steps"), [("documented", 60), (PRODUCT, 1)])
def test_trap_17_a_rate_of_0_found_at_load(parity, steps):
    """The product runs it at 1 Hz; `documented` at its default of 60."""
    stage = open_stage()
    PhysicsScene(UsdPhysics.Scene.Define(stage, "/Scene").GetPrim()).set_dt(0)
    with App(stage=stage, parity=parity) as app:
        assert app.simulation.steps_per_second == steps
        assert "physics-rate-zero" in app.warnings.codes()
    with App(stage=stage, parity=parity, physics_hz=100) as app:
        assert app.simulation.steps_per_second == 100
        assert len(app.warnings) == 0


@pytest.mark.parametrize(
    ("attributes", "rate"),
    [
        ({"physxScene:timeStepsPerSecond": 120, "mjc:option:timestep": 0.002, "newton:timeStepsPerSecond": 7}, 120),
        ({"mjc:option:timestep": 0.005, "newton:timeStepsPerSecond": 7}, 200),
        ({"newton:timeStepsPerSecond": 250}, 250),
        ({"mjc:option:timestep": float("nan")}, 60),
        ({}, 60),
    ],
)
def test_what_a_stage_says_of_its_rate(attributes, rate):
    stage = open_stage()
    prim = UsdPhysics.Scene.Define(stage, "/Scene").GetPrim()
    for name, value in attributes.items():
        kind = Sdf.ValueTypeNames.Double if name.endswith("timestep") else Sdf.ValueTypeNames.Int
        prim.CreateAttribute(name, kind).Set(value)
    with App(stage=stage) as app:
        assert app.simulation.steps_per_second == rate


def test_a_stage_saved_after_other_settings_keeps_its_rate():
    with App() as app:
        scene = NewtonMjcScene("/PhysicsScene")
        scene.set_iterations(50)
        scene.set_enabled_gravity(True)
        with App(stage=app.stage) as again:
            assert again.simulation.steps_per_second == 60


# -- gravity and iterations ----------------------------------------------------------------------------------------


def test_get_gravity_default_is_earths_in_stage_units():
    stage = open_stage()
    UsdGeom.SetStageMetersPerUnit(stage, 0.01)
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.y)
    with App(stage=stage):
        assert Gf.IsClose(PhysicsScene("/PhysicsScene").get_gravity(), Gf.Vec3f(0, -981, 0), 1e-3)


def test_set_gravity_is_a_vector_in_world_units():
    with App() as app:
        author_prims(app.stage, BALL)
        scene = PhysicsScene("/PhysicsScene")
        scene.set_gravity((0, 0, -1.5))
        assert Gf.IsClose(scene.get_gravity(), Gf.Vec3f(0, 0, -1.5), 1e-6)
        app.play()
        app.update(60)
        assert ball(app) == pytest.approx(-1.5, abs=1e-6)


def test_set_gravity_while_playing_acts_at_once_and_outlasts_the_stop():
    with App() as app:
        author_prims(app.stage, BALL)
        scene = PhysicsScene("/PhysicsScene")
        scene.set_gravity([0, 0, 0])
        app.play()
        app.update(30)
        assert ball(app) == 0
        scene.set_gravity(Gf.Vec3f(0, 0, 2))
        app.update(30)
        assert ball(app) == pytest.approx(1.0, abs=1e-6)
        scene.set_enabled_gravity(False)
        app.update(30)
        assert ball(app) == pytest.approx(1.0, abs=1e-6)
        app.stop()
        assert (scene.get_gravity()[2], scene.get_enabled_gravity()) == (2, False)


def test_gravity_that_is_not_finite_is_refused():
    with App(), pytest.raises(ValueError, match="finite"):
        PhysicsScene("/PhysicsScene").set_gravity((0, 0, float("nan")))


def test_enabled_gravity_default_true_off_means_weightless():
    with App() as app:
        author_prims(app.stage, BALL)
        scene = PhysicsScene("/PhysicsScene")
        assert scene.get_enabled_gravity() is True
        scene.set_enabled_gravity(False)
        app.play()
        app.update(30)
        assert ball(app) == 0


def test_max_solver_iterations_default_minus_1_and_value_error_below():
    with App():
        scene = PhysicsScene("/PhysicsScene")
        assert scene.get_max_solver_iterations() == -1
        with pytest.raises(ValueError, match="-1"):
            scene.set_max_solver_iterations(-2)
        scene.set_max_solver_iterations(7)
        assert scene.get_max_solver_iterations() == 7


def test_max_solver_iterations_reach_the_engine():
    with App() as app:
        author_prims(app.stage, BALL)
        PhysicsScene("/PhysicsScene").set_max_solver_iterations(7)
        app.play()
        assert app.physics.model.opt.iterations == 7


# -- PhysX's settings ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "default", "value", "attribute"),
    [
        ("solver_type", "TGS", "PGS", "solverType"),
        ("broadphase_type", "GPU", "MBP", "broadphaseType"),
        ("enabled_gpu_dynamics", True, False, "enableGPUDynamics"),
        ("enabled_ccd", False, True, "enableCCD"),
        ("enabled_stabilization", False, True, "enableStabilization"),
    ],
)
def test_physx_scene_defaults_and_what_is_kept_on_the_prim(name, default, value, attribute):
    with App():
        scene = PhysxScene("/PhysicsScene")
        assert getattr(scene, f"get_{name}")() == default
        getattr(scene, f"set_{name}")(value)
        assert getattr(scene, f"get_{name}")() == value
        assert scene.prim.GetAttribute(f"physxScene:{attribute}").Get() == value
        assert "PhysxSceneAPI" in applied_schemas(scene.prim)


def test_what_changes_nothing_here_is_reported():
    with App() as app:
        PhysxScene("/PhysicsScene").set_broadphase_type("MBP")
        assert app.warnings.codes() == ["physics-setting-stored"]


@pytest.mark.parametrize(("name", "value"), [("solver_type", "pgs"), ("broadphase_type", "ABP")])
def test_physx_scene_value_error_for_no_choice(name, value):
    with App(), pytest.raises(ValueError, match="is not one of"):
        getattr(PhysxScene("/PhysicsScene"), f"set_{name}")(value)


def test_enabling_gpu_dynamics_turns_ccd_off():
    with App():
        scene = PhysxScene("/PhysicsScene")
        scene.set_enabled_ccd(True)
        scene.set_enabled_gpu_dynamics(True)
        assert scene.get_enabled_ccd() is False


def test_gpu_configuration():
    with App():
        scene = PhysxScene("/PhysicsScene")
        usual = scene.get_gpu_configuration()
        assert (usual.gpu_heap_capacity, usual.gpu_max_num_partitions) == (1 << 26, 8)
        scene.set_gpu_configuration(PhysxGpuCfg(gpu_heap_capacity=1 << 20))
        scene.set_gpu_configuration({"gpu_max_num_partitions": 4})
        assert scene.get_gpu_configuration() == replace(usual, gpu_heap_capacity=1 << 20, gpu_max_num_partitions=4)
        assert scene.prim.GetAttribute("physxScene:gpuHeapCapacity").Get() == 1 << 20
        with pytest.raises(ValueError, match="gpu_heap_capacity -1"):
            scene.set_gpu_configuration(PhysxGpuCfg(gpu_heap_capacity=-1))


# -- MuJoCo's options ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "default", "value"),
    [
        ("integrator", "euler", "rk4"),
        ("solver", "newton", "cg"),
        ("iterations", 100, 20),
        ("tolerance", 1e-8, 1e-6),
        ("cone", "pyramidal", "elliptic"),
        ("jacobian", "auto", "sparse"),
        ("impratio", 1.0, 10.0),
        ("density", 0.0, 1.2),
        ("viscosity", 0.0, 1e-5),
    ],
)
def test_newton_mjc_scene_defaults_and_what_is_authored(name, default, value):
    with App():
        scene = NewtonMjcScene("/PhysicsScene")
        assert getattr(scene, f"get_{name}")() == default
        getattr(scene, f"set_{name}")(value)
        assert getattr(scene, f"get_{name}")() == value
        assert scene.prim.GetAttribute(f"mjc:option:{name}").Get() == value


def test_newton_mjc_scene_wind():
    with App() as app:
        scene = NewtonMjcScene("/PhysicsScene")
        assert scene.get_wind() == Gf.Vec3d(0, 0, 0)
        scene.set_wind((1, 2, 3))
        assert scene.get_wind() == Gf.Vec3d(1, 2, 3)
        assert isinstance(app.simulation.get_physics_scenes()[0], NewtonMjcScene)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("integrator", "verlet"),
        ("solver", "TGS"),
        ("cone", "round"),
        ("jacobian", "yes"),
        ("iterations", -1),
        ("tolerance", -1e-9),
        ("impratio", 0),
        ("density", -1),
        ("viscosity", float("nan")),
        ("wind", (0, 0, float("inf"))),
    ],
)
def test_newton_mjc_scene_value_error(name, value):
    with App(), pytest.raises(ValueError, match=name):
        getattr(NewtonMjcScene("/PhysicsScene"), f"set_{name}")(value)


def test_mujocos_options_reach_the_engine():
    with App() as app:
        author_prims(app.stage, BALL)
        scene = NewtonMjcScene("/PhysicsScene")
        scene.set_integrator("rk4")
        scene.set_solver("cg")
        scene.set_cone("elliptic")
        scene.set_iterations(33)
        scene.set_tolerance(1e-5)
        scene.set_impratio(5)
        scene.set_density(1.2)
        scene.set_viscosity(1e-5)
        scene.set_wind((3, 0, 0))
        app.play()
        opt = app.physics.model.opt
        assert (int(opt.integrator), int(opt.solver), int(opt.cone), opt.iterations) == (1, 1, 1, 33)
        assert (opt.tolerance, opt.impratio, opt.density, opt.viscosity) == (1e-5, 5, 1.2, 1e-5)
        assert opt.wind.tolist() == [3, 0, 0]
