import json
from pathlib import Path

import pytest

from graph.base.errors import UserError
from graph.cli.main import main
from graph.sim import App
from graph.sim.physics.authored_settings import check_settings
from graph.sim.scene.physics_settings import NAMESPACES, SIMULATED
from graph.sim.scene.stored_settings import QUIET_SCHEMAS, STORED, UNKNOWN, stored_as
from graph.sim.usd import Tf, Usd, UsdGeom
from tests.support.physics_worlds import METRES, stage_of

PUBLIC = json.loads((Path(__file__).parent / "physics_schemas.json").read_text())["schemas"]
"""Names of attributes by schema, as PhysX, Newton and MuJoCo publish them."""

TOLD_BY_TYPE = {
    name
    for kind in ("PhysxPhysicsInstancer", "PhysxPhysicsJointInstancer", "PhysxPhysicsGearJoint")
    for name in PUBLIC[kind]
} | {"physics:hinge", "physics:prismatic", "physics:ratio"}
"""Attributes of prims of which already the type is not simulated."""

BODY = """
def PhysicsScene "S" {{ {scene}
}}
def Cube "A" (prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsCollisionAPI"{apis}])
{{
    {lines}
}}
"""


def body(*lines, scene="", apis=()):
    return BODY.format(lines="\n    ".join(lines), scene=scene, apis="".join(f', "{api}"' for api in apis))


def told(stage, **options):
    """What is said of a stage (or its text), (where, message) each."""
    found = []
    stage = stage_of(stage) if isinstance(stage, str) else stage
    check_settings(stage, lambda code, where, message: found.append((code, where, message)), **options)
    assert {code for code, *_ in found} <= {"physics-setting-stored"}
    return [(where, message) for _, where, message in found]


def usd_physics_names():
    registry = Usd.SchemaRegistry()
    for kind in Tf.Type.FindByName("UsdSchemaBase").GetAllDerivedTypes():
        if kind.typeName.startswith("UsdPhysics"):
            name = registry.GetSchemaTypeName(kind)
            found = registry.FindAppliedAPIPrimDefinition(name) or registry.FindConcretePrimDefinition(name)
            for each in found.GetPropertyNames() if found else ():
                if each.startswith(NAMESPACES):
                    yield each.replace("__INSTANCE_NAME__", "*")


def test_every_property_of_usd_physics_is_simulated():
    names = set(usd_physics_names())
    assert len(names) > 40
    assert names <= SIMULATED.keys()


def test_every_public_attribute_is_simulated_or_has_words_of_its_own():
    names = {name for names in PUBLIC.values() for name in names if name.startswith(NAMESPACES)}
    assert len(names) > 600
    left = names - TOLD_BY_TYPE
    assert [name for name in left if name not in SIMULATED and stored_as(name) is UNKNOWN] == []


def test_every_public_schema_has_words_of_its_own_or_attributes_that_have():
    silent = [schema for schema in PUBLIC if schema in QUIET_SCHEMAS and not PUBLIC[schema]]
    unknown = [schema for schema in PUBLIC if schema not in QUIET_SCHEMAS and stored_as(schema) is UNKNOWN]
    assert (silent, unknown) == (["PhysxTriggerAPI"], [])  # which is simulated by itself


def test_no_row_of_the_table_speaks_of_names_that_another_one_has():
    exact = [name for row in STORED for name in row.names if "*" not in name]
    assert len(exact) == len(set(exact))
    assert not set(exact) & SIMULATED.keys()


def test_settings_that_ask_for_the_same_are_one_line_at_the_first_of_them():
    lines = ("float physxCollision:contactOffset = 0.02", "float physxCollision:restOffset = 0.01")
    text = body(*lines) + f'def Cube "B" {{ {lines[0]}\n}}\n'
    ((where, message),) = told(text)
    assert where == "/A.physxCollision:contactOffset"
    assert message.startswith("it is kept on the prim and changes nothing (2 prims): ")
    assert message.endswith("; so does physxCollision:restOffset")


def test_values_that_ask_for_what_happens_anyway_are_not_reported():
    assert not told(
        body(
            "bool physxRigidBody:enableCCD = 0",
            "bool physxRigidBody:enableGyroscopicForces = 1",
            "float physxCollision:contactOffset = -inf",
            "float physxRigidBody:sleepThreshold = 0",
            scene="bool physxScene:enableGPUDynamics = 0",
            apis=("PhysxRigidBodyAPI", "PhysxCollisionAPI"),
        )
    )
    assert told(body("bool physxRigidBody:enableGyroscopicForces = 0"))


def test_a_setting_on_a_prim_where_it_does_not_count_says_where_it_would():
    text = body() + 'def Xform "X" { vector3f physics:velocity = (1, 0, 0)\n}\n'
    assert told(text) == [
        (
            "/X.physics:velocity",
            "it is kept on the prim and changes nothing: it counts on a rigid body (PhysicsRigidBodyAPI) "
            "or a deformable",
        )
    ]


def test_a_drive_of_an_axis_that_the_joint_does_not_have_is_reported():
    text = body() + (
        'def PhysicsRevoluteJoint "J" (prepend apiSchemas = ["PhysicsDriveAPI:linear"])\n'
        "{ rel physics:body1 = </A>\n float drive:linear:physics:stiffness = 5\n}\n"
    )
    ((where, message),) = told(text)
    assert where == "/J.drive:linear:physics:stiffness"
    assert message.endswith("this joint has no axis linear; write angular in its place")


def test_a_misspelt_name_is_reported_with_the_one_that_was_meant():
    ((_, message),) = told(body("float physxRigidBody:linearDampng = 1"))
    assert message.endswith('did you mean "physxRigidBody:linearDamping"?')


def test_a_schema_without_attributes_is_reported_too():
    ((where, message),) = told(body(apis=("PhysxVehicleAPI",)))
    assert where == "/A"
    assert message.startswith("PhysxVehicleAPI is kept on the prim and changes nothing: vehicles are not simulated")


def test_what_instances_share_is_looked_at_once():
    stage = stage_of('class Xform "Part" {\ndef Xform "P" { float physxRigidBody:enableCCD = 1\n}\n}\n')
    for number in range(3):
        prim = UsdGeom.Xform.Define(stage, f"/I{number}").GetPrim()
        prim.GetReferences().AddInternalReference("/Part")
        prim.SetInstanceable(True)
    ((where, message),) = told(stage)
    assert where == "/I0/P.physxRigidBody:enableCCD"
    assert "prims)" not in message


def test_attributes_of_a_mirrored_model_are_its_own():
    text = body("double mjc:margin = 0.1")
    assert told(text)
    assert not told(text, mirrors=True)


@pytest.mark.parametrize(
    ("line", "problem"),
    [
        ("token physics:mass = 'x'", "/A.physics:mass is a token; it must be a float"),
        ("float physics:velocity = 1", "/A.physics:velocity is a float; it must be a vector3f"),
        (
            "rel physics:velocity = </S>",
            "/A.physics:velocity is a relationship; it must be an attribute: `vector3f physics:velocity = ...`",
        ),
        (
            'token physics:filteredPairs = "/S"',
            "/A.physics:filteredPairs is an attribute; it must be a relationship: `rel physics:filteredPairs = "
            "</Path/Of/Prim>`",
        ),
        (
            "string physxRigidBody:linearDamping = 'x'",
            "/A.physxRigidBody:linearDamping is a string; it must be a float",
        ),
        ("float3 physics:principalAxes = (1, 0, 0)", "/A.physics:principalAxes is a float3; it must be a quatf"),
    ],
)
def test_a_property_of_another_type_than_its_schema_says_is_one_line(line, problem):
    with pytest.raises(UserError) as caught:
        told(body(line))
    assert [one.message for one in caught.value.problems] == [problem]


def test_numbers_of_another_width_are_taken():
    assert not told(body("double physics:mass = 2", "int physxRigidBody:linearDamping = 1", "half physics:density = 3"))


def test_check_explain_and_run_tell_it_once(tmp_path, capsys):
    file = tmp_path / "scene.usda"
    file.write_text(METRES + body("bool physxRigidBody:enableCCD = 1"))
    line = "physics-setting-stored: /A.physxRigidBody:enableCCD: it is kept on the prim"
    for command in (("check",), ("explain",), ("run", "--updates", "2")):
        assert main([command[0], str(file), *command[1:]]) == 0
        assert "".join(capsys.readouterr()).count(line) == 1, command


def test_an_app_tells_it_at_play_and_after_an_edit_that_brings_more():
    with App(stage_of(body("bool physxRigidBody:enableCCD = 1"))) as app:
        app.play()
        app.update()
        with app.edit(when_playing="recompile") as stage:
            stage.GetPrimAtPath("/A").CreateAttribute("physxCollision:restOffset", _float()).Set(0.1)
        assert [one.where for one in app.warnings if one.code == "physics-setting-stored"] == [
            "/A.physxRigidBody:enableCCD",
            "/A.physxCollision:restOffset",
        ]


def _float():
    from graph.sim.usd import Sdf

    return Sdf.ValueTypeNames.Float
