"""`graph exec --rclpy`: a script's own ROS 2 node, over the message bus."""

import pytest

SCRIPT = """from isaacsim import SimulationApp
app = SimulationApp()
import rclpy
from rclpy.node import Node
from geometry_msgs.msg import Twist
from rosgraph_msgs.msg import Clock
from std_msgs.msg import String
import omni.graph.core as og
import omni.timeline
keys = og.Controller.Keys
og.Controller.edit({"graph_path": "/G", "evaluator_name": "execution"}, {
    keys.CREATE_NODES: [
        ("tick", "omni.graph.action.OnPlaybackTick"),
        ("time", "isaacsim.core.nodes.IsaacReadSimulationTime"),
        ("clock", "isaacsim.ros2.bridge.ROS2PublishClock"),
        ("twist", "isaacsim.ros2.bridge.ROS2SubscribeTwist"),
    ],
    keys.CONNECT: [
        ("tick.outputs:tick", "clock.inputs:execIn"),
        ("tick.outputs:tick", "twist.inputs:execIn"),
        ("time.outputs:simulationTime", "clock.inputs:timeStamp"),
    ],
})
rclpy.init()
class Listener(Node):
    def __init__(self):
        super().__init__("listener")
        self.stamps = []
        self.create_subscription(Clock, "clock", lambda m: self.stamps.append((m.clock.sec, m.clock.nanosec)), 10)
        self.commands = self.create_publisher(Twist, "cmd_vel", 10)
        self.texts = self.create_publisher(String, "text", 10)
node = Listener()
omni.timeline.get_timeline_interface().play()
for number in range(3):
    command = Twist()
    command.linear.x = 0.5 * number
    node.commands.publish(command)
    node.texts.publish(String(data=f"number {number}"))
    app.update()
    rclpy.spin_once(node, timeout_sec=0.0)
print(rclpy.ok(), node.stamps)
print(list(og.Controller.get("/G/twist.outputs:linearVelocity")))
rclpy.shutdown()
app.close()
"""


def test_a_node_hears_and_is_heard(run_script):
    code, out, err = run_script(SCRIPT, "--rclpy")
    assert code == 0, err
    lines = out.splitlines()
    assert lines[0] == "True [(0, 16666667), (0, 33333333), (0, 50000000)]"
    assert lines[1] == "[1.0, 0.0, 0.0]"
    assert "/text" in err


def test_without_the_option_there_is_no_rclpy(run_script):
    code, _, err = run_script(SCRIPT)
    assert code == 1
    assert "script.py:3: ModuleNotFoundError: No module named 'rclpy'" in err


CLOUDS = """from isaacsim import SimulationApp
app = SimulationApp()
import numpy as np
import rclpy
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.qos import QoSPresetProfiles
from sensor_msgs.msg import PointCloud2, PointField
from sensor_msgs_py import point_cloud2
rclpy.init()
node = rclpy.create_node("clouds")
heard = []
quality = QoSPresetProfiles.SENSOR_DATA.value
node.create_subscription(PointCloud2, "points", heard.append, quality, callback_group=ReentrantCallbackGroup())
publisher = node.create_publisher(PointCloud2, "points", quality)
kinds = [("x", 0, 7), ("y", 4, 7), ("z", 8, 7), ("ring", 12, 4)]
fields = [PointField(name=name, offset=offset, datatype=kind, count=1) for name, offset, kind in kinds]
points = np.array([(1, 2, 3, 7), (np.nan, 0, 0, 8)], [("x", "f4"), ("y", "f4"), ("z", "f4"), ("ring", "u2")])
publisher.publish(PointCloud2(height=1, width=2, fields=fields, point_step=14, row_step=28, data=points.tobytes()))
rclpy.spin_once(node)
print(point_cloud2.read_points(heard[0])["ring"].tolist())
print(point_cloud2.read_points_numpy(heard[0], field_names=("x", "y", "z"), skip_nans=True).tolist())
for wrong in (("x", "ring"), ("w",)):
    try:
        point_cloud2.read_points_numpy(heard[0], field_names=wrong)
    except ValueError as error:
        print(error)
print(node.destroy_publisher(publisher))
try:
    publisher.publish(PointCloud2())
except RuntimeError as error:
    print(error)
app.close()
"""


def test_points_of_a_cloud_that_was_heard_are_read_by_their_fields(run_script):
    code, out, err = run_script(CLOUDS, "--rclpy")
    assert code == 0, err
    assert out.splitlines() == [
        "[7, 8]",
        "[[1.0, 2.0, 3.0]]",
        "the fields x, ring are of several types; choose some of one type",
        "the cloud has no field w; it has x, y, z, ring",
        "True",
        "the publisher of /points is destroyed",
    ]


def test_publishers_subscribers_and_topics_are_counted(run_script):
    code, out, err = run_script(
        SCRIPT.split("for number")[0]
        + """
app.update()
print([node.count_publishers(one) for one in ("clock", "/cmd_vel", "nothing")])
print([node.count_subscribers(one) for one in ("/clock", "cmd_vel", "text")])
print(node.get_topic_names_and_types())
app.close()
""",
        "--rclpy",
    )
    assert code == 0, err
    assert out.splitlines() == [
        "[1, 1, 0]",
        "[1, 1, 0]",
        "[('/clock', ['rosgraph_msgs/msg/Clock']), ('/cmd_vel', ['geometry_msgs/msg/Twist']), "
        "('/text', ['std_msgs/msg/String'])]",
    ]


THREAD = """from isaacsim import SimulationApp
app = SimulationApp()
import threading
import rclpy
from rclpy.executors import MultiThreadedExecutor
from rosgraph_msgs.msg import Clock
import omni.graph.core as og
import omni.timeline
keys = og.Controller.Keys
og.Controller.edit({"graph_path": "/G", "evaluator_name": "execution"}, {
    keys.CREATE_NODES: [
        ("tick", "omni.graph.action.OnPlaybackTick"),
        ("time", "isaacsim.core.nodes.IsaacReadSimulationTime"),
        ("clock", "isaacsim.ros2.bridge.ROS2PublishClock"),
    ],
    keys.CONNECT: [
        ("tick.outputs:tick", "clock.inputs:execIn"),
        ("time.outputs:simulationTime", "clock.inputs:timeStamp"),
    ],
})
rclpy.init()
node = rclpy.create_node("listener")
stamps, ticks = [], []
node.create_subscription(Clock, "clock", lambda m: stamps.append(m.clock.nanosec), 10)
node.create_timer(0.03, lambda: ticks.append(len(stamps)))
executor = MultiThreadedExecutor()
executor.add_node(node)
thread = threading.Thread(target=SPIN, daemon=True)
thread.start()
thread.join()
omni.timeline.get_timeline_interface().play()
for _ in range(3):
    app.update()
    print(stamps, ticks)
STOP
app.update()
print(len(stamps))
app.close()
"""


@pytest.mark.parametrize(
    ("spin", "stop"),
    [
        ("executor.spin", "executor.shutdown()"),
        ("lambda: rclpy.spin(node)", "rclpy.shutdown()"),
        ("lambda: rclpy.spin_once(node)", "node.destroy_node()"),
    ],
)
def test_a_node_that_a_thread_spins_is_called_back_at_the_end_of_each_update(spin, stop, run_script):
    code, out, err = run_script(THREAD.replace("SPIN", spin).replace("STOP", stop), "--rclpy")
    assert code == 0, err
    # The timer's 30 ms are over with the second update, at 33.3 ms, whose stamp comes first.
    assert out.splitlines() == [
        "[16666667] []",
        "[16666667, 33333333] [2]",
        "[16666667, 33333333, 50000000] [2]",
        "3",
    ]
