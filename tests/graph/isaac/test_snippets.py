"""What the documents' Python snippets do, as scripts of their own: sensors by factories, waits, writers, utilities."""

import pytest

STANDALONE = "from isaacsim import SimulationApp\napp = SimulationApp({'headless': True, 'enable_motion_bvh': True})\n"
WALL = (
    "from isaacsim.core.experimental.objects import Cube\nCube('/World/wall', sizes=2.0, positions=[[5.0, 0.0, 0.0]])\n"
)
TIMELINE = "import omni.timeline\nomni.timeline.get_timeline_interface().play()\n"
SNIPPETS = {
    "a lidar with a tick rate, and one of a configuration": (
        "from isaacsim.sensors.experimental.rtx import Lidar\n"
        "first = Lidar('/World/lidar', tick_rate=20.0)\n"
        "second = Lidar.create('/World/other', config='Example_Rotary', tick_rate=10.0)\n"
        "print(first.prims[0].GetAttribute('omni:sensor:tickRate').Get(), second.paths)\n",
        ["20.0 ['/World/other']"],
    ),
    "auxiliary data and the buffer of a whole scan": (
        WALL + "from isaacsim.sensors.experimental.rtx import Lidar\n"
        "import omni.replicator.core as rep\n"
        "from isaacsim.core.experimental.utils import app as app_utils\n"
        "lidar = Lidar.create('/World/lidar', config='Example_Rotary', aux_output_level='FULL')\n"
        "product = rep.create.render_product(lidar.paths[0], resolution=(1, 1))\n"
        "scan = rep.AnnotatorRegistry.get_annotator('IsaacCreateRTXLidarScanBuffer')\n"
        "scan.initialize(outputObjectId=True)\n"
        "scan.attach([product.path])\n"
        "app_utils.play()\n"
        "await app_utils.update_app_async(steps=15)\n"
        "data = scan.get_data()\n"
        "print(len(data['data']) > 0, lidar.aux_output_level)\n",
        ["True FULL"],
    ),
    "a camera with a tick rate": (
        "from isaacsim.sensors.experimental.rtx import RtxCamera\n"
        "camera = RtxCamera('/World/camera', tick_rate=30.0)\n"
        "prim = camera.prims[0]\n"
        "print(prim.GetTypeName(), prim.GetAttribute('omni:sensor:tickRate').Get())\n"
        "print('OmniSensorAPI' in prim.GetAppliedSchemas())\n",
        ["Camera 30.0", "True"],
    ),
    "lenses of cameras and of their sensors": (
        "from isaacsim.sensors.experimental.rtx import CameraSensor, RtxCamera, SingleViewDepthCameraSensor\n"
        "from isaacsim.sensors.experimental.rtx import TiledCameraSensor\n"
        "made = [RtxCamera(f'/World/camera_{n}', tick_rate=30.0) for n in range(2)]\n"
        "made[0].camera.set_focal_lengths(24.0)\n"
        "made[0].camera.set_clipping_ranges(0.01, 1000.0)\n"
        "print(made[0].camera.get_focal_lengths().numpy()[0], made[0].prim.GetAttribute('focalLength').Get())\n"
        "sensors = [CameraSensor(made[0], resolution=(48, 64), annotators=['rgb'])]\n"
        "sensors += [SingleViewDepthCameraSensor(made[1], resolution=(48, 64), annotators=['distance_to_camera'])]\n"
        "tiled = TiledCameraSensor('/World/camera_.*', resolution=(8, 8), annotators=['rgb'])\n"
        "print([len(one.camera.get_focal_lengths().numpy()) for one in [*sensors, tiled]])\n"
        "from isaacsim.core.experimental.utils import app as app_utils\n"
        "app_utils.play()\n"
        "await app_utils.update_app_async(steps=3)\n"
        "print(tiled.get_data('rgb')[0].numpy().shape, tiled.get_data('rgb', tiled=True)[0].numpy().shape)\n"
        "print(sensors[1].get_data('distance_to_camera')[0].numpy().shape)\n",
        ["[24.] 240.0", "[1, 1, 2]", "(2, 8, 8, 3) (8, 16, 3)", "(48, 64, 1)"],
    ),
    "a wait for whole updates": (
        "from isaacsim.core.experimental.utils import app as app_utils\n"
        "import omni.kit.app\n"
        "before = omni.kit.app.get_app().get_update_number()\n"
        "await app_utils.update_app_async(steps=3)\n"
        "print(omni.kit.app.get_app().get_update_number() - before)\n",
        ["3"],
    ),
    "a radar and two lidars for 65 updates": (
        STANDALONE + "import omni\n" + WALL + "from isaacsim.sensors.experimental.rtx import Lidar, LidarSensor\n"
        "from isaacsim.sensors.experimental.rtx import Radar, RadarSensor, parse_generic_model_output_data\n"
        "sensors = [LidarSensor(Lidar.create(f'/World/l{n}', config='Example_Rotary'), "
        "annotators=['generic-model-output']) for n in range(2)]\n"
        "sensors.append(RadarSensor(Radar('/World/radar'), annotators=['generic-model-output']))\n"
        "import carb\n" + TIMELINE + "for _ in range(65):\n    app.update()\n"
        "for one in sensors:\n"
        "    data, info = one.get_data('generic-model-output')\n"
        "    print(parse_generic_model_output_data(data).numElements > 0)\n"
        "carb.log_warn('done')\napp.close()\n",
        ["True", "True", "True"],
    ),
    "a lidar for 100 updates of an application without options": (
        "from isaacsim import SimulationApp\napp = SimulationApp()\n" + WALL + TIMELINE + ""
        "from isaacsim.sensors.experimental.rtx import Lidar, LidarSensor\n"
        "sensor = LidarSensor(Lidar.create('/World/lidar', config='Example_Rotary'), "
        "annotators=['generic-model-output'])\n"
        "seen = 0\n"
        "for _ in range(100):\n"
        "    app.update()\n"
        "    data, info = sensor.get_data('generic-model-output')\n"
        "    if data is not None:\n"
        "        seen += 1\n"
        "print(seen > 80)\napp.close()\n",
        ["True"],
    ),
    "a point cloud drawn by a writer": (
        "import omni.kit.app\n"
        "manager = omni.kit.app.get_app().get_extension_manager()\n"
        "print(manager.set_extension_enabled_immediate('isaacsim.sensors.rtx.nodes', True))\n"
        + WALL
        + "from isaacsim.sensors.experimental.rtx import Lidar, LidarSensor\n"
        "Lidar.create('/World/lidar', config='Example_Rotary')\n"
        "sensor = LidarSensor('/World/lidar', annotators=[], writers=['draw-point-cloud'])\n" + TIMELINE,
        ["True"],
    ),
    "a radar drawn by a writer on its render product": (
        "import carb.settings\n"
        "import omni.replicator.core as rep\n"
        "carb.settings.get_settings().set('/renderer/raytracingMotion/enabled', True)\n"
        "from isaacsim.sensors.experimental.rtx import Radar\n"
        "radar = Radar('/World/radar')\n"
        "product = rep.create.render_product(radar.paths[0], resolution=(1, 1))\n"
        "writer = rep.writers.get('RtxRadarDebugDrawPointCloud')\n"
        "writer.initialize(size=0.1)\n"
        "writer.attach(product.path)\n"
        "print(radar.paths)\n",
        ["['/World/radar']"],
    ),
    "the former utilities, imported late": (
        "import omni.isaac.core.utils.stage\n"
        "from omni.isaac.core.utils.prims import get_prim_at_path, define_prim\n"
        "define_prim('/World/thing', 'Cube')\n"
        "print(get_prim_at_path('/World/thing').GetTypeName())\n"
        "import omni.isaac.core.utils.prims\n"
        "print(omni.isaac.core.utils.prims.get_prim_at_path('/World/thing').IsValid())\n",
        ["Cube", "True"],
    ),
}


@pytest.mark.parametrize("name", SNIPPETS)
def test_a_snippet_of_the_documents_runs_to_its_end(name, run_script):
    text, expected = SNIPPETS[name]
    code, out, err = run_script(text, "--updates", 200)
    assert code == 0, err
    assert out.splitlines() == expected


def test_a_wait_for_a_product_that_nobody_made_is_one_clear_line(run_script):
    code, out, err = run_script(
        "import omni.syntheticdata\n"
        "await omni.syntheticdata.sensors.next_render_simulation_async('/Render/Nobody', 1)\nprint('on')\n"
    )
    assert (code, out) == (1, "")
    (line,) = [one for one in err.splitlines() if "/Render/Nobody" in one and "script.py:2" in one]
    assert "Traceback" not in err, line


def test_what_a_lidar_and_a_radar_give_is_inspected_by_command_line(run_script):
    text = (
        "import argparse\n"
        "from isaacsim import SimulationApp\n"
        "parser = argparse.ArgumentParser()\n"
        "parser.add_argument('--aux-data-level', default='NONE')\n"
        "parser.add_argument('--test', action='store_true')\n"
        "args, _ = parser.parse_known_args()\n"
        "app = SimulationApp({'headless': True, 'enable_motion_bvh': True})\n" + WALL + ""
        "from isaacsim.sensors.experimental.rtx import Lidar, LidarSensor, parse_generic_model_output_data\n"
        "lidar = Lidar.create('/lidar', config='Example_Rotary', aux_output_level=args.aux_data_level)\n"
        "sensor = LidarSensor(lidar, annotators=['generic-model-output'])\n" + TIMELINE + ""
        "for _ in range(20):\n    app.update()\n"
        "gmo = parse_generic_model_output_data(sensor.get_data('generic-model-output')[0])\n"
        "print(gmo.numElements > 0, int(gmo.auxType) > 0)\napp.close()\n"
    )
    code, out, err = run_script(text, arguments=["--aux-data-level", "FULL", "--test"])
    assert (code, out) == (0, "True True\n"), err
