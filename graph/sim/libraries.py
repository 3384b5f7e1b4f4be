"""Imports Open3D: loads the native libraries that it links but does not ship, and delays parts of its import.

Open3D links `libusb-1.0`, `libGL`, `libEGL` and `libX11`. The first is in the PyPI package `libusb-package` and must be
loaded before Open3D; the others come from the system.
"""

from __future__ import annotations

import ctypes
import importlib
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from types import ModuleType
from typing import Any

from graph.base.errors import UserError

SYSTEM_LIBRARIES = ("libGL.so.1", "libEGL.so.1", "libX11.so.6")
"""The system libraries that Open3D needs, as the loader names them (Linux)."""

INSTALL_HINT = "apt-get install -y --no-install-recommends libgl1 libegl1"
"""Installs all of `SYSTEM_LIBRARIES` on Debian and Ubuntu (libGL depends on libX11)."""


def missing_system_libraries() -> tuple[str, ...]:
    """The `SYSTEM_LIBRARIES` that the loader cannot find; always empty on other systems, which need none of them."""
    if not sys.platform.startswith("linux"):
        return ()
    return tuple(name for name in SYSTEM_LIBRARIES if not _loads(name))


def import_open3d() -> ModuleType:
    """Imports Open3D after loading the libraries that it links.

    Raises UserError, with the command that installs it, if a system library or Open3D is missing.
    """
    with _IMPORTING:  # a second thread waits, instead of taking a half imported module
        return sys.modules.get("open3d") or _imported_open3d()


def _imported_open3d() -> ModuleType:
    missing = missing_system_libraries()
    if missing:
        raise UserError(f"Open3D needs {', '.join(missing)}, which is missing on this machine. Run: {INSTALL_HINT}")
    load_libusb()
    try:
        with _later("open3d.visualization.draw_plotly"):  # a web server with IPython: half of Open3D's import
            return importlib.import_module("open3d")
    except ImportError as error:
        raise UserError(f"Open3D does not import ({error}). Run `graph doctor` to see what is missing") from error


_IMPORTING = threading.RLock()


class _Later(ModuleType):
    """Takes the place of a module of functions; the first call of a function imports the module."""

    def __getattr__(self, name: str) -> Callable[..., Any]:
        if name.startswith("__"):
            raise AttributeError(name)
        function = partial(self._call, name)
        setattr(self, name, function)
        return function

    def _call(self, name: str, *args: Any, **kwargs: Any) -> Any:
        real = importlib.import_module(self.__name__)
        package = sys.modules[self.__name__.rpartition(".")[0]]
        for taken in (taken for taken, value in self.__dict__.items() if isinstance(value, partial)):
            setattr(package, taken, getattr(real, taken))
        return getattr(real, name)(*args, **kwargs)


@contextmanager
def _later(name: str) -> Iterator[None]:
    """Within the block, the module of functions `name` is replaced by an object that imports it later."""
    stand_in = sys.modules.setdefault(name, _Later(name))
    try:
        yield
    finally:
        if isinstance(stand_in, _Later):
            del sys.modules[name]


def load_libusb() -> None:
    """Loads `libusb-1.0` for the whole process, so that Open3D's link to that name resolves (only on Linux).

    The system's own copy is preferred. Raises UserError if no copy is found.
    """
    if not sys.platform.startswith("linux") or _loads("libusb-1.0.so.0"):
        return
    try:
        path = importlib.import_module("libusb_package").get_library_path()
        ctypes.CDLL(str(path), mode=ctypes.RTLD_GLOBAL)
    except (ImportError, OSError, TypeError) as error:
        raise UserError(
            f"Open3D needs libusb-1.0 and the package libusb-package does not give it ({error}). "
            "Run: pip install libusb-package"
        ) from error


def _loads(name: str) -> bool:
    try:
        ctypes.CDLL(name)
    except OSError:
        return False
    return True
