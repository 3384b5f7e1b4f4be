"""Listens over DDS with Eclipse Cyclone DDS's own types: `over_dds.py CLOUDS`; with `stall` it stops at the first."""

import hashlib
import json
import os
import signal
import sys
import time
from dataclasses import dataclass

from cyclonedds.builtin import BuiltinDataReader, BuiltinTopicDcpsPublication
from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.idl.types import array, float64, int32, sequence, uint8, uint32
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic


@dataclass
class Time(IdlStruct, typename="builtin_interfaces.msg.dds_.Time_"):
    sec: int32
    nanosec: uint32


@dataclass
class Header(IdlStruct, typename="std_msgs.msg.dds_.Header_"):
    stamp: Time
    frame_id: str


@dataclass
class PointField(IdlStruct, typename="sensor_msgs.msg.dds_.PointField_"):
    name: str
    offset: uint32
    datatype: uint8
    count: uint32


@dataclass
class PointCloud2(IdlStruct, typename="sensor_msgs.msg.dds_.PointCloud2_"):
    header: Header
    height: uint32
    width: uint32
    fields: sequence[PointField]
    is_bigendian: bool
    point_step: uint32
    row_step: uint32
    data: sequence[uint8]
    is_dense: bool


@dataclass
class Vector3(IdlStruct, typename="geometry_msgs.msg.dds_.Vector3_"):
    x: float64
    y: float64
    z: float64


@dataclass
class Quaternion(IdlStruct, typename="geometry_msgs.msg.dds_.Quaternion_"):
    x: float64
    y: float64
    z: float64
    w: float64


@dataclass
class Point(IdlStruct, typename="geometry_msgs.msg.dds_.Point_"):
    x: float64
    y: float64
    z: float64


@dataclass
class Pose(IdlStruct, typename="geometry_msgs.msg.dds_.Pose_"):
    position: Point
    orientation: Quaternion


@dataclass
class PoseWithCovariance(IdlStruct, typename="geometry_msgs.msg.dds_.PoseWithCovariance_"):
    pose: Pose
    covariance: array[float64, 36]


@dataclass
class Twist(IdlStruct, typename="geometry_msgs.msg.dds_.Twist_"):
    linear: Vector3
    angular: Vector3


@dataclass
class TwistWithCovariance(IdlStruct, typename="geometry_msgs.msg.dds_.TwistWithCovariance_"):
    twist: Twist
    covariance: array[float64, 36]


@dataclass
class Odometry(IdlStruct, typename="nav_msgs.msg.dds_.Odometry_"):
    header: Header
    child_frame_id: str
    pose: PoseWithCovariance
    twist: TwistWithCovariance


@dataclass
class Clock(IdlStruct, typename="rosgraph_msgs.msg.dds_.Clock_"):
    clock: Time


def main():
    everything = Qos(Policy.Reliability.Reliable(10**8), Policy.History.KeepAll)
    participant = DomainParticipant()
    endpoints = BuiltinDataReader(participant, BuiltinTopicDcpsPublication)
    clouds = DataReader(participant, Topic(participant, "rt/points", PointCloud2), everything)
    odometry = DataReader(participant, Topic(participant, "rt/odom", Odometry), everything)
    clock = DataReader(participant, Topic(participant, "rt/clock", Clock), everything)
    commands = DataWriter(participant, Topic(participant, "rt/cmd_vel", Twist), everything)
    print("ready", flush=True)

    wanted, received, travelled, times, found = int(sys.argv[1]), [], 0.0, [], {}
    last = time.monotonic()
    while len(received) < wanted and time.monotonic() < last + 120:
        commands.write(Twist(Vector3(0.5, 0, 0), Vector3(0, 0, 0)))
        for endpoint in endpoints.take(N=100):
            if (getattr(endpoint, "topic_name", None) or "").startswith(
                "rt/"
            ) and endpoint.participant_key != participant.guid:
                found[endpoint.topic_name] = {
                    "type": endpoint.type_name,
                    "user_data": endpoint.qos[Policy.Userdata].data.decode() if Policy.Userdata in endpoint.qos else "",
                    "reliable": isinstance(endpoint.qos[Policy.Reliability], Policy.Reliability.Reliable),
                    "durability": str(endpoint.qos[Policy.Durability]),
                }
        for cloud in clouds.take(N=100):
            if isinstance(cloud, PointCloud2):
                received.append([cloud.width, hashlib.sha256(cloud.serialize()).hexdigest()])
                last = time.monotonic()
                if "stall" in sys.argv or ("late" in sys.argv and len(received) == 25):
                    os.kill(os.getpid(), signal.SIGSTOP)
        for message in odometry.take(N=1000):
            if isinstance(message, Odometry):
                travelled = message.pose.pose.position.x
        times += [m.clock.sec * 10**9 + m.clock.nanosec for m in clock.take(N=1000) if isinstance(m, Clock)]
        time.sleep(0.02)
    print(json.dumps({"clouds": received, "travelled": travelled, "clock": times, "endpoints": found}))


main()
