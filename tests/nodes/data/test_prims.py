import numpy as np
import pytest
from pxr import UsdGeom, UsdShade

from graph import ComputeError
from graph.testing import run_node


@pytest.fixture
def scene(stage):
    """/World with /World/BoxA (a Cube with a size), /World/BoxB (a Sphere), /World/Group/BoxC (a Cube)."""
    UsdGeom.Xform.Define(stage, "/World")
    UsdGeom.Cube.Define(stage, "/World/BoxA").AddTranslateOp().Set((1, 2, 3))
    UsdGeom.Sphere.Define(stage, "/World/BoxB")
    UsdGeom.Xform.Define(stage, "/World/Group").AddTranslateOp().Set((10, 0, 0))
    UsdGeom.Cube.Define(stage, "/World/Group/BoxC").AddTranslateOp().Set((0, 5, 0))
    stage.GetPrimAtPath("/World/BoxB").CreateRelationship("friend").SetTargets(["/World/BoxA"])
    return stage


@pytest.mark.parametrize(
    ("wanted", "paths"),
    [
        ({}, ["/World/BoxA", "/World/BoxB", "/World/Group"]),
        ({"recursive": True}, ["/World/BoxA", "/World/BoxB", "/World/Group", "/World/Group/BoxC"]),
        ({"recursive": True, "namePrefix": "Box", "type": "Cube"}, ["/World/BoxA", "/World/Group/BoxC"]),
        ({"type": "* ^Cube"}, ["/World/BoxB", "/World/Group"]),
        ({"type": "C* S*"}, ["/World/BoxA", "/World/BoxB"]),
        ({"requiredAttributes": "radius visibility"}, ["/World/BoxB"]),
        ({"requiredRelationship": "friend"}, ["/World/BoxB"]),
        ({"requiredRelationship": "friend", "requiredRelationshipTarget": "/World/BoxA"}, ["/World/BoxB"]),
        ({"requiredRelationship": "friend", "requiredRelationshipTarget": "/World"}, []),
        ({"rootPrimPath": "/World/Group"}, ["/World/Group/BoxC"]),
        ({"rootPrim": "/World/Group"}, ["/World/Group/BoxC"]),
        ({"recursive": True, "pathPattern": "*Box* ^*/BoxB"}, ["/World/BoxA", "/World/Group/BoxC"]),
        ({"requiredRelationship": "friend", "requiredTarget": "/World/BoxA"}, ["/World/BoxB"]),
        ({"requiredRelationship": "friend", "requiredTarget": "/World/BoxB"}, []),
        ({"rootPrimPath": "/Nowhere"}, []),
    ],
)
def test_prims_are_found_by_all_that_is_asked(world, scene, wanted, paths):
    trace = run_node("FindPrims", inputs={"rootPrimPath": "/World", **wanted}, app=world())
    assert trace.value("primPaths") == trace.value("prims") == paths


def test_without_a_root_the_whole_stage_is_searched(world, scene):
    trace = run_node("FindPrims", inputs={"recursive": True, "type": "Sphere"}, app=world())
    assert trace.value("primPaths") == ["/World/BoxB"]


def test_paths_of_prims():
    trace = run_node("GetPrimPath", inputs={"prim": ["/World/A", "/World/B"]})
    assert (trace.value("primPath"), trace.value("path")) == ("/World/A", "/World/A")
    assert run_node("GetPrimPath").value("primPath") == ""
    assert run_node("GetPrimPaths", inputs={"prims": ["/A", "/B"]}).value("primPaths") == ["/A", "/B"]


def test_targets_are_made_of_paths():
    one = run_node("ToTarget", inputs={"value": {"type": "token", "value": "/A"}})
    assert one.value("converted") == ["/A"]
    many = run_node("ToTarget", inputs={"value": {"type": "token[]", "value": ["/A", "", "/B"]}})
    assert many.value("converted") == ["/A", "/B"]
    with pytest.raises(ComputeError, match='input value holds "A", which is not an absolute path'):
        run_node("ToTarget", inputs={"value": {"type": "token", "value": "A"}})


def test_whether_a_prim_is_active(world, scene):
    app = world()
    assert run_node("IsPrimActive", inputs={"primTarget": "/World/BoxA"}, app=app).value("active") is True
    with app.edit("recompile"):
        scene.GetPrimAtPath("/World/BoxA").SetActive(False)
    assert run_node("IsPrimActive", inputs={"primTarget": "/World/BoxA"}, app=app).value("active") is False
    assert run_node("IsPrimActive", inputs={"primTarget": "/World/No"}, app=app).value("active") is False


def test_transforms_are_row_vector_matrices_of_this_moment(world, scene):
    app = world()
    local = run_node("ReadPrimLocalTransform", inputs={"prim": "/World/Group/BoxC"}, app=app).value("value")
    assert local[3].tolist() == [0, 5, 0, 1]
    inputs = {"usePath": True, "primPath": "/World/Group/BoxC"}
    placed = run_node("GetPrimLocalToWorldTransform", inputs=inputs, app=app).value("localToWorldTransform")
    assert placed[3].tolist() == [10, 5, 0, 1]
    missing = run_node("ReadPrimLocalTransform", inputs={"prim": "/World/No"}, app=app)
    assert np.array_equal(missing.value("value"), np.eye(4))


def test_a_material_is_bound(world, scene):
    material = UsdShade.Material.Define(scene, "/World/Red")
    inputs = {"primPath": "/World/BoxA", "materialPath": "/World/Red"}
    app = world()
    trace = run_node("WritePrimMaterial", inputs=inputs, pulses={"execIn": [0]}, app=app)
    bound, _ = UsdShade.MaterialBindingAPI(scene.GetPrimAtPath("/World/BoxA")).ComputeBoundMaterial()
    assert bound.GetPath() == material.GetPath()
    assert trace.fired("execOut") == [0]
    with pytest.raises(ComputeError, match="/World/BoxB is not a Material but Sphere"):
        run_node("WritePrimMaterial", inputs=inputs | {"materialPath": "/World/BoxB"}, pulses={"execIn": [0]}, app=app)


def test_graphs_and_their_nodes_are_left_out_where_that_is_asked(world, scene):
    scene.DefinePrim("/World/Graph", "OmniGraph")
    scene.DefinePrim("/World/Graph/node", "OmniGraphNode")
    for ignored, count in ((False, 6), (True, 4)):
        inputs = {"rootPrimPath": "/World", "recursive": True, "ignoreSystemPrims": ignored}
        assert len(run_node("FindPrims", inputs=inputs, app=world()).value("prims")) == count


def test_the_material_of_a_prim_is_the_one_bound_to_it_or_above_it(world, scene):
    material = UsdShade.Material.Define(scene, "/World/Paint")
    UsdShade.MaterialBindingAPI.Apply(scene.GetPrimAtPath("/World/Group")).Bind(material)
    for prim, path in (("/World/Group/BoxC", "/World/Paint"), ("/World/BoxA", "")):
        trace = run_node("ReadPrimMaterial", inputs={"primPath": prim}, app=world())
        assert trace.value("material") == path
        assert trace.value("materialPrim") == ([path] if path else [])
    both = {"primPath": "/World/BoxA", "prim": "/World/Group"}
    assert run_node("ReadPrimMaterial", inputs=both, app=world()).value("material") == "/World/Paint"
