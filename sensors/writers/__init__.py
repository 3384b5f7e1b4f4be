"""Writers: each receives every new frame of a render product; found by name."""

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
