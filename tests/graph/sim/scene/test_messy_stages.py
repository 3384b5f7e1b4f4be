import re

import pytest

from graph.base.errors import UserError
from graph.sim import App
from graph.sim.geometry.collect import collect_geometry
from graph.sim.scene.stage import open_stage
from graph.sim.usd import Gf, UsdGeom

CUBE = 'def Cube "Box"\n{\n}\n'


def scene(folder, body=CUBE, meta="", name="a.usda"):
    file = folder / name
    file.write_text(f'#usda 1.0\n(\n metersPerUnit = 1\n upAxis = "Z"\n{meta}\n)\n{body}', encoding="utf-8")
    return file


def opened(file, **options):
    warnings = []
    stage = open_stage(file, warn=lambda *warning: warnings.append(warning), **options)
    parts = collect_geometry(stage, 1e-3, lambda *warning: warnings.append(warning))
    return parts, warnings


@pytest.mark.parametrize("rate", ["0", "-24", "nan", "inf"])
def test_time_codes_that_make_no_sense_are_refused_with_the_file(tmp_path, rate):
    with pytest.raises(UserError, match=r"a\.usda: timeCodesPerSecond is .*greater than 0"):
        open_stage(scene(tmp_path, meta=f"timeCodesPerSecond = {rate}"))


def test_all_that_is_wrong_with_the_metadata_is_reported_at_once(tmp_path):
    file = tmp_path / "a.usda"
    file.write_text('#usda 1.0\n(\n metersPerUnit = -1\n upAxis = "X"\n timeCodesPerSecond = 0\n)\n')
    with pytest.raises(UserError) as caught:
        open_stage(file)
    assert [problem.message.split(": ")[1].split(" is ")[0] for problem in caught.value.problems] == [
        "metersPerUnit",
        "upAxis",
        "timeCodesPerSecond",
    ]


@pytest.mark.parametrize("there", [True, False])
def test_a_relative_path_out_of_the_folder_is_refused_whether_or_not_anything_is_there(tmp_path, there):
    (tmp_path / "inner").mkdir()
    if there:
        scene(tmp_path, name="other.usda")
    file = scene(tmp_path / "inner", 'def "P" ( references = @../other.usda@</Box> )\n{\n}\n')
    with pytest.raises(UserError, match=r"other\.usda .*--allow"):
        open_stage(file)
    _, warnings = opened(file, allow_roots=[tmp_path])
    assert bool(warnings) is not there


def test_a_relative_path_that_comes_back_into_the_folder_is_only_missing(tmp_path):
    _, warnings = opened(scene(tmp_path, 'def "P" ( references = @sub/../gone.usda@ )\n{\n}\n'))
    assert [code for code, *_ in warnings] == ["usd-missing-asset"]


def test_missing_assets_are_one_line_a_layer_and_urls_are_among_them(tmp_path):
    wanted = "[@gone.usd@, @/nowhere/abs.usd@, @omniverse://server/x.usd@, @https://example.com/y.usd@]"
    file = scene(tmp_path, f'def "P" ( references = {wanted} )\n{{\n}}\n' + CUBE, "subLayers = [@sub/layer.usda@]")
    parts, warnings = opened(file)
    assert [part.path for part in parts] == ["/Box"]
    ((code, where, message),) = warnings
    assert (code, where) == ("usd-missing-asset", str(file))
    assert all(
        name in message for name in ("gone.usd", "/nowhere/abs.usd", "://server/x.usd", "y.usd", "sub/layer.usda")
    )


@pytest.mark.parametrize(
    "body",
    [
        'def "A" ( references = </B> )\n{\n}\ndef "B" ( references = </A> )\n{\n}\n',
        'def "A" ( references = @a.usda@</A> )\n{\n}\n',
        'def "A" ( references = </A/B> )\n{\n def "B"\n {\n }\n}\n',
        'def "A" ( references = </Nothing> )\n{\n}\n',
    ],
)
def test_cycles_and_references_to_nothing_are_one_line(tmp_path, body):
    parts, warnings = opened(scene(tmp_path, body + CUBE))
    assert [part.path for part in parts] == ["/Box"]
    ((code, _, message),) = warnings
    assert code == "usd-composition"
    assert not any(inside in message for inside in ("\n", "instantiating", "0x", "session"))


@pytest.mark.parametrize(
    ("meta", "said"),
    [
        (
            "",
            "no metersPerUnit and upAxis, so USD takes 0.01 m a unit and Y up; author .* metersPerUnit = 1, upAxis = ",
        ),
        ("metersPerUnit = 0.01", 'no upAxis, so USD takes Y up; author .* such as upAxis = "Z"'),
        ('upAxis = "Y"', "no metersPerUnit, so USD takes 0.01 m a unit; author .* such as metersPerUnit = 1"),
        ('metersPerUnit = 0.01\n upAxis = "Y"', ""),
    ],
)
def test_units_that_the_scene_does_not_author_are_reported_once(tmp_path, meta, said):
    file = tmp_path / "a.usda"
    file.write_text(f"#usda 1.0\n({meta}\n)\n{CUBE}")
    _, warnings = opened(file)
    assert [(code, where) for code, where, _ in warnings] == ([("units-assumed", str(file))] if said else [])
    assert all(re.search(said, message) for _, _, message in warnings)


def test_layers_without_anything_that_has_a_place_need_no_units(tmp_path):
    file = tmp_path / "a.usda"
    file.write_text('#usda 1.0\ndef OmniGraph "G"\n{\n}\n')
    assert opened(file) == ((), [])
    assert opened(None)[1] == []


def test_an_op_that_usd_does_not_know_is_left_out(tmp_path):
    order = 'uniform token[] xformOpOrder = ["xformOp:nothing", "xformOp:translate"]'
    parts, warnings = opened(
        scene(tmp_path, f'def Cube "A"\n{{\n {order}\n double3 xformOp:translate = (5, 0, 0)\n}}\n')
    )
    assert parts[0].vertices[:, 0].min() == 4
    assert [(code, where) for code, where, _ in warnings] == [("bad-transform-op", "/A")]


@pytest.mark.parametrize(
    ("turn", "said"),
    [("(2, 0, 0, 2)", "has the length 2.82843"), ("(0, 0, 0, 0)", "no rotation"), ("(nan, 0, 0, 0)", "no rotation")],
)
def test_a_quaternion_that_is_not_of_length_1_is_normalised_or_counts_as_no_turn(tmp_path, turn, said):
    """A quarter turn about z puts the corner (1, 1) of the box at (-1, 1), which was at (5, 0, 0) + (1, 0)."""
    order = 'uniform token[] xformOpOrder = ["xformOp:orient", "xformOp:translate"]'
    ops = f"quatd xformOp:orient = {turn}\n double3 xformOp:translate = (5, 0, 0)"
    parts, warnings = opened(scene(tmp_path, f'def Cube "A"\n{{\n {order}\n {ops}\n}}\n'))
    middle = (parts[0].vertices.min(axis=0) + parts[0].vertices.max(axis=0)) / 2
    assert middle == pytest.approx([0, 5, 0] if "length" in said else [5, 0, 0], abs=1e-6)
    [(code, where, text)] = warnings
    assert (code, where) == ("orient-not-unit", "/A")
    assert said in text


@pytest.mark.parametrize("playing", [False, True])
@pytest.mark.parametrize(("turn", "middle"), [((2, 0, 0, 2), (0, 5, 0)), ((float("nan"), 0, 0, 1), (5, 0, 0))])
def test_a_quaternion_that_is_set_later_is_normalised_too(playing, turn, middle):
    """A quarter turn about z of what stands at (5, 0, 0) below the prim."""
    with App() as app:
        app.add_prims({"/A": {"orient": [1, 0, 0, 0]}, "/A/Box": {"type": "Cube", "translate": [5, 0, 0]}})
        if playing:
            app.play()
            app.update()
        app.stage.GetAttributeAtPath("/A.xformOp:orient").Set(Gf.Quatd(*turn))
        app.update()
        assert app.fabric.world_matrix("/A/Box")[:3, 3] == pytest.approx(middle, abs=1e-12)
        assert [(one.code, one.where) for one in app.warnings] == [("orient-not-unit", "/A")]


def test_a_quaternion_of_a_referenced_file_is_normalised_whenever_the_reference_is_made(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    order = 'uniform token[] xformOpOrder = ["xformOp:orient"]'
    scene(tmp_path, f'def Xform "A"\n{{\n {order}\n quatd xformOp:orient = (2, 0, 0, 2)\n}}\n', 'defaultPrim = "A"')
    with App() as app:
        app.add_prims({"/B": {"reference": "a.usda"}})
        app.stage.DefinePrim("/C").GetReferences().AddReference(str(tmp_path / "a.usda"))
        app.play()
        for path in ("/B", "/C"):
            assert app.fabric.world_matrix(path)[:3, 0] == pytest.approx([0, 1, 0], abs=1e-12)
        assert [(one.code, one.where) for one in app.warnings] == [("orient-not-unit", "/B"), ("orient-not-unit", "/C")]


def test_a_quaternion_of_half_precision_is_left_alone(tmp_path):
    """0.7071 as half is 0.70703, so that the length is 0.9999."""
    order = 'uniform token[] xformOpOrder = ["xformOp:orient"]'
    ops = "quath xformOp:orient = (0.7071, 0, 0, 0.7071)"
    assert opened(scene(tmp_path, f'def Cube "A"\n{{\n {order}\n {ops}\n}}\n'))[1] == []


def matrix(rows):
    return f'uniform token[] xformOpOrder = ["xformOp:transform"]\n matrix4d xformOp:transform = ({rows})'


@pytest.mark.parametrize(
    ("rows", "code"),
    [
        ("(1,0,0,0), (0,0,0,0), (0,0,1,0), (0,0,0,1)", "bad-transform"),
        ("(nan,0,0,0), (0,1,0,0), (0,0,1,0), (0,0,0,1)", "bad-transform"),
        ("(1,0,0,0), (0,1,0,0), (0,0,1,0), (5,0,0,2)", "bad-transform"),
        ("(1,0,0,0), (0,1,0,0), (0,0,1,0), (1e300,0,0,1)", "bad-geometry"),
        ("(1e12,0,0,0), (0,1e12,0,0), (0,0,1e12,0), (0,0,0,1)", "odd-scale"),
        ("(1e-12,0,0,0), (0,1e-12,0,0), (0,0,1e-12,0), (0,0,0,1)", "odd-scale"),
        ("(1,0,0,0), (1,1,0,0), (0,0,1,0), (0,0,0,1)", None),
        ("(-1,0,0,0), (0,1,0,0), (0,0,1,0), (0,0,0,1)", None),
    ],
)
def test_odd_matrices_are_named_once(tmp_path, rows, code):
    parts, warnings = opened(scene(tmp_path, f'def Cube "A"\n{{\n {matrix(rows)}\n}}\n'))
    assert [warning[:2] for warning in warnings] == ([(code, "/A")] if code else [])
    assert len(parts) == (1 if code in (None, "odd-scale") else 0)


def test_the_same_fault_of_many_prims_is_one_line():
    stage = open_stage()
    for number in range(6):
        UsdGeom.Mesh.Define(stage, f"/M{number}")
    warnings = []
    collect_geometry(stage, 1e-3, lambda *warning: warnings.append(warning))
    ((code, where, message),) = warnings
    assert (code, where) == ("bad-geometry", "/M0")
    assert message.endswith("; the same holds for /M1, /M2, /M3 and 2 more")


def test_values_of_another_type_are_not_traceback(tmp_path):
    body = 'def Mesh "M"\n{\n float points = 3\n string faceVertexCounts = "a"\n}\n'
    parts, warnings = opened(scene(tmp_path, body))
    assert parts == ()
    assert [warning[:2] for warning in warnings] == [("bad-geometry", "/M")]


def test_a_path_where_a_value_belongs_is_left_out_with_a_line_and_the_file_stays(tmp_path):
    text = 'def Cube "Box"\n{\n double size = </World>\n rel other = </World>\n custom string note = "= </World>"\n}\n'
    file = scene(tmp_path, text)
    before = file.read_bytes()
    parts, warnings = opened(file)
    assert [len(part.triangles) for part in parts] == [12]  # a cube of the schema's size
    assert warnings == [
        ("path-as-value", f"{file}: /Box.size", "its value is the path </World>, not of type double; it is left out")
    ]
    assert file.read_bytes() == before


def test_metadata_of_another_type_are_named(tmp_path):
    (tmp_path / "a.usda").write_text("#usda 1.0\n(\n upAxis = </World>\n)\n")
    with pytest.raises(UserError, match=r"a\.usda: its upAxis cannot be Sdf\.Path\('/World'\); correct its metadata"):
        open_stage(tmp_path / "a.usda")


@pytest.mark.parametrize(
    ("kind", "size", "top"),
    [
        ("Capsule", "double height = 2\n double radius = 0.5", 1.5),
        ("Cylinder", "double height = 4", 2),
        ("Plane", "", 0),
    ],
)
def test_an_invalid_axis_plays_as_z(tmp_path, kind, size, top):
    """A ball of radius 1 from above rests on the top: 1 + half the height, plus the radius of the capsule's cap."""
    body = f'def {kind} "Thing" (prepend apiSchemas = ["PhysicsCollisionAPI"])\n{{\n token axis = "Q"\n {size}\n}}\n'
    body += 'def Sphere "Ball" (prepend apiSchemas = ["PhysicsCollisionAPI", "PhysicsRigidBodyAPI"])\n{\n'
    body += ' double3 xformOp:translate = (0, 0, 3)\n uniform token[] xformOpOrder = ["xformOp:translate"]\n}\n'
    with App(stage=scene(tmp_path, body)) as app:
        (thing,) = (part for part in app.geometry() if part.path == "/Thing")
        if kind == "Plane":
            assert thing.normal.tolist() == [0, 0, 1]
        else:
            assert thing.vertices[:, 2].max() == pytest.approx(top)
        app.play()
        app.update(60)
        assert app.fabric.world_matrix("/Ball")[2, 3] == pytest.approx(top + 1, abs=0.02)


def test_a_body_that_is_nowhere_is_refused(tmp_path):
    body = 'def Sphere "Ball" (prepend apiSchemas = ["PhysicsCollisionAPI", "PhysicsRigidBodyAPI"])\n{\n'
    body += ' double3 xformOp:translate = (nan, 0, 0)\n uniform token[] xformOpOrder = ["xformOp:translate"]\n}\n'
    with (
        App(stage=scene(tmp_path, body)) as app,
        pytest.raises(UserError, match="/Ball: the body's transform is not finite; correct its xformOps"),
    ):
        app.play()


def test_a_collider_that_is_nowhere_is_left_out(tmp_path):
    body = 'def Sphere "Ball" (prepend apiSchemas = ["PhysicsCollisionAPI", "PhysicsRigidBodyAPI"])\n{\n'
    body += ' def Cube "Cap" (prepend apiSchemas = ["PhysicsCollisionAPI"])\n {\n'
    body += '  double3 xformOp:translate = (nan, 0, 0)\n  uniform token[] xformOpOrder = ["xformOp:translate"]\n }\n}\n'
    with App(stage=scene(tmp_path, body)) as app:
        app.play()
        app.update()
        said = {(warning.code, warning.where) for warning in app.warnings}
    assert ("bad-transform", "/Ball/Cap") in said


def test_unicode_names_and_empty_stages_work(tmp_path):
    parts, warnings = opened(scene(tmp_path, 'def Cube "W\u00fcrfel_\u7bb1"\n{\n}\n'))
    assert [part.path for part in parts] == ["/W\u00fcrfel_\u7bb1"]
    assert warnings == []
    assert opened(scene(tmp_path, "", name="b.usda")) == ((), [])


def test_samples_that_are_not_finite_hold_the_last_place(tmp_path):
    samples = "{ 0: (5, 0, 0), 6: (6, 0, 0), 12: (nan, 0, 0), 13: (nan, 0, 0) }"
    order = 'uniform token[] xformOpOrder = ["xformOp:translate"]'
    body = f'def Cube "A"\n{{\n {order}\n double3 xformOp:translate.timeSamples = {samples}\n}}\n'
    with App(scene(tmp_path, body, "timeCodesPerSecond = 24")) as app:
        app.play()
        app.update(steps=15)
        assert app.fabric.world_matrix("/A")[0, 3] == pytest.approx(6)
        app.update(steps=20)
        assert app.fabric.world_matrix("/A")[0, 3] == pytest.approx(6)
        assert app.warnings.codes() == ["bad-transform"]


PART = '#usda 1.0\n(\n defaultPrim = "Part"\n metersPerUnit = 0.01\n upAxis = "Y"\n)\ndef Cube "Part" {}\n'
WHOLE = """#usda 1.0
(
    metersPerUnit = 1
    upAxis = "Z"
)
def Xform "A" (references = @part.usda@) {}
def Xform "B" (payload = @part.usda@) {}
def Xform "Scaled" (references = @part.usda@)
{
    float3 xformOp:scale = (0.01, 0.01, 0.01)
    uniform token[] xformOpOrder = ["xformOp:scale"]
}
def Xform "Right" (references = @part.usda@)
{
    float xformOp:rotateX = 90
    float3 xformOp:scale = (0.01, 0.01, 0.01)
    uniform token[] xformOpOrder = ["xformOp:rotateX", "xformOp:scale"]
}
def Xform "Resolved" (references = @part.usda@)
{
    float3 xformOp:scale:unitsResolve = (0.01, 0.01, 0.01)
    uniform token[] xformOpOrder = ["xformOp:scale:unitsResolve"]
}
"""


def test_references_in_other_units_are_reported_once_a_file_where_nothing_makes_up_for_it(tmp_path):
    (tmp_path / "part.usda").write_text(PART)
    (tmp_path / "same.usda").write_text(PART.replace("0.01", "1").replace('"Y"', '"Z"'))
    file = tmp_path / "a.usda"
    file.write_text(WHOLE + 'def "Same" (references = @same.usda@) {}\n')
    _, warnings = opened(file)
    [(code, where, message)] = warnings
    assert (code, where) == ("units-mismatch", "/A")
    assert message == (
        "it refers to part.usda, which USD does not convert: its unit is 0.01 m, that of the stage 1 m, so scale the "
        "prim by 0.01; its up axis is Y, that of the stage Z, so turn the prim by 90 deg about X; the same holds for "
        "/B, /Scaled"
    )
