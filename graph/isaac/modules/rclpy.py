"""`rclpy` in this process, over the App's message bus; importable only with `graph exec --rclpy`."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable
from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np

from graph.isaac.kit import LAST
from graph.isaac.run import RUN
from graph.isaac.session import app, kit
from graph.sim.messages.ros_types import fields, known, message_type

__all__ = [
    "MultiThreadedExecutor",
    "MutuallyExclusiveCallbackGroup",
    "Node",
    "QoSDurabilityPolicy",
    "QoSHistoryPolicy",
    "QoSPresetProfiles",
    "QoSProfile",
    "QoSReliabilityPolicy",
    "ReentrantCallbackGroup",
    "SingleThreadedExecutor",
    "create_node",
    "init",
    "ok",
    "qos_profile_sensor_data",
    "shutdown",
    "spin",
    "spin_once",
]
_NUMBERS = {"float32", "float64", "int8", "int16", "int32", "int64", "uint8", "uint16", "uint32", "uint64", "bool"}
_BASE, _NAME = 1, 2
_ON: list[bool] = [False]
_PAUSE = 0.01
"""How long a turn of a thread that spins takes [s]."""


class Message:
    """A message with the fields of its type, each with its default."""

    _type = ""

    def __init__(self, **values: Any) -> None:
        for name, content in fields(self._type):
            setattr(self, name, values.get(name, _default(content)))

    def __repr__(self) -> str:
        return f"{self._type}({', '.join(f'{name}={getattr(self, name)!r}' for name, _ in fields(self._type))})"


@cache
def message_class(type_name: str) -> type[Message]:
    """The class of a message type. Raises AttributeError for an unknown one."""
    if not known(type_name):
        raise AttributeError(f"there is no message type {type_name}")
    constants = {
        name: value
        for name, value in vars(message_type(type_name)).items()
        if name.isupper() and not name.startswith("_")
    }
    return type(type_name.rpartition("/")[2], (Message,), {"_type": type_name, **constants})


def _default(content: Any) -> Any:
    kind, inner = int(content[0]), content[1]
    if kind == _NAME:
        return message_class(inner)()
    if kind == _BASE:
        name = inner[0]
        return "" if name in ("string", "wstring") else False if name == "bool" else 0.0 if "float" in name else 0
    return [_default(inner[0]) for _ in range(inner[1])] if kind == 3 else []


def _to_bus(value: Any, content: Any) -> Any:
    kind, inner = int(content[0]), content[1]
    if kind == _NAME:
        if not isinstance(value, Message):
            return value
        return message_type(inner)(**{name: _to_bus(getattr(value, name), one) for name, one in fields(inner)})
    if kind == _BASE:
        return value
    base = inner[0]
    if int(base[0]) == _BASE and base[1][0] in _NUMBERS:
        if isinstance(value, (bytes, bytearray, memoryview)):
            return np.frombuffer(value, base[1][0])
        return np.asarray(value, base[1][0])
    return [_to_bus(one, base) for one in value]


class _Publisher:
    def __init__(self, kind: Any, topic: str) -> None:
        self._type, self.topic_name, self.closed = kind._type, topic, False
        app().bus.advertise(topic, self._type, "rclpy")

    def publish(self, msg: Any) -> None:
        if self.closed:
            raise RuntimeError(f"the publisher of {self.topic_name} is destroyed")
        bus = app().bus
        bus.publish(self.topic_name, self._type, _to_bus(msg, (_NAME, self._type)), bus.now_ns)

    def get_subscription_count(self) -> int:
        return int(app().bus.is_listened_to(self.topic_name))


class _Time(SimpleNamespace):
    nanoseconds: int

    def to_msg(self) -> Any:
        seconds, rest = divmod(self.nanoseconds, 10**9)
        return message_class("builtin_interfaces/msg/Time")(sec=seconds, nanosec=rest)

    def seconds_nanoseconds(self) -> tuple[int, int]:
        return divmod(self.nanoseconds, 10**9)


class Node:
    def __init__(self, node_name: str, *_: Any, namespace: str = "", **__: Any) -> None:
        self._name, self._space = node_name, namespace.strip("/")
        self._heard: list[tuple[Any, Callable[[Any], Any]]] = []
        self._timers: list[list[Any]] = []
        self._end_following: Callable[[], Any] | None = None
        self.spins_behind = False
        """Whether a thread spins it: its callbacks then come at the end of every update, so that runs repeat."""

    def get_name(self) -> str:
        return self._name

    def _topic(self, topic: str) -> str:
        return topic if topic.startswith("/") else f"/{self._space}/{topic}" if self._space else f"/{topic}"

    def create_publisher(self, msg_type: Any, topic: str, qos_profile: Any = 10, **_: Any) -> _Publisher:
        return _Publisher(msg_type, self._topic(topic))

    def destroy_publisher(self, publisher: _Publisher) -> bool:
        publisher.closed = True
        return True

    def create_subscription(
        self, msg_type: Any, topic: str, callback: Callable[[Any], Any], qos_profile: Any = 10, **_: Any
    ) -> Any:
        depth = qos_profile if isinstance(qos_profile, int) else getattr(qos_profile, "depth", 10)
        queue = app().bus.listen(self._topic(topic), msg_type._type, depth=depth, owner=f"rclpy {self._name}")
        self._heard.append((queue, callback))
        self._follow_updates()
        return queue

    def destroy_subscription(self, subscription: Any) -> bool:
        app().bus.unlisten(subscription)
        self._heard = [one for one in self._heard if one[0] is not subscription]
        return True

    def count_publishers(self, topic_name: str) -> int:
        topic = app().bus.topics.get(self._topic(topic_name))
        return 0 if topic is None else len(topic.owners)

    def count_subscribers(self, topic_name: str) -> int:
        return app().bus.count_subscriptions(self._topic(topic_name))

    def get_topic_names_and_types(self, no_demangle: bool = False) -> list[tuple[str, list[str]]]:
        bus = app().bus
        types = {name: one.type_name for name, one in bus.listened().items()}
        types |= {name: one.type_name for name, one in bus.topics.items()}
        return [(name, [types[name]]) for name in sorted(types)]

    def create_timer(self, timer_period_sec: float, callback: Callable[[], Any], **_: Any) -> Any:
        held = [float(timer_period_sec), callback, float(app().simulation.time) + float(timer_period_sec)]
        self._timers.append(held)
        self._follow_updates()
        return SimpleNamespace(cancel=lambda: self._timers.remove(held) if held in self._timers else None)

    def get_clock(self) -> Any:
        return SimpleNamespace(now=lambda: _Time(nanoseconds=app().bus.now_ns))

    def get_logger(self) -> Any:
        log = logging.getLogger("tickgraph")
        return SimpleNamespace(
            info=log.info, warn=log.warning, warning=log.warning, error=log.error, debug=log.debug, fatal=log.error
        )

    def _follow_updates(self) -> None:
        if self._end_following is None:
            self._end_following = app().on("end", self._updated, LAST)

    def _updated(self) -> None:
        if self.spins_behind and _ON[0]:
            self.handle()

    def destroy_node(self) -> bool:
        self.spins_behind = False
        if self._end_following is not None:
            self._end_following()
            self._end_following = None
        for queue, _ in self._heard:
            app().bus.unlisten(queue)
        self._heard, self._timers = [], []
        return True

    def handle(self) -> None:
        """Calls back for every message that waits, and for timers that are due on the simulation's time."""
        for queue, callback in list(self._heard):
            while (message := queue.take()) is not None:
                callback(message.message)
        for timer in list(self._timers):
            if float(app().simulation.time) >= timer[2]:
                timer[2] += timer[0]
                timer[1]()


def create_node(node_name: str, **options: Any) -> Node:
    return Node(node_name, **options)


def init(*_: Any, **__: Any) -> None:
    _ON[0] = True


def shutdown(*_: Any, **__: Any) -> None:
    _ON[0] = False


def ok(*_: Any, **__: Any) -> bool:
    return _ON[0]


def spin_once(node: Node, *_: Any, timeout_sec: Any = None, **__: Any) -> None:
    if RUN.get() is None:
        _spin_behind(node)
        time.sleep(_PAUSE)
        return
    node.handle()


def spin(node: Node, *_: Any) -> None:
    run = RUN.get()
    if run is None:
        _spin_behind(node)
    while _ON[0] and run is not None and not run.over():
        kit().update()
        node.handle()


def _spin_behind(node: Node) -> None:
    """What spinning in a thread of the script's own does: such a thread does not call back, the updates do."""
    node.spins_behind = True


class SingleThreadedExecutor:
    def __init__(self, *_: Any, **__: Any) -> None:
        self._nodes: list[Node] = []

    def add_node(self, node: Node) -> bool:
        self._nodes.append(node)
        return True

    def spin_once(self, timeout_sec: Any = None) -> None:
        for node in self._nodes:
            spin_once(node, timeout_sec=timeout_sec)

    def spin(self) -> None:
        for node in self._nodes:
            spin(node)

    def shutdown(self, *_: Any) -> None:
        for node in self._nodes:
            node.spins_behind = False
        self._nodes.clear()


MultiThreadedExecutor = SingleThreadedExecutor


class QoSProfile(SimpleNamespace):
    def __init__(self, depth: int = 10, **options: Any) -> None:
        super().__init__(depth=depth, **options)


QoSReliabilityPolicy = SimpleNamespace(RELIABLE=1, BEST_EFFORT=2)
QoSDurabilityPolicy = SimpleNamespace(TRANSIENT_LOCAL=1, VOLATILE=2)
QoSHistoryPolicy = SimpleNamespace(KEEP_LAST=1, KEEP_ALL=2)
qos_profile_sensor_data = QoSProfile(5)
QoSPresetProfiles = SimpleNamespace(
    **{
        name: SimpleNamespace(name=name, value=QoSProfile(depth))
        for name, depth in (
            ("UNKNOWN", 10),
            ("SYSTEM_DEFAULT", 10),
            ("SENSOR_DATA", 5),
            ("SERVICES_DEFAULT", 10),
            ("PARAMETERS", 1000),
            ("PARAMETER_EVENTS", 1000),
            ("ACTION_STATUS_DEFAULT", 1),
        )
    }
)


class ReentrantCallbackGroup:
    """Callbacks run one after the other here, whatever their group."""


MutuallyExclusiveCallbackGroup = ReentrantCallbackGroup
