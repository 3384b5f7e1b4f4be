"""Listens over zenoh with a plain session: `over_zenoh.py CLOUDS PORT`; with `stall` until the first cloud.

Listens at PORT as the router that ROS 2 would run. Hashes are of ROS 2 Jazzy (`ros2 topic info -v`).
"""

import hashlib
import json
import os
import signal
import struct
import sys
import threading
import time

import zenoh

TWIST = "0/cmd_vel/geometry_msgs::msg::dds_::Twist_/RIHS01_"
TWIST_HASH = "9c45bf16fe0983d80e3cfe750d6835843d265a9a6c46bd2e609fcddde6fb8d2a"


def main():
    wanted, port = int(sys.argv[1]), sys.argv[2]
    config = zenoh.Config()
    config.insert_json5("mode", '"router"')
    config.insert_json5("listen/endpoints", json.dumps([f"tcp/127.0.0.1:{port}"]))
    config.insert_json5("scouting/multicast/enabled", "false")
    session = zenoh.open(config)
    lock, clouds, odometry, tokens = threading.Lock(), [], [], {}

    def cloud(sample):
        beside = sample.attachment.to_bytes()
        sequence, _, length = struct.unpack("<qqB", beside[:17])
        data = sample.payload.to_bytes()
        said = {
            "key": str(sample.key_expr),
            "digest": hashlib.sha256(data).hexdigest(),
            "sequence": sequence,
            "attachment": [len(beside), length],
            "gid": beside[17:].hex(),
        }
        with lock:
            clouds.append(said)
        if "stall" in sys.argv or ("late" in sys.argv and len(clouds) == 25):
            os.kill(os.getpid(), signal.SIGSTOP)

    def alive(sample):
        with lock:
            tokens.setdefault(str(sample.key_expr), True)

    keep = [
        session.declare_subscriber("0/points/sensor_msgs::msg::dds_::PointCloud2_/*", cloud),
        session.declare_subscriber("0/odom/**", lambda sample: odometry.append(sample.payload.to_bytes())),
        session.liveliness().declare_subscriber("@ros2_lv/0/**", alive, history=True),
    ]
    right = session.declare_publisher(TWIST + TWIST_HASH)
    wrong = session.declare_publisher(TWIST + "0" * 64)
    print("ready", flush=True)

    def twist(forward):
        return b"\x00\x01\x00\x00" + struct.pack("<6d", forward, 0, 0, 0, 0, 0)

    last, count = time.monotonic(), 0
    while count < wanted and time.monotonic() < last + 120:
        right.put(twist(0.5), attachment=struct.pack("<qqB", 1, time.time_ns(), 16) + bytes(16))
        wrong.put(twist(-0.5), attachment=struct.pack("<qqB", 1, time.time_ns(), 16) + bytes(16))
        time.sleep(0.02)
        with lock:
            if len(clouds) > count:
                last, count = time.monotonic(), len(clouds)
    message, at = odometry[-1] if odometry else b"", 12
    for _ in range(2 if message else 0):  # frame and child frame
        (length,) = struct.unpack_from("<I", message, at)
        at += 4 + length
        at += -at % 4
    travelled = struct.unpack_from("<d", message, at + (4 - at) % 8)[0] if message else 0.0
    with lock:
        print(json.dumps({"clouds": clouds, "travelled": travelled, "tokens": sorted(tokens)}))
    del keep


main()
