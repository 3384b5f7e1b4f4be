"""Writers: what takes each new frame of a render product, by name."""

from .annotated import AnnotatedWriter
from .registry import (
    REGISTRY,
    WRITERS,
    AttachedWriter,
    Writer,
    WriterSpec,
    find_writer,
    get,
    register_writer_spec,
    unregister_writer_spec,
    writer_specs,
)

__all__ = [
    "REGISTRY",
    "WRITERS",
    "AnnotatedWriter",
    "AttachedWriter",
    "Writer",
    "WriterSpec",
    "find_writer",
    "get",
    "register_writer_spec",
    "unregister_writer_spec",
    "writer_specs",
]
