import math

import pytest

from graph.base.errors import Mark, UserError
from graph.sim.scene import nonvisual
from graph.sim.scene.prims import author_prims
from graph.sim.scene.stage import open_stage
from graph.sim.usd import UsdGeom, UsdPhysics, UsdShade


def authored(prims, **options):
    stage = open_stage()
    author_prims(stage, prims, **options)
    return stage


def problems(prims, stage=None, **options):
    with pytest.raises(UserError) as error:
        author_prims(stage or open_stage(), prims, **options)
    return [problem.message for problem in error.value.problems]


def test_prims_get_their_type_transform_and_sizes():
    stage = authored(
        {"/World/Box": {"type": "Cube", "size": 3, "translate": [5, 0, 0.5], "rotate": [0, 0, 90], "scale": 2}}
    )
    assert stage.GetPrimAtPath("/World").GetTypeName() == "Xform"
    box = UsdGeom.Cube(stage.GetPrimAtPath("/World/Box"))
    assert box.GetSizeAttr().Get() == 3.0
    assert list(box.GetLocalTransformation().Transform((1, 0, 0))) == pytest.approx([5, 2, 0.5])


def test_an_orientation_is_w_x_y_z_and_need_not_be_of_unit_length():
    stage = authored({"/A": {"orient": [2, 0, 0, 2]}})
    local = UsdGeom.Xformable(stage.GetPrimAtPath("/A")).GetLocalTransformation()
    assert list(local.Transform((1, 0, 0))) == pytest.approx([0, 1, 0])


def test_shapes_collide_by_default_and_bodies_take_mass_and_speed():
    stage = authored(
        {
            "/A": {
                "type": "Sphere",
                "rigid_body": True,
                "mass": 2,
                "velocity": [1, 2, 3],
                "angular_velocity": [0, 0, 90],
            },
            "/B": {"type": "Cube", "collision": False},
            "/C": {"type": "Xform", "density": 500},
            "/D": {"type": "OmniLidar"},
        }
    )
    a, b, c, d = (stage.GetPrimAtPath(f"/{name}") for name in "ABCD")
    assert UsdPhysics.CollisionAPI(a).GetCollisionEnabledAttr().Get()
    assert UsdPhysics.MassAPI(a).GetMassAttr().Get() == 2
    assert list(UsdPhysics.RigidBodyAPI(a).GetVelocityAttr().Get()) == [1, 2, 3]
    assert list(UsdPhysics.RigidBodyAPI(a).GetAngularVelocityAttr().Get()) == [0, 0, 90]
    assert not b.HasAPI(UsdPhysics.CollisionAPI)
    assert UsdPhysics.MassAPI(c).GetDensityAttr().Get() == 500
    assert not d.HasAPI(UsdPhysics.CollisionAPI)


def test_an_existing_prim_keeps_what_is_not_said():
    stage = open_stage()
    cube = UsdGeom.Cube.Define(stage, "/A")
    cube.AddTransformOp().Set(cube.GetLocalTransformation().SetTranslate((1, 2, 3)))
    author_prims(stage, {"/A": {"scale": [2, 2, 2], "visible": False}})
    local = cube.GetLocalTransformation()
    assert list(local.Transform((1, 0, 0))) == pytest.approx([3, 2, 3])
    assert cube.GetVisibilityAttr().Get() == "invisible"
    assert problems({"/A": {"type": "Sphere"}}, stage) == [
        "/A: type: the scene already has Cube there; leave the type out to change it"
    ]


def test_attributes_take_their_type_from_the_schema_and_bring_it_along():
    stage = authored(
        {
            "/L": {
                "type": "OmniLidar",
                "attributes": {
                    "omni:sensor:tickRate": 10,
                    "omni:sensor:Core:accumulateOutputs": False,
                    "omni:sensor:Core:emitterState:s002:azimuthDeg": [1, 2.5],
                    "omni:sensor:Core:originErrorMean": [1, 2, 3],
                },
            },
            "/B": {"attributes": {"physics:mass": 4, "physics:principalAxes": [1, 0, 0, 0]}},
            "/J": {
                "type": "PhysicsRevoluteJoint",
                "attributes": {
                    "physics:body0": "/B",
                    "physics:body1": ["/L"],
                    "physics:axis": "Y",
                    "physics:upperLimit": math.inf,
                    "drive:angular:physics:damping": 3,
                },
            },
        }
    )
    lidar, body, joint = (stage.GetPrimAtPath(path) for path in ("/L", "/B", "/J"))
    assert lidar.GetAttribute("omni:sensor:tickRate").Get() == 10.0
    assert "OmniSensorGenericLidarCoreEmitterStateAPI:s002" in lidar.GetAppliedSchemas()
    assert list(lidar.GetAttribute("omni:sensor:Core:emitterState:s002:azimuthDeg").Get()) == [1, 2.5]
    assert body.HasAPI(UsdPhysics.MassAPI)
    assert joint.HasAPI(UsdPhysics.DriveAPI, "angular")
    assert [str(path) for path in joint.GetRelationship("physics:body0").GetTargets()] == ["/B"]
    assert joint.GetAttribute("physics:upperLimit").Get() == math.inf


@pytest.mark.parametrize(
    ("kind", "name", "value"),
    [
        ("Camera", "isaac:nameOverride", "left_eye"),
        ("Xform", "isaac:namespace", "robot_1"),
        ("DistantLight", "omni:rtx:usdluxVersion", 2505),
        ("Camera", "omni:kit:centerOfInterest", (0.0, 0.0, -5.0)),
    ],
)
def test_attributes_that_isaac_sim_reads_without_a_schema_can_be_written(kind, name, value):
    stage = authored({"/A": {"type": kind, "attributes": {name: value}}})
    assert stage.GetPrimAtPath("/A").GetAttribute(name).Get() == value


def test_a_sensors_configuration_comes_first_and_attributes_win():
    def configure(prim, config, variant):
        assert (config, variant) == ("OS1", "REV6")
        prim.GetAttribute("omni:sensor:tickRate").Set(20.0)
        prim.GetAttribute("omni:sensor:Core:maxReturns").Set(1)

    keys = {"type": "OmniLidar", "config": "OS1", "variant": "REV6", "aux_output_level": "FULL"}
    stage = authored(
        {"/L": {**keys, "exclude": ["/Mount"], "attributes": {"omni:sensor:tickRate": 5}}, "/Mount": {}},
        sensor_config=configure,
    )
    lidar = stage.GetPrimAtPath("/L")
    assert lidar.GetAttribute("omni:sensor:tickRate").Get() == 5.0
    assert lidar.GetAttribute("omni:sensor:Core:maxReturns").Get() == 1
    assert list(lidar.GetAttribute("_replicator:rendervar:GenericModelOutput:channels").Get()) == ["FULL"]
    assert [str(path) for path in lidar.GetRelationship("tickgraph:exclude").GetTargets()] == ["/Mount"]


def test_what_a_configuration_refuses_is_reported_at_its_key():
    def configure(prim, config, variant):
        raise UserError(f"there is no lidar configuration {config!r}")

    marks = {("/L", None): Mark("f.yaml", 3, 5), ("/L", "config"): Mark("f.yaml", 3, 20)}
    with pytest.raises(UserError, match=r"^f\.yaml:3:20: /L: config: there is no lidar configuration 'OS9'$"):
        author_prims(
            open_stage(),
            {"/L": {"type": "OmniLidar", "config": "OS9"}},
            lambda path, key=None: marks.get((path, key)),
            sensor_config=configure,
        )


def test_materials_labels_and_colours_are_bound():
    material = {"base": "aluminum", "coating": "paint", "attributes": "emissive"}
    stage = authored(
        {
            "/A": {"type": "Cube", "material": material, "semantics": "crate", "color": [1, 0, 0.5]},
            "/B": {"type": "Cube", "material": material, "semantics": {"class": ["a", "b"], "id": "c"}},
        }
    )
    bound = [
        UsdShade.MaterialBindingAPI(stage.GetPrimAtPath(path)).ComputeBoundMaterial()[0].GetPrim()
        for path in ("/A", "/B")
    ]
    assert bound[0] == bound[1]
    names = [bound[0].GetAttribute(f"omni:simready:nonvisual:{key}").Get() for key in ("base", "coating", "attributes")]
    assert names == ["aluminum", "paint", "emissive"]
    assert nonvisual.encode(*names) == 2305
    assert list(stage.GetPrimAtPath("/A").GetAttribute("semantics:labels:class").Get()) == ["crate"]
    assert list(stage.GetPrimAtPath("/B").GetAttribute("semantics:labels:id").Get()) == ["c"]
    assert UsdGeom.Cube(stage.GetPrimAtPath("/A")).GetDisplayColorAttr().Get()[0] == (1, 0, 0.5)


def test_a_reference_brings_its_default_prim_and_says_when_units_differ(tmp_path):
    (tmp_path / "part.usda").write_text('#usda 1.0\n(\n metersPerUnit = 0.01\n upAxis = "Z"\n)\ndef Cube "Only" {}\n')
    warnings = []
    stage = authored(
        {"/P": {"reference": "part.usda", "translate": [1, 0, 0]}},
        folder=tmp_path,
        warn=lambda *warning: warnings.append(warning),
    )
    assert stage.GetPrimAtPath("/P").GetTypeName() == "Cube"
    [(code, place, message)] = warnings
    assert (code, place) == ("units-mismatch", "/P")
    assert message.endswith("its unit is 0.01 m, that of the stage 1 m, so scale the prim by 0.01")
    (tmp_path / "sub").mkdir()
    assert "lies outside" in problems({"/P": {"reference": "../part.usda"}}, folder=tmp_path / "sub")[0]
    assert "no such scene file" in problems({"/P": {"reference": "gone.usda"}}, folder=tmp_path)[0]


def test_every_problem_of_every_prim_is_reported_with_the_nearest_name():
    nan = float("nan")
    found = problems(
        {
            "World": {},
            "/A b": {},
            "/N": 3,
            "/T": {"type": "Cubee"},
            "/K": {"translte": [0, 0, 0]},
            "/C": {
                "type": "Cube",
                "radius": 1,
                "size": 0,
                "translate": [1, 2],
                "orient": [0, 0, 0, 0],
                "scale": [1, 0, 1],
            },
            "/D": {
                "type": "Sphere",
                "radius": nan,
                "mass": -1,
                "velocity": [1, 2, 3],
                "visible": "yes",
                "color": "red",
            },
            "/M": {"type": "Mesh", "points": [[0, 0, 0], [1, 0, 0]], "faces": [[0, 1, 2]]},
            "/L": {
                "type": "OmniLidar",
                "config": "OS1",
                "exclude": ["/Cc"],
                "aux_output_level": "ALL",
                "attributes": {
                    "omni:sensor:tickrate": 1,
                    "omni:sensor:tickRate": nan,
                    "omni:sensor:Core:scanType": "ROT",
                    "omni:sensor:Core:scanRateBaseHz": -1,
                    "omni:sensor:Core:maxReturns": 1.5,
                },
            },
            "/S": {"type": "Scope", "translate": [0, 0, 0], "material": "aluminium", "schemas": ["PhysicsMass"]},
            "/O": {"orient": [1, 0, 0, 0], "rotate": [0, 0, 0]},
        }
    )
    expected = [
        "'World' is not the path of a prim; write it as /World/Box, from the root",
        "'/A b' is not the path of a prim; write it as /World/Box (letters, digits and _)",
        "/N: a prim is written as a mapping such as {type: Cube, size: 1.0}",
        "/T: type: there is no prim type 'Cubee'; did you mean \"Cube\"?",
        '/K: there is no key "translte"; did you mean "translate"?',
        "/C: translate: [1, 2] is not a list of 3 numbers",
        "/C: orient: a quaternion of zeros is not a rotation",
        "/C: scale: a scale of 0 makes it flat",
        "/C: size: 0 is not above 0",
        "/C: radius: Cube has no radius; it has size",
        "/D: radius: nan is not a finite number",
        "/D: mass: -1 is not above 0",
        "/D: velocity: only a body moves by itself; add rigid_body: true",
        "/D: visible: 'yes' is neither true nor false",
        "/D: color: 'red' is not a list of 3 numbers",
        "/M: points: 1 faces have points that do not exist",
        "/L: config: there are no sensor configurations here",
        "/L: aux_output_level: 'ALL' is not one of NONE, BASIC, EXTRA, FULL",
        "/L: attributes: omni:sensor:tickrate: OmniLidar has no attribute 'omni:sensor:tickrate'; did you mean "
        '"omni:sensor:tickRate"?',
        "/L: attributes: omni:sensor:tickRate: nan is not a finite number",
        "/L: attributes: omni:sensor:Core:scanType: 'ROT' is not one of ROTARY, SOLID_STATE",
        "/L: attributes: omni:sensor:Core:scanRateBaseHz: -1 is not a whole number from 0 that a uint can hold",
        "/L: attributes: omni:sensor:Core:maxReturns: 1.5 is not a whole number from 0 that a uint can hold",
        "/S: schemas: there is no API schema 'PhysicsMass'; did you mean \"PhysicsMassAPI\"?",
        "/S: translate: Scope has no transform",
        "/S: material: there is no material base 'aluminium'; did you mean \"aluminum\"?",
        "/O: orient: orient and rotate exclude each other",
        "/L: exclude: there is no prim '/Cc'; did you mean \"/C\"?",
    ]
    assert found == expected


@pytest.mark.parametrize(("word", "key"), [("position", "translate"), ("Rotation", "rotate"), ("quat", "orient")])
def test_words_of_other_tools_are_answered_with_the_key(word, key):
    [found] = problems({"/A": {"type": "Cube", word: [0, 0, 1]}})
    assert found == f'/A: there is no key "{word}"; did you mean "{key}"?'


def test_a_path_deeper_than_256_is_refused():
    assert problems({"/a" * 257: {}}) == [f"{('/a' * 257)[:80]}... is deeper than 256 prims"]
    authored({"/a" * 256: {}})


def test_nothing_is_added_below_an_instance():
    stage = open_stage()
    stage.DefinePrim("/Proto/Part", "Cube")
    copy = stage.DefinePrim("/Copy", "Xform")
    copy.GetReferences().AddInternalReference("/Proto")
    copy.SetInstanceable(True)
    assert problems({"/Copy/New": {"type": "Cube"}}, stage) == [
        "/Copy/New: type: /Copy is an instance; nothing can be added below it"
    ]


def test_a_key_that_ends_an_attribute_s_name_is_reported_where_that_is_written():
    with pytest.raises(UserError) as caught:
        author_prims(
            open_stage(),
            {
                "/L": {"type": "OmniLidar", "tick_rate": 7.5, "translation": [0, 0, 1]},
                "/M": {"type": "OmniLidar", "attributes": {"tickRate": 10}},
            },
        )
    assert [problem.message for problem in caught.value.problems] == [
        '/L: there is no key "tick_rate"; did you mean attributes: {"omni:sensor:tickRate": 7.5}?',
        '/L: there is no key "translation"; did you mean "translate"?',
        "/M: attributes: tickRate: OmniLidar has no attribute 'tickRate'; did you mean \"omni:sensor:tickRate\"?",
    ]


@pytest.mark.parametrize("parts", [[1e308, 1e308, 0, 0], [1e-308, 1e-308, 0, 0], [2, 2, 0, 0]])
def test_a_quaternion_of_any_length_is_the_same_rotation(parts):
    stage = authored({"/A": {"type": "Cube", "orient": parts}})
    turned = stage.GetPrimAtPath("/A").GetAttribute("xformOp:orient").Get()
    assert (turned.GetReal(), *turned.GetImaginary()) == pytest.approx((0.5**0.5, 0.5**0.5, 0, 0))


@pytest.mark.parametrize("name", ["", ":", "a:", "a b", "1"])
def test_what_cannot_be_the_name_of_an_attribute_is_reported(name):
    with pytest.raises(UserError, match="this cannot be the name of an attribute"):
        authored({"/A": {"type": "Cube", "attributes": {name: 1}}})
