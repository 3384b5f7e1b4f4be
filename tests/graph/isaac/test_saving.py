"""`Save` of the stage that a script opened writes its file, as in Kit; nothing else reaches it."""

import pytest

from tests.support.without_wing import needs_wing

PART = '#usda 1.0\n(\n    defaultPrim = "Part"\n)\ndef Cube "Part"\n{\n}\n'
SCENE = """#usda 1.0
(
    metersPerUnit = 1
    upAxis = "Z"
)
def Xform "World"
{
    def "Part" (
        prepend references = @./part.usda@
    )
    {
    }
}
"""
OPENED = """
import omni.usd
from pxr import Usd, UsdGeom
context = omni.usd.get_context()
assert context.open_stage("scene.usda")
stage = context.get_stage()
UsdGeom.Sphere.Define(stage, "/World/Ball")
"""


@pytest.fixture
def saved(run_script, tmp_path, monkeypatch):
    """The text of the opened file after a script."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "part.usda").write_text(PART)
    (tmp_path / "scene.usda").write_text(SCENE)

    def run(lines):
        code, _, err = run_script(OPENED + lines)
        assert code == 0, err
        return (tmp_path / "scene.usda").read_text()

    return run


@pytest.mark.parametrize(
    "call",
    ["stage.GetRootLayer().Save()", "stage.Save()", "stage.GetEditTarget().GetLayer().Save()", "context.save_stage()"],
)
def test_saving_an_opened_stage_writes_its_file_with_its_references(saved, call):
    text = saved(f"stage.SetDefaultPrim(stage.GetPrimAtPath('/World'))\n{call}\n")
    assert 'def Sphere "Ball"' in text
    assert "references = @./part.usda@" in text
    assert 'defaultPrim = "World"' in text
    assert "def Cube" not in text
    assert "OmniverseKit_Persp" not in text


def test_a_stage_that_is_not_saved_leaves_its_file_as_it_was(saved):
    assert saved("") == SCENE


@needs_wing("stand_ins")
def test_a_stage_with_a_stand_in_is_saved_whole_because_no_file_holds_it(saved):
    text = saved("""from isaacsim.core.experimental.utils.stage import add_reference_to_stage
add_reference_to_stage("omniverse://host/Isaac/Environments/Simple_Room/simple_room.usd", "/World/Room")
stage.Save()
""")
    assert "anon:" not in text
    assert 'def Xform "Room"' in text
    assert "def Cube" in text


def test_other_layers_save_as_ever_and_a_new_stage_has_no_file(run_script, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "scene.usda").write_text(SCENE)
    (tmp_path / "part.usda").write_text(PART)
    code, _, err = run_script(
        OPENED
        + """other = Usd.Stage.CreateNew("other.usda")
other.DefinePrim("/Own", "Xform")
other.GetRootLayer().Save()
assert "Own" in open("other.usda").read()
context.new_stage()
context.get_stage().GetRootLayer().Save()
"""
    )
    assert code == 1
    assert ":13: " in err
    assert "Cannot save anonymous layer" in err


def test_after_the_script_usd_saves_by_itself_again(saved):
    from pxr import Sdf, Usd

    before = Sdf.Layer.Save, Usd.Stage.Save
    saved("stage.Save()\n")
    assert (Sdf.Layer.Save, Usd.Stage.Save) == before


def test_an_opened_stage_takes_metadata_and_lets_its_prims_go(saved):
    """World sets the up axis; a prim of the file itself is removed, and its sublayers stay."""
    text = saved("""from isaacsim.core.api import World
World(stage_units_in_meters=1.0)
UsdGeom.SetStageMetersPerUnit(stage, 0.01)
assert stage.RemovePrim("/World/Part") and not stage.GetPrimAtPath("/World/Part")
stage.Save()
""")
    assert "metersPerUnit = 0.01" in text
    assert "part.usda" not in text
