"""What works for nobody is a warning of the run, in the words of `graph explain`, and of `check` where it can know."""

import json

import pytest

FILE = """\
tickgraph: 1
scene:
  prims:
    /World/Box: {type: Cube, translate: [3, 0, 0]}
    /World/Lidar: {type: OmniLidar, config: picoScan150}
clock: {physics_hz: 240, loop_hz: 60}
graphs:
  /World/G:
    nodes:
      tick: OnPlaybackTick
      wait: {type: Countdown, inputs: {duration: 5}}
      product: {type: IsaacCreateRenderProduct, inputs: {cameraPrim: /World/Lidar}}
      late: {type: Countdown, inputs: {duration: 5000}}
      second: {type: IsaacCreateRenderProduct, inputs: {cameraPrim: /World/Lidar, width: 100}}
      off: {type: IsaacCreateRenderProduct, inputs: {cameraPrim: /World/Lidar, width: 50, enabled: false}}
    connections:
      - tick.tick -> [wait.execIn, late.execIn, off.execIn]
      - wait.finished -> product.execIn
      - late.finished -> second.execIn
"""
READ = """\
      cloud: {type: ROS2RtxLidarHelper, inputs: {type: point_cloud}}
    connections:
      - product.execOut -> cloud.execIn
      - product.renderProductPath -> cloud.renderProductPath
"""


@pytest.fixture
def told(folder, graph):
    """A function: {code, where: message} of a command on a file of this text."""

    def run(text, command, *arguments):
        (folder / "a.yaml").write_text(text)
        result = graph(command, "a.yaml", "--json", *arguments)
        assert result.code == 0
        report = json.loads(result.out)
        whole = report["files"][0] if command == "check" else report
        found = whole["traps" if command == "explain" else "warnings"]
        return {(one["code"], one["where"]): one["message"] for one in found}

    return run


def test_a_run_warns_of_what_explain_calls_traps(told):
    # A Countdown of 5 triggered in every update: 1 trigger starts it, 5 are ignored, and so on; of 12 ten, of 60 fifty.
    # The other one ignores all but the first.
    run, explained = told(FILE, "run", "--updates", "60"), told(FILE, "explain")
    assert set(run) == set(explained)
    assert run["latent-retriggered", "/World/G/wait"].startswith("Countdown sleeps through 50 of its 60 triggers")
    assert explained["latent-retriggered", "/World/G/wait"].startswith("Countdown sleeps through 10 of its 12 triggers")
    assert run["latent-retriggered", "/World/G/late"].startswith("Countdown sleeps through 59 of its 60 triggers")
    assert run["product-not-made", "/World/G/second"] == "it makes no render product in the first 60 updates"
    assert run["nobody-consumes", "/World/Lidar"] == explained["nobody-consumes", "/World/Lidar"]
    assert len(run) == 4


def test_check_names_products_whose_path_leads_nowhere(told):
    message = "it is rendered for /World/G/product, /World/G/second, but nothing asks for its channels"
    assert told(FILE, "check") == {("nobody-consumes", "/World/Lidar"): message}


def test_a_sensor_that_is_read_by_wire_or_by_name_is_not_warned_of(told):
    read = FILE.replace("    connections:\n", READ)
    assert told(read, "check") == {}
    assert ("nobody-consumes", "/World/Lidar") not in told(read, "run", "--updates", "30")
    named = FILE.replace(
        "    connections:\n",
        "      cloud: {type: OgnIsaacExtractRTXSensorPointCloud, inputs: {renderProductPath: /Render/P}}\n"
        "    connections:\n",
    )
    assert ("nobody-consumes", "/World/Lidar") not in told(named, "check")


def test_a_camera_whose_lens_alone_is_published_is_not_warned_of(told):
    """CameraInfo goes with the frames and needs no channel of them."""
    text = (
        FILE.split("clock:")[0].replace("{type: OmniLidar, config: picoScan150}", "{type: Camera}")
        + """\
graphs:
  /World/G:
    nodes:
      tick: OnPlaybackTick
      product: {type: IsaacCreateRenderProduct, inputs: {cameraPrim: /World/Lidar, width: 8, height: 6}}
      info: ROS2CameraInfoHelper
    connections:
      - tick.tick -> product.execIn
      - product.execOut -> info.execIn
      - product.renderProductPath -> info.renderProductPath
"""
    )
    assert told(text, "run", "--updates", "3") == told(text, "explain") == {}


def test_a_sensor_that_nothing_reads_is_not_said_to_have_seen_nothing(folder, graph):
    (folder / "a.yaml").write_text(FILE.replace("{type: OmniLidar, config: picoScan150}", "{type: OmniRadar}"))
    report = json.loads(graph("run", "a.yaml", "--updates", "12", "--json").out)
    assert "nobody-consumes" in {one["code"] for one in report["warnings"]}
    assert "sensor-saw-nothing" not in {one["code"] for one in report["warnings"]}
    assert not [line for line in report["silent"] if line.startswith("sensor")]


CAMERAS = """\
tickgraph: 1
scene:
  prims:
    /World/Camera: {{type: Camera, rotate: [90, 0, -90]}}
graphs:
  /World/G:
    nodes:
      tick: OnPlaybackTick
      product: {{type: IsaacCreateRenderProduct, inputs: {{cameraPrim: /World/Camera, width: 8, height: 6}}}}
      near: {{type: ROS2CameraHelper, inputs: {{type: depth}}}}
      ids: {{type: ROS2CameraHelper, inputs: {{type: instance_segmentation{topic}}}}}
    connections:
      - tick.tick -> product.execIn
      - product.execOut -> [near.execIn, ids.execIn]
      - product.renderProductPath -> [near.renderProductPath, ids.renderProductPath]
"""


@pytest.mark.parametrize("command", ["run", "explain"])
def test_pictures_of_two_nodes_on_one_topic_are_reported(told, command):
    """The default topic of every type is rgb."""
    updates = ["--updates", "2"] if command == "run" else []
    found = told(CAMERAS.format(topic=""), command, *updates)
    assert found["topic-shared", "/rgb"].startswith("/World/G/near, /World/G/ids publish on it")
    assert not told(CAMERAS.format(topic=", topicName: ids"), command, *updates)


@pytest.mark.parametrize("command", ["check", "run", "explain"])
def test_labels_of_two_nodes_on_one_topic_are_reported(told, command):
    """Both numberings on /semantic_labels; depth has no labels, and without enableSemanticLabels none are sent."""
    text = CAMERAS.replace("type: depth", "type: semantic_segmentation, topicName: kinds, enableSemanticLabels: true")
    updates = ["--updates", "2"] if command == "run" else []
    found = told(text.format(topic=", topicName: ids, enableSemanticLabels: true"), command, *updates)
    assert found["topic-shared", "/semantic_labels"].startswith("/World/G/near, /World/G/ids publish on it")
    named = ", topicName: ids, enableSemanticLabels: true, semanticLabelsTopicName: instances"
    assert not told(text.format(topic=named), command, *updates)
    assert not told(text.format(topic=", topicName: ids"), command, *updates)
