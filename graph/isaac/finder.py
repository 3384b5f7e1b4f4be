"""Makes Isaac Sim's modules importable, for a `with` block: a finder behind all others, over the table `names.txt`.

It never shadows an installed module, and a partly installed package (`omni`, `pxr`) is extended, not replaced.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from importlib import import_module
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from threading import RLock
from types import ModuleType
from typing import Any

from graph.base.suggest import did_you_mean

from .names import Names, home_of, names_of, public_names, table

KIT = ("carb", "isaacsim", "omni", "usd", "usdrt")
"""Top-level packages that exist only in Kit."""
ROS = ("rclpy", "sensor_msgs_py")
"""Those of ROS 2 that are here beside its messages."""


class IsaacModule(ModuleType):
    """A module of Isaac Sim: its names are looked up in the table at their first use."""

    def __getattr__(self, name: str) -> Any:
        names = names_of(self.__name__)
        if name == "__all__":
            return names.public()
        value = self._value(names, name)
        setattr(self, name, value)
        return value

    def _value(self, names: Names, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(f"module {self.__name__!r} has no attribute {name!r}")
        for home in names.homes:
            place = home_of(home)
            if name in public_names(place):
                return getattr(place, name)
        if self.__name__.endswith(".msg"):
            package = self.__name__.partition(".")[0]
            return home_of("rclpy").message_class(f"{package}/msg/{name}")
        if (row := names.row(name)) is not None:
            from .outcomes import outcome

            return outcome(f"{self.__name__}.{name}", row)
        try:
            return import_module(f"{self.__name__}.{name}")
        except ModuleNotFoundError as error:
            if error.name != f"{self.__name__}.{name}":
                raise
        near = did_you_mean(name, self.__dir__())
        raise AttributeError(f"TickGraph has no {self.__name__}.{name}{near}", name=name, obj=None)

    def __dir__(self) -> list[str]:
        names = names_of(self.__name__)
        return sorted({*super().__dir__(), *names.public(), *names.submodules})


class _Finder(MetaPathFinder, Loader):
    def find_spec(
        self, fullname: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        names = names_of(fullname)
        ros = fullname.partition(".")[0] in ROS or not names.known
        if ros and not _is_ros(fullname):
            return None
        return ModuleSpec(fullname, self, origin="tickgraph", is_package=True)

    def create_module(self, spec: ModuleSpec) -> ModuleType:
        made = _ours[spec.name] = IsaacModule(spec.name)
        return made

    def exec_module(self, module: ModuleType) -> None:
        """Nothing to run: names come at their first use; an old name is said once."""
        if module.__name__ == "pxr.PhysxSchema":
            home_of("physx_schema")  # a prim takes its classes from now on
        if instead := names_of(module.__name__).instead:
            from .outcomes import tell_old_name

            tell_old_name(module.__name__, instead)


def _is_ros(name: str) -> bool:
    """Whether it is a module of ROS 2, and the running script may import these (`graph exec --rclpy`)."""
    from .run import RUN

    run = RUN.get()
    if run is None or not run.rclpy:
        return False
    if name.partition(".")[0] in ROS:
        return names_of(name).known
    from graph.sim.messages.ros_types import type_names

    package, _, rest = name.partition(".")
    return rest in ("", "msg") and any(one.startswith(f"{package}/msg/") for one in type_names())


_FINDER = _Finder()
_users = 0
_ours: dict[str, ModuleType] = {}
"""The modules made so far, by name; `sys.modules` has them within `importable` only."""
_lock = RLock()


@contextmanager
def importable() -> Iterator[None]:
    """Makes Isaac Sim's modules importable within a `with` block only, so that no other code takes this for Kit.

    If a real module is installed, the import gives the real one. Blocks may be nested.
    """
    global _users
    with _lock:
        _users += 1
        if _users == 1:
            table()  # looks for the wings, so it is made before the finder is there
            sys.meta_path.append(_FINDER)
            sys.modules.update({name: module for name, module in _ours.items() if name not in sys.modules})
    try:
        yield
    finally:
        with _lock:
            _users -= 1
            if not _users:
                sys.meta_path.remove(_FINDER)
                for name, module in list(_ours.items()):
                    if sys.modules.get(name) is module:
                        del sys.modules[name]
                        _unbind(name, module)
                    names = names_of(name)
                    # Those of ROS 2 are only for runs that ask for them; old names are said in each run.
                    if name.partition(".")[0] in ROS or not names.known or names.instead:
                        del _ours[name]


def _unbind(name: str, module: ModuleType) -> None:
    """Removes a submodule from an installed package that it extended."""
    parent, _, last = name.rpartition(".")
    owner = sys.modules.get(parent)
    if owner is not None and not isinstance(owner, IsaacModule) and getattr(owner, last, None) is module:
        delattr(owner, last)


def advice(error: ImportError) -> str:
    """What to do about a missing module of Kit, as the tail of a message; "" for any other module."""
    name = error.name or ""
    if name.partition(".")[0] not in KIT:
        return ""
    if names_of(name).known:
        return "; import it at the top of the module, not while it computes"
    return "; TickGraph does not have that module of Kit: do without it, or catch the error"
