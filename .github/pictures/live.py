"""What a program receives from a run that goes on, and what it sends: a robot driven over a WebSocket."""

from __future__ import annotations

import json
import socket
import struct
import subprocess
import sys
import time
from typing import Any

import numpy as np
from drawing import BLUE, INK, LINE, ROOT, SOFT, YELLOW, Runs, axes, figure, graph, save

LENGTH = 9.0
COMMANDS = ((1.0, 0.5, 0.0), (3.0, 0.4, 1.0), (6.0, 0.4, -1.2), (8.0, 0.0, 0.0))
"""From these seconds on: forward speed [m/s], turn rate [rad/s]."""


def live(runs: Runs) -> None:
    """The path, and commands beside what the odometry says, as they came over the WebSocket."""
    heard = runs.folder / "live.json"
    if not heard.is_file():
        heard.write_text(json.dumps(listen(runs)))
    sent, got = (np.array(json.loads(heard.read_text())[name]) for name in ("sent", "got"))
    made = figure(
        640,
        "Live: a program drives the robot and listens to it, over a WebSocket",
        "graph new diffdrive robot.yaml && graph run robot.yaml --realtime --live foxglove:control",
    )
    path = axes(made, 90, 96, 560, 440, "/odom as received: the path, by time [s]")
    shown = path.scatter(got[:, 1], got[:, 2], 14, got[:, 0], cmap="viridis", linewidths=0, zorder=3)
    for one in got[:: max(1, len(got) // 14)]:
        path.annotate(
            "",
            (one[1] + 0.18 * np.cos(one[3]), one[2] + 0.18 * np.sin(one[3])),
            (one[1], one[2]),
            arrowprops={"arrowstyle": "-|>", "color": INK, "linewidth": 1.4},
        )
    path.set(xlabel="x [m]", ylabel="y [m]", aspect="equal")
    path.margins(0.15)
    path.set_adjustable("datalim")
    path.grid(linewidth=0.6)
    made.colorbar(shown, cax=axes(made, 666, 96, 14, 440)).outline.set_edgecolor(LINE)
    for top, column, unit, title in ((96, 1, "[m/s]", "forward"), (330, 2, "[rad/s]", "turn rate")):
        axis = axes(made, 850, top, 700, 176, f"{title} {unit}")
        axis.step(
            [*sent[:, 0], LENGTH],
            [*sent[:, column], sent[-1, column]],
            where="post",
            color=YELLOW,
            linewidth=2.5,
            label="sent: /cmd_vel",
        )
        axis.plot(
            got[:, 0], got[:, 3 + column], color=BLUE, linewidth=1.8, label=f"received: /odom, {len(got)} messages"
        )
        axis.set(xlim=(0, LENGTH))
        axis.grid(linewidth=0.6)
    axis.set_xlabel("seconds on the wall clock of the listener")
    axis.legend(fontsize=12, loc="lower left", labelcolor=SOFT)
    save(made, "live")


def listen(runs: Runs) -> dict[str, Any]:
    """Plays the robot of `graph new diffdrive` in real time, sends it commands, and notes what comes back.

    sent: (seconds, forward, turn); got: (seconds, x, y, yaw, forward, turn).
    """
    from rosbags.typesys import Stores, get_typestore
    from websockets.exceptions import ConnectionClosed
    from websockets.sync.client import connect

    types = get_typestore(Stores.ROS2_HUMBLE)
    runs.folder.mkdir(parents=True, exist_ok=True)
    robot = runs.folder / "robot.yaml"
    if not robot.is_file():
        graph("new", "diffdrive", str(robot))
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        port = one.getsockname()[1]
    target = f"foxglove:control:127.0.0.1:{port}"
    command = ["run", str(robot), "--realtime", "--live", target, "--duration", str(LENGTH)]
    sent, got, odometry = [[0.0, 0.0, 0.0]], [], -1
    with subprocess.Popen([sys.executable, "-m", "graph", *command], cwd=ROOT, stdout=subprocess.DEVNULL) as running:
        while True:
            try:
                server = connect(f"ws://127.0.0.1:{port}", subprotocols=["foxglove.sdk.v1"], max_size=None)
                break
            except OSError:
                if running.poll() is not None:
                    raise
                time.sleep(0.01)
        channel = {"id": 1, "topic": "/cmd_vel", "encoding": "cdr", "schemaName": "geometry_msgs/msg/Twist"}
        server.send(json.dumps({"op": "advertise", "channels": [channel]}))
        start, coming = None, list(COMMANDS)
        while True:
            now = 0.0 if start is None else time.monotonic() - start
            if coming and now >= coming[0][0]:
                _, forward, turn = coming.pop(0)
                twist = b"\x00\x01\x00\x00" + struct.pack("<6d", forward, 0, 0, 0, 0, turn)
                server.send(b"\x01" + struct.pack("<I", 1) + twist)
                sent.append([now, forward, turn])
            try:
                data = server.recv(timeout=20)
            except (TimeoutError, ConnectionClosed):
                break
            if isinstance(data, str):
                for one in json.loads(data).get("channels", ()):
                    if one["topic"] == "/odom":
                        odometry = one["id"]
                        server.send(
                            json.dumps({"op": "subscribe", "subscriptions": [{"id": 7, "channelId": odometry}]})
                        )
            elif data[0] == 1:
                start = time.monotonic() if start is None else start
                message = types.deserialize_cdr(data[13:], "nav_msgs/msg/Odometry")
                at, turned = message.pose.pose.position, message.pose.pose.orientation
                yaw = 2 * np.arctan2(turned.z, turned.w)
                speed = message.twist.twist
                got.append([time.monotonic() - start, at.x, at.y, yaw, speed.linear.x, speed.angular.z])
    return {"sent": sent, "got": got}
