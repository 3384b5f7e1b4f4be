import math

import mujoco
import pytest

from graph.base.errors import UserError
from graph.sim import App
from graph.sim.fidelity import KNOBS, Fidelity
from graph.sim.physics.solver import CHOICES, SWITCHES
from graph.sim.scene.stage import open_stage
from graph.sim.usd import Sdf
from tests.support.physics_worlds import GROUND, physics_of, steps
from tests.support.without_wing import needs_wing

BALL = {"/A": {"type": "Sphere", "radius": 0.2, "rigid_body": True, "translate": [0, 0, 1]}}


def built(values=None, fidelity=None, prims=None):
    """Physics and warnings of a ball with attributes (name -> (type, value)) on the physics scene."""
    from graph.sim.scene.prims import author_prims

    stage = open_stage()
    author_prims(stage, {**GROUND, **(prims or BALL), "/Scene": {"type": "PhysicsScene"}})
    for name, (kind, value) in (values or {}).items():
        stage.GetPrimAtPath("/Scene").CreateAttribute(name, getattr(Sdf.ValueTypeNames, kind)).Set(value)
    return physics_of(stage, fidelity=fidelity)


@pytest.mark.parametrize("name", CHOICES)
def test_every_choice_reaches_the_engine_from_a_knob_and_from_the_scene(name):
    for choice, constant in CHOICES[name].items():
        wanted = next(
            int(getattr(kinds, constant))
            for kinds in (mujoco.mjtIntegrator, mujoco.mjtSolver, mujoco.mjtCone, mujoco.mjtJacobian)
            if hasattr(kinds, constant)
        )
        physics, _ = built(fidelity=Fidelity.from_mapping({f"physics.{name}": choice}))
        assert getattr(physics.model.opt, name) == wanted
        physics, warnings = built({f"mjc:option:{name}": ("Token", choice)})
        assert getattr(physics.model.opt, name) == wanted
        assert warnings == []


@pytest.mark.parametrize(
    ("name", "kind", "value"),
    [
        ("iterations", "Int", 7),
        ("ls_iterations", "Int", 9),
        ("noslip_iterations", "Int", 3),
        ("ccd_iterations", "Int", 11),
        ("tolerance", "Double", 1e-5),
        ("ls_tolerance", "Double", 0.02),
        ("ccd_tolerance", "Double", 1e-4),
        ("impratio", "Double", 4.0),
    ],
)
def test_every_number_reaches_the_engine_from_a_knob_and_from_the_scene(name, kind, value):
    physics, _ = built(fidelity=Fidelity.from_mapping({f"physics.{name}": value}))
    assert getattr(physics.model.opt, name) == pytest.approx(value)
    physics, _ = built({f"mjc:option:{name}": (kind, value)})
    assert getattr(physics.model.opt, name) == pytest.approx(value)


@pytest.mark.parametrize("name", SWITCHES)
def test_switches_of_collision_detection(name):
    bit = int(getattr(mujoco.mjtDisableBit, SWITCHES[name]))
    for text, off in (("on", 0), ("off", bit)):
        physics, _ = built(fidelity=Fidelity.from_mapping({f"physics.{name}": text}))
        assert physics.model.opt.disableflags & bit == off


@pytest.mark.parametrize("softness", [0.1, 0.5])
def test_contacts_sink_in_and_creep_in_proportion_to_their_softness(softness):
    """Both are (1 - d) / d by 1 - d = s (1 - d0), d0 = 0.9 where nothing sinks in (d is 0.99 by default, so 10 times as
    soft): 1 / (1 - s / 10) from a ratio of s.

    A box on a slope of 15 degrees, tan 0.27 of a friction of 0.5.
    """
    slope = {"/Slope": {"type": "Cube", "size": 20, "rotate": [0, 15, 0]}}
    where = [10.25 * math.sin(math.radians(15)), 0, 10.25 * math.cos(math.radians(15))]
    box = {"/Box": {"type": "Cube", "size": 0.5, "rotate": [0, 15, 0], "translate": where, "rigid_body": True}}
    crept, sunk = [], []
    for value in (10, 10 * softness):
        fidelity = Fidelity(physics_contact_softness=value)
        physics, _ = built(fidelity=fidelity, prims={**slope, **box})
        steps(physics, 240)
        start = physics.positions[0].copy()
        steps(physics, 240)
        crept.append(math.dist(start, physics.positions[0]))
        level, _ = built(
            fidelity=fidelity, prims={"/Box": box["/Box"] | {"rotate": [0, 0, 0], "translate": [0, 0, 0.25]}}
        )
        steps(level, 240)
        sunk.append(0.25 - level.positions[0, 2])
    assert 2e-5 < crept[0] < 2e-4
    assert crept[1] / crept[0] == pytest.approx(softness, rel=0.15)
    assert sunk[1] / sunk[0] == pytest.approx(softness, rel=0.3)


@needs_wing("mjcf")
def test_a_models_contacts_soften_too_and_only_when_asked(tmp_path):
    """1 - 0.1 (1 - 0.8) = 0.98 and 1 - 0.1 (1 - 0.9) = 0.99."""
    file = tmp_path / "ball.xml"
    ball = "<body><freejoint/><geom size='1' solimp='0.8 0.9 0.001'/></body>"
    file.write_text(f"<mujoco><worldbody>{ball}</worldbody></mujoco>")
    for fidelity, wanted in (({}, (0.8, 0.9)), ({"physics.contact_softness": 0.1}, (0.98, 0.99))):
        with App(mjcf=file, fidelity=fidelity) as app:
            for _ in range(2):  # the second play starts from the file's numbers again
                app.play()
                app.update()
                assert app.world.physics.model.geom_solimp[0, :2] == pytest.approx(wanted)
                app.stop()
                app.update()


def test_a_knob_beats_the_scene_and_the_scene_the_default():
    scene = {"mjc:option:solver": ("Token", "cg"), "mjc:option:iterations": ("Int", 7)}
    scene |= {"newton:maxSolverIterations": ("Int", 50)}
    physics, _ = built(scene, Fidelity(physics_solver="pgs"))
    assert physics.model.opt.solver == mujoco.mjtSolver.mjSOL_PGS
    assert physics.model.opt.iterations == 7
    physics, _ = built({"newton:maxSolverIterations": ("Int", 50)})
    assert physics.model.opt.iterations == 50
    physics, _ = built({"newton:maxSolverIterations": ("Int", -1)})
    assert physics.model.opt.iterations == 100  # MuJoCo's own


def test_a_medium_slows_what_moves_through_it():
    air = {"mjc:option:density": ("Double", 1.2), "mjc:option:viscosity": ("Double", 1e-5)}
    wind = {**air, "mjc:option:wind": ("Double3", (10, 0, 0))}
    still, _ = built(air)
    blown, _ = built(wind)
    for _ in range(60):
        still.step()
        blown.step()
    assert blown.velocities()[0, 0] > still.velocities()[0, 0] == pytest.approx(0)


def test_gravity_can_be_switched_off():
    physics, _ = built({"newton:gravityEnabled": ("Bool", False)})
    for _ in range(60):
        physics.step()
    assert physics.positions[0, 2] == pytest.approx(1)


def test_wrong_values_of_the_scene_are_reported_and_left():
    wrong = {"mjc:option:integrator": ("Token", "heun"), "mjc:option:iterations": ("Int", 0)}
    wrong |= {"mjc:option:tolerance": ("Double", -1.0)}
    physics, warnings = built(wrong)
    assert [(code, where) for code, where, _ in warnings] == [("bad-scene-option", "/Scene")] * 3
    assert "'heun', not one of euler, rk4, implicit, implicitfast, discrete" in warnings[0][2]
    assert physics.model.opt.iterations == 100


@pytest.mark.parametrize("name", ["physics.dynamics", "physics.pipeline"])
def test_dynamics_and_state_are_on_the_cpu(name):
    assert Fidelity.from_mapping({name: "cpu"})[name] == "cpu"
    with pytest.raises(UserError, match=rf"fidelity {name}: 'cuda' is not available: .*MuJoCo Warp.*missing; use cpu"):
        Fidelity.from_mapping({name: "cuda"})
    with pytest.raises(UserError, match="'tpu' is not one of cpu, cuda"):
        Fidelity.from_mapping({name: "tpu"})


def test_every_solver_option_has_a_knob():
    for name in (*CHOICES, *SWITCHES, "iterations", "ls_iterations", "tolerance", "impratio"):
        assert f"physics.{name}" in KNOBS


def test_no_collisions_between_steps_is_reported():
    _, warnings = built({"physxScene:enableCCD": ("Bool", True)})
    assert [code for code, *_ in warnings] == ["no-continuous-collision"]


def test_a_lone_body_with_a_gripper_can_hold_nothing_and_that_is_no_error(world):
    gripper = {"type": "IsaacSurfaceGripper"}
    physics, _, _ = world({**GROUND, **BALL, "/Grip": gripper})
    assert physics.gripper("/Grip").status == "Open"
    physics.gripper("/Grip").close()
    physics.step()
    assert physics.gripper("/Grip").held == ()


@pytest.mark.parametrize("mass", [1e-20, 1e-30])
def test_a_mass_that_is_too_little_is_one_line(world, mass):
    with pytest.raises(UserError, match=r"^/A: a mass of 1e-\d0 kg .* is too little for the engine .*physics:mass"):
        world({"/A": {**BALL["/A"], "attributes": {"physics:mass": mass, "physics:diagonalInertia": [mass] * 3}}})
