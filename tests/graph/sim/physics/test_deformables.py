import math

import numpy as np
import pytest

from graph.base.errors import UserError
from graph.sim.fidelity import Fidelity
from tests.support.physics_worlds import G, fallen, stage_of, steps

PLANE = 'def Plane "Ground" (prepend apiSchemas = ["PhysicsCollisionAPI"]) { }\n'


def sheet(columns, rows, cell, at=(0, 0, 0), vertical=False, more="", schema="PhysxDeformableSurfaceAPI"):
    """A grid of triangles in XY (or hanging in XZ)."""
    points = [
        (i * cell, 0, -j * cell) if vertical else (i * cell, j * cell, 0) for i in range(columns) for j in range(rows)
    ]
    faces = []
    for i in range(columns - 1):
        for j in range(rows - 1):
            a = i * rows + j
            faces += [a, a + rows, a + rows + 1, a, a + rows + 1, a + 1]
    return f"""
def Mesh "Cloth" (prepend apiSchemas = ["{schema}", "PhysicsMassAPI"])
{{
    point3f[] points = {points}
    int[] faceVertexCounts = {[3] * (len(faces) // 3)}
    int[] faceVertexIndices = {faces}
    double3 xformOp:translate = {tuple(at)}
    uniform token[] xformOpOrder = ["xformOp:translate"]
    {more}
}}
"""


def cube(n, cell, at, more=""):
    """A TetMesh of n3 cells of six tetrahedra."""

    def number(i, j, k):
        return (i * (n + 1) + j) * (n + 1) + k

    span = range(n + 1)
    points = [(i * cell, j * cell, k * cell) for i in span for j in span for k in span]
    tets = []
    for i in range(n):
        for j in range(n):
            for k in range(n):
                c = [number(i + a, j + b, k + d) for a in (0, 1) for b in (0, 1) for d in (0, 1)]
                parts = ((0, 1, 3, 7), (0, 3, 2, 7), (0, 2, 6, 7), (0, 6, 4, 7), (0, 4, 5, 7), (0, 5, 1, 7))
                tets += [tuple(c[x] for x in part) for part in parts]
    return f"""
def TetMesh "Jelly" (prepend apiSchemas = ["OmniPhysicsVolumeDeformableSimAPI", "PhysicsMassAPI"])
{{
    point3f[] points = {points}
    int4[] tetVertexIndices = {tets}
    double3 xformOp:translate = {tuple(at)}
    uniform token[] xformOpOrder = ["xformOp:translate"]
    {more}
}}
"""


def hold(numbers, to=""):
    rel = f"rel omniphysics:src1 = <{to}>" if to else ""
    return f"""
def OmniPhysicsVtxXformAttachment "Hold"
{{
    rel omniphysics:src0 = </Cloth>
    {rel}
    int[] omniphysics:vtxIndicesSrc0 = {list(numbers)}
}}
"""


def points(physics, path):
    return physics.snapshot().points(path)


def test_cloth_falls_as_anything_does(usda):
    physics, warnings = usda(sheet(4, 5, 0.1, (1, 2, 3)))
    start = points(physics, "/Cloth")
    steps(physics, 60)
    fall = fallen(60, 1 / 240)
    assert points(physics, "/Cloth") == pytest.approx(start - [0, 0, fall], abs=1e-6)
    assert physics.body_paths == ()
    assert warnings == []


def test_a_hanging_strip_stretches_by_its_weight(usda):
    """rho g L2 / 2 E: 1000 kg/m3, 1 m, 1e6 Pa: 4.9 mm; finite strain is stiffer by 1.5 times the strain, under 1 %."""
    material = "physxDeformableSurfaceMaterial"
    more = f"float {material}:youngsModulus = 1e6\nfloat {material}:poissonsRatio = 0"
    physics, warnings = usda(sheet(2, 11, 0.1, (0, 0, 3), vertical=True, more=more) + hold([0, 11]))
    steps(physics, 240 * 4)
    length = 3 - points(physics, "/Cloth")[10, 2]
    assert length - 1 == pytest.approx(1000 * G / 2e6, rel=0.05)
    assert points(physics, "/Cloth")[[0, 11]] == pytest.approx(np.array([[0, 0, 3], [0.1, 0, 3]]), abs=1e-8)
    assert warnings == []


def test_cloth_weighs_what_is_authored(usda):
    physics, _ = usda(sheet(4, 4, 0.1, more="float physics:mass = 0.3"))
    assert physics.model.body_mass.sum() == pytest.approx(0.3)
    physics, _ = usda(
        sheet(4, 4, 0.1, more="float physics:density = 500\nfloat physxDeformableSurfaceMaterial:thickness = 0.002")
    )
    assert physics.model.body_mass.sum() == pytest.approx(0.3 * 0.3 * 0.002 * 500)


def test_cloth_drapes_over_a_ball_and_stays_above_it(usda):
    ball = 'def Sphere "Ball" (prepend apiSchemas = ["PhysicsCollisionAPI"]) { double radius = 0.4\n }\n'
    physics, _ = usda(PLANE + ball + sheet(13, 13, 0.1, (-0.6, -0.6, 0.6)))
    steps(physics, 480)
    cloth = points(physics, "/Cloth")
    assert np.isfinite(cloth).all()
    assert np.linalg.norm(cloth, axis=1).min() > 0.39
    assert cloth[:, 2].max() < 0.42
    assert cloth[:, 2].min() < 0.2


def test_cloth_hangs_on_a_body_that_moves(usda):
    cart = """def Xform "Cart" (prepend apiSchemas = ["PhysicsRigidBodyAPI"]) {
    bool physics:kinematicEnabled = 1
    double3 xformOp:translate = (0, 0, 2)
    uniform token[] xformOpOrder = ["xformOp:translate"]
    }\n"""
    physics, _ = usda(cart + sheet(3, 3, 0.1, (0, 0, 2)) + hold([0], "/Cart"))
    pose = np.eye(4)
    pose[:3, 3] = [0.2, 0, 2.1]
    physics.set_poses(["/Cart"], pose[None])
    steps(physics, 480)
    corner = points(physics, "/Cloth")[0]
    assert corner == pytest.approx([0.2, 0, 2.1], abs=1e-3)
    near = points(physics, "/Cloth")[1]
    assert np.linalg.norm(near - corner) < 0.12


def test_a_soft_cube_stands_and_is_pressed_by_its_weight(usda):
    """rho g h2 / 2 E: 1000 kg/m3, 0.3 m, 1e5 Pa: 4.4 mm, and its lowest points give way by MuJoCo's contact."""
    more = "float omniphysics:youngsModulus = 100000\nfloat omniphysics:poissonsRatio = 0"
    physics, warnings = usda(PLANE + cube(3, 0.1, (0, 0, 0.01), more))
    assert physics.model.body_mass.sum() == pytest.approx(27)
    steps(physics, 960)
    jelly = points(physics, "/Jelly")
    height = jelly[:, 2].max() - jelly[:, 2].min()
    assert 0.3 - height == pytest.approx(1000 * G * 0.09 / 2e5, rel=0.3)
    assert np.ptp(jelly[:, 0]) == pytest.approx(0.3, abs=0.02)
    assert warnings == []


def test_a_mesh_is_carried_by_the_tetrahedra_of_its_simulation(usda):
    corners = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
    text = f"""
def Mesh "Skin" (prepend apiSchemas = ["PhysxDeformableBodyAPI", "PhysicsMassAPI"])
{{
    point3f[] points = [(0.25, 0.25, 0.25), (0.5, 0.25, 0.25), (0.25, 0.5, 0.25)]
    int[] faceVertexCounts = [3]
    int[] faceVertexIndices = [0, 1, 2]
    point3f[] physxDeformable:simulationRestPoints = {corners}
    int[] physxDeformable:simulationIndices = [0, 1, 2, 3]
    vector3f physics:velocity = (1, 0, 0)
}}
"""
    physics, _ = usda('def PhysicsScene "S" { float physics:gravityMagnitude = 0\n }' + text)
    start = points(physics, "/Skin")
    assert start == pytest.approx(np.array([[0.25, 0.25, 0.25], [0.5, 0.25, 0.25], [0.25, 0.5, 0.25]]))
    steps(physics, 240)
    assert points(physics, "/Skin") == pytest.approx(start + np.eye(3)[0], abs=1e-6)


def test_particles_pile_up_on_the_ground(usda):
    grid = [(0.1 * i, 0.1 * j, 0.5 + 0.1 * k) for i in range(3) for j in range(3) for k in range(3)]
    text = f"""
def Points "Sand" (prepend apiSchemas = ["PhysxParticleSetAPI"])
{{
    point3f[] points = {grid}
    float[] widths = {[0.08] * 27}
}}
"""
    physics, _ = usda(PLANE + text)
    assert physics.model.body_mass.sum() == pytest.approx(27 * 1000 * 4 / 3 * math.pi * 0.04**3)
    steps(physics, 720)
    sand = points(physics, "/Sand")
    assert sand[:, 2].min() == pytest.approx(0.04, abs=5e-3)
    apart = np.linalg.norm(sand[:, None] - sand[None], axis=2) + np.eye(27)
    assert apart.min() > 0.07


ONE = "point3f[] points = [(0, 0, 0)]"
FACE = "int[] faceVertexCounts = [3]\nint[] faceVertexIndices = [0, 1, 2]"


@pytest.mark.parametrize(
    ("kind", "schema", "values", "code", "said"),
    [
        ("Points", "PhysxParticleSetAPI", f"bool physxParticle:fluid = 1\n{ONE}", "fluid-not-simulated", "fluids"),
        ("Mesh", "PhysxDeformableBodyAPI", ONE, "bad-deformable", "tetrahedra"),
        ("Mesh", "PhysxDeformableSurfaceAPI", "", "bad-deformable", "no points"),
        ("Mesh", "PhysxDeformableSurfaceAPI", f"{ONE}\n{FACE}", "bad-deformable", "do not fit"),
    ],
)
def test_what_cannot_deform_is_reported_and_stays(usda, kind, schema, values, code, said):
    text = f'def {kind} "W" (prepend apiSchemas = ["{schema}"]) {{\n{values}\n}}'
    physics, warnings = usda(text)
    assert physics is None
    assert [(each[0], each[1]) for each in warnings] == [(code, "/W")]
    assert said in warnings[0][2]


def test_an_integrator_that_cannot_take_elasticity_is_refused(usda):
    with pytest.raises(
        UserError, match=r"physics.integrator rk4 cannot integrate what is elastic \(/Cloth\); use discrete"
    ):
        usda(sheet(3, 3, 0.1), fidelity=Fidelity(physics_integrator="rk4"))


def test_a_disabled_deformable_stays(usda):
    physics, warnings = usda(sheet(3, 3, 0.1, more="bool physxDeformable:deformableEnabled = 0"))
    assert physics is None
    assert warnings == []


@pytest.mark.parametrize("fabric", ["on", "off"])
def test_fabric_has_the_points_of_cloth_where_physics_has_them(fabric):
    """Half a second of free fall."""
    from graph.sim import App

    stage = stage_of(sheet(3, 3, 0.1, at=(1, 2, 5)))
    with App(stage=stage, physics_hz=240, loop_hz=60, fidelity={"fabric": fabric}) as app:
        points = app.fabric.get_prim_at_path("/Cloth").get_attribute("points")
        app.play()
        app.update(30)
        fall = fallen(120, 1 / 240)
        assert np.array(points.get())[:, 2] == pytest.approx(np.full(9, -fall), abs=1e-3)
        assert np.array(app.fabric.get("/Cloth", "points"))[4] == pytest.approx([0.1, 0.1, -fall], abs=1e-3)
        app.stop()
        assert np.array(points.get())[:, 2] == pytest.approx(np.zeros(9))
