"""Writers: each receives every new frame of a render product; found by name."""

from .annotated import AnnotatedWriter
from .registry import (
    WRITERS,
    AttachedWriter,
    find_writer,
    get,
    register_writer_spec,
    unregister_writer_spec,
    writer_specs,
)
from .spec import REGISTRY, Writer, WriterSpec

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
