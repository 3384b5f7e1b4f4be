"""Writers: each receives every new frame of a render product; found by name."""

from .annotated import AnnotatedWriter as AnnotatedWriter
from .registry import WRITERS as WRITERS
from .registry import AttachedWriter as AttachedWriter
from .registry import find_writer as find_writer
from .registry import get as get
from .registry import register_writer_spec as register_writer_spec
from .registry import unregister_writer_spec as unregister_writer_spec
from .registry import writer_specs as writer_specs
from .spec import REGISTRY as REGISTRY
from .spec import Writer as Writer
from .spec import WriterSpec as WriterSpec
