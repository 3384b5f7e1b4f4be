"""Non-visual materials: the number, and the channel that carries it."""

import pytest
from pxr import Sdf, UsdGeom, UsdShade

from graph.sim import App
from graph.sim.scene.nonvisual import ATTRIBUTES, BASES, COATINGS
from sensors import Lidar, bind_material
from sensors.products import render_product
from sensors.surfaces.material_codes import decode, encode, material_of


def test_the_documented_example_is_2305():
    assert encode("aluminum", "paint", "emissive") == 2305
    assert decode(2305) == ("aluminum", "paint", ("emissive",))


def test_every_name_survives_the_round_trip():
    assert (BASES.index("calibration_lambertion"), BASES.index("clear_glass"), BASES.index("asphalt")) == (47, 19, 24)
    for base in BASES:
        for coating in COATINGS:
            for attribute in ATTRIBUTES:
                assert decode(encode(base, coating, attribute)) == (base, coating, (attribute,))


def test_attributes_combine():
    assert encode("none", "none", "retroreflective, single_sided") == 6 << 11
    assert encode(attributes=["emissive", "visually_transparent"]) == 9 << 11


@pytest.mark.parametrize("names", [("gold",), ("steel", "varnish"), ("steel", "paint", "shiny")])
def test_unknown_names_are_0(names):
    assert encode(*names) == 0


def test_unknown_parts_decode_to_none_and_big_numbers_are_refused():
    assert decode(255 | 7 << 8) == ("none", "none", ("none",))
    with pytest.raises(ValueError, match="16 bits"):
        decode(65536)


def test_points_carry_the_material_of_what_they_hit():
    with App(None) as app:
        stage = app.stage
        steel = UsdShade.Material.Define(stage, "/World/Looks/Steel")
        steel.GetPrim().CreateAttribute("omni:simready:nonvisual:base", Sdf.ValueTypeNames.String).Set("steel")
        wall = UsdGeom.Cube.Define(stage, "/World/Wall")
        UsdGeom.XformCommonAPI(wall).SetTranslate((5, 0, 0))
        UsdShade.MaterialBindingAPI.Apply(wall.GetPrim()).Bind(steel)
        UsdGeom.XformCommonAPI(UsdGeom.Cube.Define(stage, "/World/Plain")).SetTranslate((-5, 0, 0))
        lidar = Lidar.create("/World/Lidar", config="RPLIDAR_S2E", aux_output_level="EXTRA")
        product = render_product(app, lidar.path)
        product.sensor.require("test", {"matId", "xyz"})

        app.play()
        app.update(steps=6)

        ahead = product.frame.xyz[:, 0] > 0
        assert set(product.frame.channel("matId")[ahead].tolist()) == {2}
        assert set(product.frame.channel("matId")[~ahead].tolist()) == {0}
        assert material_of(stage, None) == material_of(stage, "/World/Nothing") == 0


def test_a_material_can_be_bound_by_its_name_or_its_parts():
    with App(None) as app:
        wall = UsdGeom.Cube.Define(app.stage, "/World/Wall")
        UsdGeom.XformCommonAPI(wall).SetTranslate((5, 0, 0))
        lidar = Lidar.create("/World/Lidar", config="RPLIDAR_S2E", aux_output_level="EXTRA", app=app)
        product = render_product(app, lidar.path)
        product.sensor.require("test", {"matId"})
        paint = {"base": "aluminum", "coating": "paint", "attributes": "emissive"}
        for material, number in (("steel", 2), (paint, 2305)):  # 1 + 1 * 256 + 1 * 2048
            bind_material("/World/Wall", material, app=app)
            app.play()
            app.update(steps=6)
            assert set(product.frame.channel("matId").tolist()) == {number}
            app.stop()

        with pytest.raises(ValueError, match="there is no material base 'stel'; did you mean \"steel\""):
            bind_material("/World/Wall", "stel", app=app)
        with pytest.raises(ValueError, match='there is no prim /World/Wal; did you mean "/World/Wall"'):
            bind_material("/World/Wal", "steel", app=app)
