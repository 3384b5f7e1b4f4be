"""`graph exec --rclpy`: a script's own ROS 2 node, over the message bus."""

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
