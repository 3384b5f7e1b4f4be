"""Frames of lidars on a device: the channels of the processor's frames, there until they are read."""

import numpy as np
import pytest

pytest.importorskip("warp", reason="pip install 'tickgraph[gpu]'")
pytest.importorskip("mujoco_warp", reason="pip install 'tickgraph[gpu]'")

from pxr import Gf, UsdGeom, UsdPhysics

from graph.sim import App
from sensors import Lidar, LidarSensor
from sensors.annotators.annotator import Annotator
from sensors.annotators.registry import find_annotator
from sensors.errors import SensorValueError
from sensors.gmo import parse_generic_model_output_data
from sensors.gmo.layout import AUX_ARRAYS, ELEMENT_ARRAYS
from tests.support.devices import DEVICES, on_each


def lidar_app(device, **options):
    """A lidar on a body that falls and turns between walls, one of them a mesh."""
    app = App(device=device, **options)
    app.__enter__()
    stage = app.stage
    for number, place in enumerate([(4, 0, 0), (-5, 1, 0), (0, 6, 1)]):
        shape = (UsdGeom.Cube, UsdGeom.Sphere, UsdGeom.Cylinder)[number].Define(stage, f"/World/Thing{number}")
        shape.AddTranslateOp().Set(Gf.Vec3d(*place))
    UsdPhysics.RigidBodyAPI.Apply(stage.GetPrimAtPath("/World/Thing0"))
    carrier = UsdGeom.Cube.Define(stage, "/World/Carrier")
    carrier.GetSizeAttr().Set(0.2)
    body = UsdPhysics.RigidBodyAPI.Apply(carrier.GetPrim())
    body.CreateAngularVelocityAttr().Set(Gf.Vec3f(0, 0, 90))
    lidar = Lidar.create(
        "/World/Carrier/lidar", config="Example_Rotary_2D", translations=[0, 0, 0.3], aux_output_level="FULL"
    )
    return app, LidarSensor(lidar, annotators=["generic-model-output"])


def frame_of(device, updates=14, **options):
    app, sensor = lidar_app(device, **options)
    try:
        app.play()
        app.update(steps=updates)
        return parse_generic_model_output_data(sensor.get_data("generic-model-output")[0].copy())
    finally:
        app.close()
        app.__exit__(None, None, None)


@on_each
def test_a_frame_has_the_channels_of_the_processors(device):
    ours, theirs = frame_of(device), frame_of("cpu")
    assert ours.numElements == theirs.numElements > 500
    assert (ours.timestampNs, ours.frameId) == (theirs.timestampNs, theirs.frameId)
    for name in ("timeOffsetNs", "x", "y", "flags", "emitterId", "channelId", "tickId", "echoId", "matId"):
        assert np.array_equal(getattr(ours, name), getattr(theirs, name)), name
    assert np.abs(ours.z - theirs.z).max() < 1e-5
    assert np.abs(ours.scalar - theirs.scalar).max() < 1e-4
    assert np.abs(ours.velocities - theirs.velocities).max() < 1e-4


@on_each
@pytest.mark.parametrize("fidelity", [{"lidar.noise": "on"}, {"lidar.subrays": 3}, {"lidar.motion": "continuous"}])
def test_what_frames_on_the_device_cannot_have_is_cast_there_and_made_on_the_host(device, fidelity):
    ours, theirs = frame_of(device, fidelity=fidelity), frame_of("cpu", fidelity=fidelity)
    assert ours.numElements == theirs.numElements
    assert np.abs(ours.z - theirs.z).max() < 2e-5


@pytest.fixture(params=DEVICES)
def opened(request):
    """An App on a device and its lidar, after two scans."""
    app, sensor = lidar_app(request.param)
    try:
        cloud = Annotator(find_annotator("IsaacExtractRTXSensorPointCloud"), app=app).attach(sensor.render_product)
        app.play()
        app.update(steps=14)
        yield request.param, sensor, cloud
    finally:
        app.close()
        app.__exit__(None, None, None)


def test_a_point_cloud_can_be_read_where_it_is(opened):
    """The arrays on the device hold the host's numbers."""
    device, _, cloud = opened
    there, here = cloud.get_data(device), cloud.get_data()
    for name in ("data", "distance", "intensity", "azimuth", "elevation"):
        assert np.array_equal(there[name].numpy(), here[name]), name


def test_every_array_of_a_model_output_can_be_read_where_it_is(opened):
    """The header and all element arrays are those of the buffer that the host gets."""
    device, sensor, _ = opened
    there, _ = sensor.get_data("generic-model-output", device)
    here = parse_generic_model_output_data(sensor.get_data("generic-model-output")[0])
    assert parse_generic_model_output_data(there) is there
    assert there.numElements == here.numElements > 500
    for name in ("frameId", "timestampNs", "sizeInBytes", "filledAuxMembers", "auxType", "elementsCoordsType"):
        assert getattr(there, name) == getattr(here, name), name
    for name in (*ELEMENT_ARRAYS, *(name for name, bit in AUX_ARRAYS.items() if bit in here.filledAuxMembers)):
        assert np.array_equal(getattr(there, name).numpy(), getattr(here, name)), name


def test_arrays_on_the_device_share_their_memory_by_the_interfaces_of_arrays(opened):
    """Without a copy: a number written through one of them is read through the other."""
    device, _, cloud = opened
    distance = cloud.get_data(device)["distance"]
    if device == "cuda":
        assert distance.__cuda_array_interface__["data"][0] == distance.ptr
        return
    assert distance.__array_interface__["data"][0] == distance.ptr
    shared = np.from_dlpack(distance)
    np.asarray(distance)[0] = 12.5
    assert shared[0] == distance.numpy()[0] == 12.5


def test_a_question_for_a_channel_copies_nothing_to_the_host(opened):
    _, sensor, _ = opened
    arrays = App.current().rendering.products[str(sensor.render_product.path)].frame.arrays
    name = next(one for one in arrays if one not in arrays.fetched)
    assert name in arrays
    assert "rv_ms" not in arrays
    assert name not in arrays.fetched


def test_another_device_than_that_of_the_frames_is_refused(opened):
    device, sensor, cloud = opened
    for read in (cloud.get_data, lambda name: sensor.get_data("generic-model-output", name)):
        with pytest.raises(SensorValueError, match=f"device 'cuda:6': these frames are on {device}; name that"):
            read("cuda:6")


def test_torch_takes_the_arrays_without_a_copy(opened):
    torch = pytest.importorskip("torch")
    device, _, cloud = opened
    distance = cloud.get_data(device)["distance"]
    assert torch.from_dlpack(distance).data_ptr() == distance.ptr


def test_without_a_device_arrays_are_on_the_host():
    app, _ = lidar_app("cpu")
    try:
        cloud = Annotator(find_annotator("IsaacExtractRTXSensorPointCloud"), app=app)
        cloud.attach(next(iter(app.rendering.products.values())))
        with pytest.raises(SensorValueError, match="annotators are in host memory"):
            cloud.get_data(device="cuda")
    finally:
        app.close()
        app.__exit__(None, None, None)
