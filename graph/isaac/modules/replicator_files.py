"""Folders that writers of scripts write into: `backends` and `BackendDispatch` of `omni.replicator.core`."""

from __future__ import annotations

import inspect
import io
import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from graph.base import inputs, outputs
from graph.isaac.outcomes import UnsupportedError

__all__ = ["BackendDispatch", "BaseBackend", "DiskBackend", "backends", "write_image", "write_json", "write_np"]


class DiskBackend:
    """A folder. `schedule(functional.write_image, path="a.png", data=rgb)` writes a file of it at once."""

    def __init__(self, output_dir: str | Mapping[str, Any] | None = None, **_: Any) -> None:
        if isinstance(output_dir, Mapping):  # of former versions: {"paths": {"out_dir": ...}}
            output_dir = output_dir.get("paths", {}).get("out_dir")
        self.output_dir = str(output_dir or "")

    def initialize(self, output_dir: str, **_: Any) -> DiskBackend:
        self.output_dir = str(output_dir)
        return self

    def resolve_path(self, path: str) -> str:
        return str(Path(self.output_dir, path))

    def schedule(self, fn: Callable[..., Any], *args: Any, **kwargs: Any) -> None:
        if "backend_instance" in inspect.signature(fn).parameters:
            kwargs.setdefault("backend_instance", self)
        fn(*args, **kwargs)

    def write_blob(self, path: str, data: Any, **_: Any) -> None:
        """Writes bytes or text; makes the folders above the file. Raises OSError."""
        file = Path(self.output_dir, path)
        outputs.make_folder(file.parent)
        outputs.write(file, data if isinstance(data, (bytes, str)) else bytes(data))

    def read_blob(self, path: str) -> bytes:
        with inputs.opened(Path(self.output_dir, path)) as file:
            return file.read()

    def write_image(self, path: str, data: Any, **_: Any) -> None:
        write_image(path, data, self)

    def write_array(self, path: str, data: Any, **_: Any) -> None:
        write_np(path, data, self)

    @staticmethod
    def wait_until_done() -> None:
        """Returns at once: files are written when they are asked for."""


BackendDispatch = BaseBackend = DiskBackend


class Backends:
    """`backends.get("DiskBackend")`."""

    DiskBackend = BaseBackend = BackendDispatch = DiskBackend

    @staticmethod
    def get(name: str = "DiskBackend", init_params: Mapping[str, Any] | None = None) -> Any:
        if name not in ("DiskBackend", "BackendDispatch"):
            raise UnsupportedError(f"omni.replicator.core.backends: {name}: files go to local folders; use DiskBackend")
        return DiskBackend(**(init_params or {}))


backends = Backends


def write_image(path: str, data: Any, backend_instance: Any = None, **_: Any) -> None:
    """Writes (height, width[, 3 or 4]) pixels; the ending names the format. Floats from 0 to 1 become 8 bit."""
    from PIL import Image

    image = np.asarray(data.numpy() if hasattr(data, "numpy") else data)
    if image.dtype.kind == "f":
        image = np.rint(np.clip(np.nan_to_num(image), 0, 1) * 255).astype(np.uint8)
    elif image.dtype != np.uint8:
        image = image.astype(np.uint16)
    ending = Path(path).suffix.lower().removeprefix(".") or "png"
    if ending in ("jpg", "jpeg"):
        image, ending = image[..., :3], "jpeg"
    stream = io.BytesIO()
    Image.fromarray(np.ascontiguousarray(image)).save(stream, format=ending.upper())
    (backend_instance or DiskBackend()).write_blob(path, stream.getvalue())


def write_json(path: str, data: Any, backend_instance: Any = None, indent: int | None = None, **_: Any) -> None:
    text = json.dumps(data, indent=indent, default=lambda value: np.asarray(value).tolist())
    (backend_instance or DiskBackend()).write_blob(path, text)


def write_np(path: str, data: Any, backend_instance: Any = None, **_: Any) -> None:
    stream = io.BytesIO()
    np.save(stream, np.asarray(data.numpy() if hasattr(data, "numpy") else data), allow_pickle=False)
    (backend_instance or DiskBackend()).write_blob(path, stream.getvalue())
