from fractions import Fraction

import pytest

from graph.base.errors import UserError
from graph.sim.scene.stage import StageState, open_stage
from graph.sim.scene.stage_metadata import meters_per_unit, physics_scene_rate, up_axis
from graph.sim.usd import Sdf, UsdGeom


def write(path, text):
    path.write_text("#usda 1.0\n" + text)
    return path


def contents(stage):
    return {layer.identifier: layer.ExportToString() for layer in stage.GetUsedLayers()}


def test_an_empty_stage_is_in_metres_and_z_up():
    stage = open_stage()
    assert (meters_per_unit(stage), up_axis(stage)) == (1.0, "Z")


def test_units_up_axis_and_default_prim_are_those_of_the_scene(tmp_path):
    header = (
        '(\n metersPerUnit = 0.01\n upAxis = "Y"\n defaultPrim = "W"\n timeCodesPerSecond = 24\n)\ndef Xform "W" {}\n'
    )
    stage = open_stage(write(tmp_path / "a.usda", header))
    assert (meters_per_unit(stage), up_axis(stage)) == (0.01, "Y")
    assert stage.GetDefaultPrim().GetName() == "W"
    assert stage.GetTimeCodesPerSecond() == 24


def test_a_unit_of_nothing_is_refused(tmp_path):
    with pytest.raises(UserError, match="metersPerUnit is 0; it must be greater than 0"):
        open_stage(write(tmp_path / "a.usda", "(\n metersPerUnit = 0\n)\n"))


def test_the_rate_of_the_physics_scene_is_read_exactly(tmp_path):
    for name in ("physxScene", "newton"):
        text = f'def PhysicsScene "S" {{\n uint {name}:timeStepsPerSecond = 240\n}}\n'
        assert physics_scene_rate(open_stage(write(tmp_path / f"{name}.usda", text))) == Fraction(240)
    assert physics_scene_rate(open_stage()) is None


def test_the_rate_of_an_inline_physics_scene_is_read(tmp_path):
    from graph.sim import App

    for name in ("physxScene", "newton"):
        prim = f'{{type: PhysicsScene, attributes: {{"{name}:timeStepsPerSecond": 240}}}}'
        write(tmp_path / f"{name}.yaml", f"tickgraph: 1\nscene: {{prims: {{/Scene: {prim}}}}}\n")
        with App.from_file(tmp_path / f"{name}.yaml") as app:
            assert app.simulation.get_physics_dt() == 1 / 240


def test_what_is_authored_on_one_stage_reaches_neither_the_file_nor_another_stage(tmp_path):
    file = write(tmp_path / "a.usda", 'def Xform "W" {}\n')
    before = file.read_bytes()
    first, second = open_stage(file), open_stage(file)
    first.DefinePrim("/W/New", "Cube")
    first.SetTimeCodesPerSecond(30)
    assert not second.GetPrimAtPath("/W/New")
    assert second.GetTimeCodesPerSecond() != 30
    assert file.read_bytes() == before


def test_restoring_gives_every_layer_its_bytes_back(tmp_path):
    write(tmp_path / "b.usda", '(\n defaultPrim = "B"\n)\ndef Cube "B" {}\n')
    file = write(tmp_path / "a.usda", 'def Xform "W" (references = @./b.usda@) {}\n')
    stage = open_stage(file)
    UsdGeom.Sphere.Define(stage, "/Before")
    state, before = StageState(stage), contents(stage)
    UsdGeom.Sphere(stage.GetPrimAtPath("/Before")).GetRadiusAttr().Set(7.0)
    UsdGeom.Cube(stage.GetPrimAtPath("/W")).AddTranslateOp().Set((1, 2, 3))
    stage.SetEditTarget(stage.GetSessionLayer())
    stage.DefinePrim("/Render/Product", "Scope")
    Sdf.CreatePrimInLayer(Sdf.Layer.Find(str(tmp_path / "b.usda")), "/Extra")
    stage.RemovePrim("/Before")
    assert contents(stage) != before
    state.restore()
    assert contents(stage) == before
    assert stage.GetEditTarget().GetLayer() == stage.GetRootLayer()
    state.restore()
    assert contents(stage) == before
