"""Object ids: what a map holds as documented, and what it holds besides so that every hit has a path."""

import warnings

import numpy as np
import pytest
from pxr import Gf, UsdGeom

import sensors.replicator as rep
from sensors import parse_generic_model_output_data, parse_object_ids, parse_stable_id_map_data
from sensors.handles import handle
from sensors.surfaces.ids import pack_stable_id_map, stable_id, stable_id_map
from tests.support.lidar_worlds import add_box, define_lidar, rotary, weightless

PATHS = ("/World/Böx", "/World/Car/paint", "/World/Rocks[7]", "/World/Rocks[8]/Lid")


def number(path):
    return int.from_bytes(stable_id(path), "little")


def test_ids_of_copies_differ_in_their_high_32_bits_alone():
    low = 2**96 - 1
    assert number("/World/Rocks[7]") & low == number("/World/Rocks") == number("/World/Rocks[0]") & low
    assert [number(f"/World/Rocks{copy}") >> 96 for copy in ("", "[0]", "[7]")] == [0, 1, 8]
    assert number("/World/Rocks[7]/Lid") & low == number("/World/Rocks/Lid")
    assert len({number(path) for path in PATHS}) == 4


def documented(buffer):
    """The map as the original's documentation reads it: nothing but the last word and the table at the start."""
    data = buffer.tobytes()
    table = np.frombuffer(data[: 24 * int.from_bytes(data[-4:], "little")], "<u4").reshape(-1, 6)
    return {
        int.from_bytes(row[:4].tobytes(), "little"): data[row[5] : row[5] + row[4]].decode().rstrip() for row in table
    }


def test_the_documented_map_has_prims_and_subsets_and_all_of_it_the_copies_too():
    buffer = pack_stable_id_map(stable_id_map(PATHS))

    prims = {number(path): path for path in PATHS[:2]}
    assert parse_stable_id_map_data(buffer) == documented(buffer) == prims
    assert parse_stable_id_map_data(buffer, resolve_all=True) == {number(path): path for path in PATHS}


@pytest.mark.parametrize("convert", [bytes, memoryview, lambda b: b.view("<u4"), lambda b: b.reshape(-1, 4), handle])
def test_maps_are_read_from_any_kind_of_buffer(convert):
    buffer = pack_stable_id_map(stable_id_map(PATHS))
    buffer.setflags(write=False)

    assert len(parse_stable_id_map_data(convert(buffer), resolve_all=True)) == 4


def test_an_empty_map_and_one_of_the_originals_have_no_second_table():
    assert parse_stable_id_map_data(pack_stable_id_map({}), resolve_all=True) == {}
    assert parse_stable_id_map_data(np.zeros(4, np.uint8), resolve_all=True) == {}
    assert parse_stable_id_map_data(np.zeros(0, np.uint8), resolve_all=True) == {}


@pytest.mark.parametrize(
    "buffer", [np.full(20, 255, np.uint8), np.zeros(3, np.uint8), b"\1", np.zeros(8), object(), 2**60]
)
def test_what_is_not_a_map_warns_and_is_empty(buffer):
    with pytest.warns(RuntimeWarning, match="empty StableIdMap"):
        assert parse_stable_id_map_data(buffer, resolve_all=True) == {}


def test_any_flipped_or_cut_byte_of_a_map_is_survived():
    whole = pack_stable_id_map(stable_id_map(PATHS))
    generator = np.random.default_rng(1)
    for _ in range(500):
        buffer = whole[: generator.integers(1, len(whole) + 1)].copy()
        buffer[generator.integers(0, len(buffer))] ^= generator.integers(1, 256)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            assert isinstance(parse_stable_id_map_data(buffer, resolve_all=True), dict)


def mesh_with_subsets(stage, path):
    """A box 2 m wide about the origin at x = 5: its face towards -x is the subset `front`, one face in none."""
    mesh = UsdGeom.Mesh.Define(stage, path)
    corners = [(x, y, z) for x in (4, 6) for y in (-1, 1) for z in (-1, 1)]
    mesh.CreatePointsAttr([Gf.Vec3f(*corner) for corner in corners])
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    mesh.CreateFaceVertexCountsAttr([4] * 6)
    mesh.CreateFaceVertexIndicesAttr([index for face in faces for index in face])
    mesh.CreateSubdivisionSchemeAttr("none")
    for name, indices in (("front", [0]), ("rest", [1, 2, 3, 4])):
        UsdGeom.Subset.CreateGeomSubset(mesh, name, "face", indices, "materialBind")
    return mesh


def rocks(stage, path):
    """Two copies of a ball, at y = 5 and y = -5."""
    instancer = UsdGeom.PointInstancer.Define(stage, path)
    UsdGeom.Sphere.Define(stage, f"{path}/Prototypes/Rock").CreateRadiusAttr(1.0)
    instancer.CreatePrototypesRel().SetTargets([f"{path}/Prototypes/Rock"])
    instancer.CreateProtoIndicesAttr([0, 0])
    instancer.CreatePositionsAttr([Gf.Vec3f(0, 5, 0), Gf.Vec3f(0, -5, 0)])


def native_instance(stage, path, position):
    """An instance of /Assets/Crate, which holds a cube."""
    if not stage.GetPrimAtPath("/Assets/Crate"):
        stage.CreateClassPrim("/Assets")
        UsdGeom.Xform.Define(stage, "/Assets/Crate")
        UsdGeom.Cube.Define(stage, "/Assets/Crate/Shape").CreateSizeAttr(2.0)
    prim = UsdGeom.Xform.Define(stage, path)
    prim.GetPrim().GetReferences().AddInternalReference("/Assets/Crate")
    prim.GetPrim().SetInstanceable(True)
    UsdGeom.XformCommonAPI(prim).SetTranslate(Gf.Vec3d(*position))


@pytest.fixture
def all_kinds():
    """A lidar among one of each: mesh with subsets ahead, copies left and right, an instance behind, a moving box."""
    with weightless(settings={"/rtx-transient/stableIds/enabled": True}) as app:
        mesh_with_subsets(app.stage, "/World/Car")
        rocks(app.stage, "/World/Rocks")
        native_instance(app.stage, "/World/CrateA", (-5, 0, 0))
        native_instance(app.stage, "/World/CrateB", (-5, 0, 10))
        add_box(app, "/World/Moving", 1.0, (4, 4, 0), velocity=(0.1, 0, 0))
        UsdGeom.Cylinder.Define(app.stage, "/World/Pole").CreateRadiusAttr(0.5)
        UsdGeom.XformCommonAPI(app.stage.GetPrimAtPath("/World/Pole")).SetTranslate(Gf.Vec3d(4, -4, 0))
        define_lidar(app, config=rotary(elevations=(0.0, -8.0)), level="EXTRA")
        yield app


def seen(app):
    product = rep.create_render_product("/World/Lidar", app=app)
    output, ids = (rep.get_annotator(name, app=app).attach(product) for name in ("GenericModelOutput", "StableIdMap"))
    app.play()
    app.update(steps=6)
    hits = parse_object_ids(parse_generic_model_output_data(output.get_data()).objId)
    return hits, parse_stable_id_map_data(ids.get_data()), parse_stable_id_map_data(ids.get_data(), resolve_all=True)


def test_every_hit_has_a_path_whatever_was_hit(all_kinds):
    hits, documented, everything = seen(all_kinds)

    assert {everything[hit] for hit in hits} == {
        "/World/Car/front",
        "/World/Rocks[0]",
        "/World/Rocks[1]",
        "/World/CrateA/Shape",
        "/World/Moving",
        "/World/Pole",
    }
    assert "/World/Car/rest" in documented.values()
    assert set(everything) - set(documented) == {number("/World/Rocks[0]"), number("/World/Rocks[1]")}


def test_excluding_an_instancer_excludes_its_copies(all_kinds):
    from sensors.prim import write_exclude

    write_exclude(all_kinds.stage.GetPrimAtPath("/World/Lidar"), ("/World/Rocks", "/World/Car"))
    hits, _, everything = seen(all_kinds)

    assert {everything[hit] for hit in hits} == {"/World/CrateA/Shape", "/World/Moving", "/World/Pole"}
