"""No stub: what returns a neutral value declares that it does nothing, or is listed here with the reason."""

import ast
from pathlib import Path

import pytest

import graph.isaac

ROOT = Path(graph.isaac.__file__).parent
DECLARED = ("inert", "abstractmethod", "overload")
TELLS = ("tell_inert", "warn")
HOOK = "a subclass gives it a body"
TRUE_HERE = "the value is true here"
DONE = "the work is done when it is called"
SETUPS = ("scene", "post_load", "pre_reset", "post_reset", "post_clear")
REASONS = {
    "managers/simulation_setup.py:SimulationSetup.get_device": TRUE_HERE,
    "managers/simulation_setup.py:SimulationSetup.assets_loading": TRUE_HERE,
    **{f"modules/base_samples.py:_Sample.setup_{one}": HOOK for one in SETUPS},
    "modules/arm_motion.py:KinematicsSolver.get_end_effector_frame": TRUE_HERE,
    "modules/arm_tasks.py:_ArmTask.make_objects": HOOK,
    "modules/base_samples.py:BaseSample.world_cleanup": HOOK,
    "modules/base_samples.py:PresentSample.physics_cleanup": HOOK,
    "modules/commands.py:Command.do": HOOK,
    "modules/physics_sensors.py:_Paced.initialize": DONE,
    "modules/sensor_prims.py:SensorPrim.author": HOOK,
    "modules/sensor_prims.py:SensorPrim.check": HOOK,
    "modules/sensor_readings.py:_Sensor.reset": HOOK,
    "modules/commands.py:Command.undo": HOOK,
    "modules/interfaces.py:IExt.on_startup": HOOK,
    "modules/interfaces.py:IExt.on_shutdown": HOOK,
    "modules/manipulators.py:Gripper.post_reset": HOOK,
    "modules/ui.py:AbstractValueModel.add_begin_edit_fn": "nobody edits a widget here",
    "modules/interfaces.py:_Physics.fetch_results": DONE,
    "modules/interfaces.py:_Physics.update_transformations": DONE,
    "modules/kit_app.py:IApp.get_app_name": TRUE_HERE,
    "modules/cloner.py:Cloner.disable_change_listener": "nothing that follows the stage is costly",
    "modules/kit_app.py:IApp.get_app_version": TRUE_HERE,
    "modules/kit_app.py:IApp.get_kit_version": TRUE_HERE,
    "modules/kit_app.py:IApp.is_app_ready": TRUE_HERE,
    "modules/lidar_rtx.py:LidarRtx.initialize": DONE,
    "modules/og.py:_Orchestration.is_valid": TRUE_HERE,
    "modules/og.py:Settings.__exit__": "its constructor says that it does nothing",
    "modules/old_prims.py:SingleXFormPrim.initialize": DONE,
    "modules/old_views.py:_View.initialize": DONE,
    "modules/range_sensors.py:release_lidar_sensor_interface": "the interface has no state",
    "modules/replicator_files.py:DiskBackend.wait_until_done": DONE,
    "modules/replicator.py:Writer.on_final_frame": HOOK,
    "modules/robots.py:BaseController.reset": HOOK,
    "modules/robots.py:ExperimentalDifferentialController.reset": "it has no state",
    "modules/sensors_rtx.py:Authoring.__len__": TRUE_HERE,
    "modules/sensor_interfaces.py:release_contact_sensor_interface": "the interface has no state",
    "modules/sensor_interfaces.py:release_imu_sensor_interface": "the interface has no state",
    "modules/stage.py:is_stage_loading": TRUE_HERE,
    "modules/surface_grippers.py:release_surface_gripper_interface": "the interface has no state",
    "modules/timeline.py:acquire_timeline_interface": "the interface has no state",
    "modules/usd.py:UsdContext.get_name": TRUE_HERE,
    "modules/usd.py:UsdContext.can_open_stage": TRUE_HERE,
    "modules/usd.py:UsdContext.has_pending_edit": TRUE_HERE,
    "modules/usdrt.py:_Stage.SynchronizeToFabric": "the stage and Fabric are one here",
    "modules/simulation_context.py:SimulationContext.get_block_on_render": TRUE_HERE,
    "modules/task.py:BaseTask.device": TRUE_HERE,
    "modules/task.py:BaseTask.pre_step": HOOK,
    "modules/task.py:BaseTask.post_reset": HOOK,
    "modules/task.py:BaseTask.get_description": HOOK,
    "modules/task.py:BaseTask.cleanup": HOOK,
    "omnigraph/handles.py:Node.is_backed_by_usd": TRUE_HERE,
    "omnigraph/attributes.py:AttributeData.cpu_valid": TRUE_HERE,
    "omnigraph/attributes.py:AttributeData.gpu_valid": TRUE_HERE,
    "results.py:Result.device": TRUE_HERE,
}


def neutral(function):
    """Whether the body only returns a value that says nothing: None, a constant, an empty collection."""

    def says_nothing(line):
        if isinstance(line, ast.Expr):
            return isinstance(line.value, ast.Constant)
        if isinstance(line, ast.Return):
            value = line.value
            empty = isinstance(value, ast.List | ast.Tuple | ast.Dict) and not (
                value.keys if isinstance(value, ast.Dict) else value.elts
            )
            # A call without arguments of a class makes an empty object: `return EventStream()`.
            bare = (
                isinstance(value, ast.Call) and isinstance(value.func, ast.Name) and not (value.args or value.keywords)
            )
            made = bare and value.func.id[0].isupper()
            return value is None or isinstance(value, ast.Constant) or empty or made
        return isinstance(line, ast.Pass | ast.Delete)

    return all(map(says_nothing, function.body))


def stubs(text):
    """The qualified names of the functions of a module that do nothing without a word."""

    def inside(node, names, protocol=False):
        for child in ast.iter_child_nodes(node):
            if isinstance(child, ast.ClassDef):
                bases = [ast.unparse(one) for one in child.bases]
                yield from inside(child, [*names, child.name], "Protocol" in bases)
            elif isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef):
                decorators = [ast.unparse(one).partition("(")[0] for one in child.decorator_list]
                if neutral(child) and not protocol and not any(one in DECLARED for one in decorators):
                    yield ".".join([*names, child.name])
                yield from inside(child, [*names, child.name])
            elif isinstance(child, ast.Assign) and isinstance(child.value, ast.Lambda):
                lambda_body = ast.FunctionDef("", child.value.args, [ast.Return(child.value.body)], [])
                if neutral(lambda_body):
                    yield ".".join([*names, ast.unparse(child.targets[0])])
            else:
                yield from inside(child, names, protocol)

    yield from inside(ast.parse(text), [])


def found():
    for file in sorted(ROOT.rglob("*.py")):
        for name in stubs(file.read_text(encoding="utf-8")):
            yield f"{file.relative_to(ROOT).as_posix()}:{name}"


def test_every_neutral_function_says_so_or_has_a_reason():
    names = set(found())
    assert not names - REASONS.keys(), "declare it with graph.isaac.outcomes.inert, implement it, or give a reason"
    assert not REASONS.keys() - names, "these reasons are out of date"


@pytest.mark.parametrize(
    "body", ["return None", "return True", "return []", "return {}", 'return ""', "pass", "...", "return Stream()"]
)
def test_the_check_finds_a_stub(body):
    assert list(stubs(f"class A:\n    def f(self):\n        'doc'\n        {body}\n")) == ["A.f"]
    assert not list(stubs(f"class A:\n    @inert('omni')\n    def f(self):\n        {body}\n"))


def test_the_check_finds_a_lambda_and_leaves_real_bodies():
    assert list(stubs("class A:\n    f = lambda self: None\n")) == ["A.f"]
    assert not list(stubs("def f():\n    return g(1)\ndef h():\n    tell_inert('h')\n"))
