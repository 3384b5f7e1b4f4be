"""Listens to a Foxglove server with a WebSocket client: `over_foxglove.py CLOUDS PORT`; `stall`: until the first."""

import hashlib
import json
import os
import signal
import struct
import sys
import time

from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect


def main():
    wanted, port = int(sys.argv[1]), sys.argv[2]
    print("ready", flush=True)
    end = time.monotonic() + 60
    while True:
        try:
            socket = connect(f"ws://127.0.0.1:{port}", subprotocols=["foxglove.sdk.v1"], max_size=None)
            break
        except OSError:
            assert time.monotonic() < end, "no server came"
            time.sleep(0.005)
    with socket:
        info = json.loads(socket.recv())
        socket.send(
            json.dumps(
                {
                    "op": "advertise",
                    "channels": [
                        {"id": 5, "topic": "/cmd_vel", "encoding": "cdr", "schemaName": "geometry_msgs/msg/Twist"}
                    ],
                }
            )
        )
        # Six float64 after the header of 4 bytes: forward at 0.5 m/s.
        command = b"\x01" + struct.pack("<I", 5) + b"\x00\x01\x00\x00" + struct.pack("<6d", 0.5, 0, 0, 0, 0, 0)
        channels, received, travelled, stamps = {}, [], 0.0, []
        sent = 0.0
        try:
            while len(received) < wanted:
                if time.monotonic() > sent + 0.05:
                    socket.send(command)
                    sent = time.monotonic()
                data = socket.recv(timeout=20)
                if isinstance(data, str):
                    for channel in json.loads(data).get("channels", ()):
                        channels[channel["id"]] = channel
                        subscription = {"id": channel["id"], "channelId": channel["id"]}
                        socket.send(json.dumps({"op": "subscribe", "subscriptions": [subscription]}))
                elif data[0] == 1:
                    number, log_ns = struct.unpack_from("<IQ", data, 1)
                    topic, message = channels[number]["topic"], data[13:]
                    if topic == "/points":
                        received.append([channels[number]["schemaName"], hashlib.sha256(message).hexdigest()])
                        stamps.append(log_ns)
                        if "stall" in sys.argv or ("late" in sys.argv and len(received) == 25):
                            os.kill(os.getpid(), signal.SIGSTOP)
                    elif topic == "/odom":
                        # The header of 4 bytes, stamp, two texts, then float64 on the next multiple of 8.
                        at = 12
                        for _ in range(2):
                            (length,) = struct.unpack_from("<I", message, at)
                            at += 4 + length
                            at += -at % 4
                        (travelled,) = struct.unpack_from("<d", message, at + (4 - at) % 8)
        except (TimeoutError, ConnectionClosed):
            pass
    schemas = {channel["topic"]: channel["schemaEncoding"] for channel in channels.values()}
    said = {"clouds": received, "travelled": travelled, "stamps": stamps, "server": info, "schemas": schemas}
    print(json.dumps(said))


main()
