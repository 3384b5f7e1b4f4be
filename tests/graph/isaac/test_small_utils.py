"""`isaacsim.core.utils` in small, its former names, and modules that scripts of others import."""

SCENE = """from isaacsim import SimulationApp
import omni.usd
from pxr import Gf, UsdGeom, UsdPhysics
app = SimulationApp()
stage = omni.usd.get_context().get_stage()
"""


def test_vectors_ranges_and_constants(run_script):
    code, out, err = run_script(
        """import numpy as np
from omni.isaac.core.utils.math import cross, normalize, normalized, radians_to_degrees
from isaacsim.core.utils.constants import AXES_INDICES
from isaacsim.core.utils.random import get_random_values_in_range
v = np.array([3.0, 0, 4])
print(cross([1, 0, 0], [0, 1, 0]), normalized(v).round(3), v, radians_to_degrees(np.pi))
normalize(v)
print(v, normalized(np.zeros(3)), AXES_INDICES["z"])
drawn = get_random_values_in_range(np.array([0, 5]), np.array([1, 5]))
print(0 <= drawn[0] <= 1, drawn[1])
"""
    )
    assert code == 0, err
    assert out.splitlines() == [
        "[0, 0, 1] [0.6 0.  0.8] [3. 0. 4.] 180.0",
        "[0.6 0.  0.8] [0. 0. 0.] 2",
        "True 5.0",
    ]


def test_profiled_functions_run_as_they_are(run_script):
    code, out, err = run_script(
        """import carb.profiler
@carb.profiler.profile
def twice(x):
    return 2 * x
@carb.profiler.profile(zone_name="half", add_args=False)
def half(x):
    return x / 2
carb.profiler.begin(1, "zone")
print(twice(3), half(3))
carb.profiler.end(1)
"""
    )
    assert (code, out) == (0, "6 1.5\n"), err


def test_rays_and_vertices(run_script):
    """A ray along the turned X axis, from 1 m above the shifted start down to the slab's top at 0.5 m."""
    code, out, err = run_script(
        SCENE
        + """import numpy as np
from isaacsim.core.utils.collisions import ray_cast
from isaacsim.core.utils.mesh import get_mesh_vertices_relative_to
import omni.timeline
slab = UsdGeom.Cube.Define(stage, "/World/Slab")
slab.CreateSizeAttr(1.0)
UsdPhysics.CollisionAPI.Apply(slab.GetPrim())
mesh = UsdGeom.Mesh.Define(stage, "/World/Mesh")
mesh.CreatePointsAttr([(1, 0, 0)])
UsdGeom.XformCommonAPI(mesh).SetTranslate((0, 2, 0))
omni.timeline.get_timeline_interface().play()
app.update()
down = np.array([0.5 ** 0.5, 0, 0.5 ** 0.5, 0])
start = np.array([0, 0, 2.0])
path, distance = ray_cast(start, down, np.array([0.5, 0, 0]))
print(path, round(distance, 4), ray_cast(start, down, np.zeros(3), 1.0))
UsdGeom.XformCommonAPI(slab).SetTranslate((0, 0, 5))
app.update()
print(get_mesh_vertices_relative_to(mesh.GetPrim(), slab.GetPrim()).tolist())
app.close()
"""
    )
    assert code == 0, err
    assert out.splitlines() == ["/World/Slab 1.0 (None, 10000.0)", "[[1.0, 2.0, -5.0]]"]


def test_roots_colliders_ops_and_labels(run_script):
    code, out, err = run_script(
        SCENE
        + """from isaacsim.core.utils.articulations import move_articulation_root, add_articulation_root
from isaacsim.core.utils.semantics import add_update_semantics, get_semantics, remove_all_semantics
from omni.physx.scripts import physicsUtils, utils
import omni.log
arm, base = (UsdGeom.Xform.Define(stage, path).GetPrim() for path in ("/Arm", "/Arm/Base"))
move_articulation_root(base, arm)
print(arm.HasAPI(UsdPhysics.ArticulationRootAPI))
add_articulation_root(arm)
move_articulation_root(arm, base)
print([one.HasAPI(UsdPhysics.ArticulationRootAPI) for one in (arm, base)])
box = UsdGeom.Cube.Define(stage, "/Arm/Base/Box")
utils.setStaticCollider(base)
print(box.GetPrim().HasAPI(UsdPhysics.CollisionAPI))
held = box.AddTranslateOp(UsdGeom.XformOp.PrecisionDouble)
physicsUtils.set_or_add_scale_orient_translate(box, Gf.Vec3f(2), Gf.Quatf(1), Gf.Vec3f(1, 2, 3))
physicsUtils.set_or_add_scale_op(box, Gf.Vec3d(4))
print(held.Get(), [(op.GetName(), str(op.GetTypeName())) for op in box.GetOrderedXformOps()])
print(box.GetScaleOp().Get())
add_update_semantics(box.GetPrim(), "crate")
remove_all_semantics(arm)
print(get_semantics(box.GetPrim()))
remove_all_semantics(arm, recursive=True)
print(get_semantics(box.GetPrim()))
omni.log.warn("seen")
app.close()
"""
    )
    assert code == 0, err
    assert out.splitlines() == [
        "False",
        "[False, True]",
        "True",
        "(1, 2, 3) [('xformOp:translate', 'double3'), ('xformOp:orient', 'quatf'), ('xformOp:scale', 'float3')]",
        "(4, 4, 4)",
        "{'class_crate': ('class', 'crate')}",
        "{}",
    ]
    assert "seen" in err


def test_modules_of_former_layouts_are_the_present_ones(run_script):
    code, out, err = run_script(
        """from isaacsim import SimulationApp
app = SimulationApp()
from isaacsim.core.api import World
from isaacsim.core.api.world.world import World as one
from omni.isaac.core.world.world import World as two
from isaacsim.core.api.objects import DynamicSphere
from omni.isaac.core.objects.sphere import DynamicSphere as three
from isaacsim.sensors.physics import EffortSensor
from omni.isaac.sensor.scripts.effort_sensor import EffortSensor as four
from omni.isaac.debug_draw import _debug_draw
import omni.kit.hotkeys.core, omni.kit.property.usd, omni.kit.widget.viewport, omni.ui.scene
print(one is World, two is World, three is DynamicSphere, four is EffortSensor)
from isaacsim.sensors.rtx import IsaacSensorCreateRtxLidar
try:
    IsaacSensorCreateRtxLidar(path="/World/Lidar")
except Exception as error:
    print(error)
app.close()
"""
    )
    assert code == 0, err
    first, second = out.splitlines()
    assert first == "True True True True"
    assert "omni.kit.commands.execute" in second


def test_a_data_logger_reads_what_it_saved(run_script, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    code, out, err = run_script(
        """from isaacsim import SimulationApp
app = SimulationApp()
from isaacsim.core.api import World
world = World()
logger = world.get_data_logger()
logger.add_data_frame_logging_func(lambda tasks, scene: {"seven": 7})
world.reset()
logger.start()
for _ in range(3):
    world.step()
logger.save(log_path="./log.json")
logger.reset()
logger.load(log_path="./log.json")
print(logger.get_data_frame(data_frame_index=2).data)
"""
    )
    assert (code, out.strip()) == (0, "{'seven': 7}"), err
