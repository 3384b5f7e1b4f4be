"""Models of strangers: only files below the folders allowed, of bounded size, each mistake one line with its place."""

from __future__ import annotations

import struct

import pytest

from graph.base.errors import UserError
from tests.support.mjcf_robots import TETRAHEDRON
from wings.mjcf.scene import open_mjcf

MESH = "<asset><mesh name='m' file='{}'/></asset><worldbody><geom type='mesh' mesh='m'/></worldbody>"


def problems(file, **options):
    with pytest.raises(UserError) as raised:
        open_mjcf(file, **options)
    return str(raised.value).splitlines()


def test_nested_includes_are_looked_for_below_the_main_file_and_then_beside_the_including_one(model, tmp_path):
    (tmp_path / "deep").mkdir()
    (tmp_path / "deep" / "a.xml").write_text("<mujoco><include file='b.xml'/><include file='c.xml'/></mujoco>")
    (tmp_path / "deep" / "b.xml").write_text("<x><worldbody><geom name='deep' size='1'/></worldbody></x>")
    (tmp_path / "b.xml").write_text("<x><worldbody><geom name='main' size='1'/></worldbody></x>")
    (tmp_path / "deep" / "c.xml").write_text("<x><worldbody><geom name='beside' size='1'/></worldbody></x>")
    scene = open_mjcf(model("<include file='deep/a.xml'/>"))
    assert scene.paths.geoms == ("/World/main", "/World/beside")


def test_a_file_that_includes_itself_is_reported(model, tmp_path):
    (tmp_path / "a.xml").write_text("<x>\n  <include file='a.xml'/>\n</x>")
    (line,) = problems(model("<include file='a.xml'/>"))
    assert line.endswith("a.xml:2:3: include: a.xml is included already; a file may be so once")


@pytest.mark.parametrize("way", ["../out.obj", "/etc/hostname", "link.obj", "sub/../../out.obj"])
def test_files_outside_the_folder_are_refused_before_anything_opens_them(model, tmp_path, way):
    inner = tmp_path / "inner"
    inner.mkdir()
    (tmp_path / "out.obj").write_text(TETRAHEDRON)
    (inner / "link.obj").symlink_to(tmp_path / "out.obj")
    (inner / "sub").mkdir()
    file = inner / "model.xml"
    file.write_text("<mujoco>\n " + MESH.format(way) + "</mujoco>")
    (line,) = problems(file)
    assert line.endswith(
        f"model.xml:2:9: mesh m: {way} lies outside the model's folders; move it there, or allow its folder with "
        "--allow"
    )


@pytest.mark.parametrize(
    "text",
    [
        "<include file='../out.xml'/>",
        "<asset><texture name='t' type='2d' file='../out.png'/></asset>",
        "<asset><texture name='t' type='cube' fileright='../out.png'/></asset>",
        "<asset><hfield name='h' file='../out.png' size='1 1 1 1'/></asset>",
        "<asset><model name='m' file='../out.xml'/></asset>",
        "<deformable><skin file='../out.skn'/></deformable>",
        "<worldbody><body><flexcomp name='f' type='mesh' file='../out.obj'/></body></worldbody>",
        "<compiler meshdir='..'/><asset><mesh file='out.obj'/></asset>",
        "<compiler assetdir='..'/><asset><mesh file='out.obj'/></asset>",
        "<compiler texturedir='/etc'/><asset><texture name='t' type='2d' file='hostname'/></asset>",
        "<asset><mesh file='..\\\\out.obj'/></asset>",
    ],
)
def test_every_attribute_that_names_a_file_is_watched(tmp_path, text):
    inner = tmp_path / "inner"
    inner.mkdir()
    for name in ("out.xml", "out.png", "out.skn", "out.obj"):
        (tmp_path / name).write_text("<mujoco/>")
    (inner / "model.xml").write_text(f"<mujoco>{text}</mujoco>")
    (line,) = problems(inner / "model.xml")
    assert "lies outside the model's folders" in line


def test_an_allowed_folder_is_read(tmp_path):
    inner = tmp_path / "inner"
    inner.mkdir()
    (tmp_path / "out.obj").write_text(TETRAHEDRON)
    (inner / "model.xml").write_text("<mujoco>" + MESH.format("../out.obj") + "</mujoco>")
    assert open_mjcf(inner / "model.xml", [inner, tmp_path]).model.nmesh == 1


def test_each_missing_file_is_named_with_its_element(model):
    texture = "<texture name='t' type='2d' file='t.png'/>"
    text = f"<compiler meshdir='assets'/>\n<asset>\n<mesh file='a.stl'/>\n{texture}</asset>"
    first, second = problems(model(text))
    assert "model.xml:4:1: mesh: a.stl: there is no such file (looked for " in first
    assert first.endswith("assets/a.stl)")
    assert "model.xml:5:1: texture t: t.png: there is no such file" in second


def test_strippath_takes_the_path_from_file_names(model, tmp_path):
    (tmp_path / "t.obj").write_text(TETRAHEDRON)
    file = model("<compiler strippath='true'/>" + MESH.format("C:/somebody/t.obj"))
    assert open_mjcf(file).model.nmesh == 1


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("<worldbody>\n  <geom typ='box'/></worldbody>", "3:3: geom: unrecognized attribute: 'typ'"),
        ("<worldbody>\n  <geom type='bo'/></worldbody>", "3:3: geom: invalid keyword: 'bo'"),
        ("<worldbody>\n\n  <body><joint/></body></worldbody>", "4:3: "),
        ("<worldbody>\n <geom size='1 x'/></worldbody>", "3:2: geom: bad format in attribute 'size'"),
        ("<composite/>", "2:1: composite: unrecognized element"),
        ("<actuator>\n<motor joint='q'/></actuator>", "3:1: "),
        ("<worldbody>\n<body>", "4:3: this is not XML: mismatched tag"),
    ],
)
def test_what_mujoco_refuses_is_one_line_with_its_place(model, text, line):
    (told,) = problems(model(text))
    assert f"model.xml:{line}" in told
    assert "\n" not in told


def test_a_mistake_in_an_included_file_is_reported_there(model, tmp_path):
    (tmp_path / "part.xml").write_text("<x>\n<worldbody>\n  <geom typ='box'/>\n</worldbody></x>")
    (line,) = problems(model("<option/>\n<include file='part.xml'/>"))
    assert line.endswith("part.xml:3:3: geom: unrecognized attribute: 'typ'")


def test_a_mistake_in_an_attached_model_is_reported_there(model, tmp_path):
    (tmp_path / "arm.xml").write_text(
        "<mujoco model='arm'>\n<worldbody>\n<body name='b'>\n<geom typ='box'/></body></worldbody></mujoco>"
    )
    attached = "<worldbody><attach model='arm' body='b' prefix='l/'/></worldbody>"
    text = f"<asset><model name='arm' file='arm.xml'/></asset>{attached}"
    (line,) = problems(model(text))
    assert "arm.xml:4:1: " in line


def test_a_urdf_and_other_files_are_distinguished(model):
    assert problems(model("<mujoco/>").with_name("none.xml")) == [
        f"{model('<mujoco/>').with_name('none.xml')}: no such MJCF file"
    ]
    file = model("<mujoco/>")
    file.write_text("<robot name='r'/>")
    assert "the root element is <robot>; this is a URDF; name it as scene: {urdf: model.xml}" in problems(file)[0]


@pytest.mark.parametrize(
    "text",
    [
        "<!DOCTYPE mujoco [<!ENTITY a 'aaaa'><!ENTITY b '&a;&a;&a;'>]><mujoco model='&b;'/>",
        "<!DOCTYPE mujoco SYSTEM 'file:///etc/passwd'><mujoco/>",
    ],
)
def test_entities_are_refused(model, text):
    file = model("<mujoco/>")
    file.write_text(text)
    assert "a model has no DOCTYPE and declares no entities; remove it" in problems(file)[0]


@pytest.mark.parametrize(
    "text",
    [
        "<worldbody>" + "<replicate count='100'>" * 4 + "<geom size='1'/>" + "</replicate>" * 4 + "</worldbody>",
        "<worldbody><body><flexcomp name='f' type='grid' count='1000 1000 1000' spacing='1 1 1'/></body></worldbody>",
        "<asset><texture name='t' type='2d' builtin='flat' width='1000000' height='1000000'/></asset>",
        "<asset><hfield name='h' nrow='100000' ncol='100000' size='1 1 1 1'/></asset>",
        "<size memory='1T'/>",
        "<size nuserdata='1e12'/>",
        "<custom><numeric name='n' size='1000000000' data='0'/></custom>",
        "<worldbody>" + "<body>" * 400 + "</body>" * 400 + "</worldbody>",
        "<worldbody><replicate count='1e400'><geom size='1'/></replicate></worldbody>",
    ],
)
def test_a_few_bytes_cannot_ask_for_all_the_memory(model, text):
    (line,) = problems(model(text))
    assert "above" in line or "deeper" in line


def test_attaching_models_that_attach_models_is_counted(model, tmp_path):
    for level in range(20):
        below = f"<asset><model name='n' file='m{level + 1}.xml'/></asset>" if level < 19 else ""
        twice = (
            "".join(f"<attach model='n' body='b' prefix='{side}'/>" for side in "xy")
            if level < 19
            else "<geom size='1'/>"
        )
        (tmp_path / f"m{level}.xml").write_text(
            f"<mujoco>{below}<worldbody><body name='b'>{twice}</body></worldbody></mujoco>"
        )
    assert "elements of it, above" in problems(tmp_path / "m0.xml")[0]


def test_a_model_that_attaches_itself_is_reported(tmp_path):
    (tmp_path / "m.xml").write_text("<mujoco><asset><model name='m' file='m.xml'/></asset></mujoco>")
    assert "m.xml attaches itself" in problems(tmp_path / "m.xml")[0]


def test_the_size_that_a_png_says_it_has_is_looked_at_first(model, tmp_path):
    head = b"\x89PNG\r\n\x1a\n" + struct.pack(">I", 13) + b"IHDR" + struct.pack(">II", 60000, 60000) + b"\x08\0\0\0\0"
    (tmp_path / "big.png").write_bytes(head)
    file = model("<asset><hfield name='h' file='big.png' size='1 1 1 1'/></asset>")
    assert "big.png has 60000 by 60000 pixels" in problems(file)[0]


@pytest.mark.parametrize("data", [b"", b"\0" * 100, b"\xff\xfe<\0m\0", b"v 0 0 0\nf 9 9 9\n", b"solid x"])
def test_broken_meshes_are_one_line(model, tmp_path, data):
    for suffix in ("obj", "stl", "msh"):
        (tmp_path / f"broken.{suffix}").write_bytes(data)
        assert len(problems(model(MESH.format(f"broken.{suffix}")))) == 1


def test_comments_with_dashes_and_latin_bytes_pass(model, tmp_path):
    file = model("<mujoco/>")
    file.write_bytes(
        b"\xef\xbb\xbf\n<?xml version='1.0'?>\n<mujoco model='caf\xe9'><!-- ---- & < ---- -->\n<worldbody/></mujoco>"
    )
    assert open_mjcf(file).model.nbody == 1


def test_submodels_keep_their_own_mesh_folders(model, tmp_path):
    (tmp_path / "left").mkdir()
    (tmp_path / "left" / "meshes").mkdir()
    (tmp_path / "left" / "meshes" / "t.obj").write_text(TETRAHEDRON)
    (tmp_path / "t.obj").write_text(TETRAHEDRON.replace("v 1", "v 3"))
    arm = "<mujoco model='arm'><compiler meshdir='meshes'/>" + MESH.format("t.obj").replace(
        "<geom", "<body name='b'><geom"
    )
    (tmp_path / "left" / "arm.xml").write_text(arm.replace("</worldbody>", "</body></worldbody></mujoco>"))
    text = "<asset><model name='arm' file='left/arm.xml'/><mesh name='own' file='t.obj'/></asset>"
    scene = open_mjcf(model(text + "<worldbody><attach model='arm' body='b' prefix='l/'/></worldbody>"))
    assert scene.paths.bodies == ("", "/World/l_b")
    assert scene.stage.GetPrimAtPath("/World/l_b").GetAttribute("isaac:nameOverride").Get() == "l/b"


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("<option timestep='0'/>", "option timestep is 0; it must be above 0"),
        ("<option timestep='-0.1'/>", "option timestep is -0.1; it must be above 0"),
        ("<option timestep='1e-308'/>", "option timestep is 1e-308; the shortest is 1e-09 s"),
        ("<option timestep='nan'/>", "option timestep is nan; it must be above 0"),
        (
            "<worldbody><body name='b' pos='nan 0 0'><freejoint/><geom size='1'/></body></worldbody>",
            "the place of body b is not finite; correct it",
        ),
        (
            "<worldbody><geom name='g' size='1' pos='inf 0 0'/></worldbody>",
            "the place of geom g is not finite; correct it",
        ),
    ],
)
def test_numbers_that_mujoco_takes_but_nothing_can_be_done_with(model, text, told):
    (line,) = problems(model(text))
    assert line.endswith(told)
