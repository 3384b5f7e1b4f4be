"""Render variables: the images of a render product by the names of the renderer."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from graph.base.records import dataclass
from graph.base.suggest import did_you_mean
from graph.node import Attribute, Database, node_type

from .frames import CUDA_STREAM, EXEC, RESULTS_IN, product_of_handle

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from sensors.annotators.annotator import Annotator

VARIABLES: Mapping[str, str] = {
    "LdrColor": "LdrColor",
    "HdrColor": "HdrColor",
    "DistanceToCamera": "distance_to_camera",
    "DistanceToImagePlane": "distance_to_image_plane",
    "Normal": "normals",
    "TargetMotion": "motion_vectors",
    "InstanceSegmentation": "instance_id_segmentation",
    "SemanticSegmentation": "semantic_segmentation",
    "GenericModelOutput": "GenericModelOutput",
    "StableIdMap": "StableIdMap",
}
"""Render variable, without the suffixes of its copies -> annotator with the same data."""

SUFFIXES = ("host", "buffer", "buff", "SD")
"""What copies of a render variable are called: in host memory, in a buffer, of synthetic data."""

FORMATS: Mapping[tuple[str, int], int] = {
    ("|u1", 4): 11,
    ("<f2", 4): 30,
    ("<u4", 1): 31,
    ("<f4", 1): 33,
    ("<f4", 4): 42,
}
"""Type and numbers of a pixel -> texture format (RGBA8_UNORM, RGBA16_SFLOAT, R32_UINT, R32_SFLOAT, RGBA32_SFLOAT)."""

RENDER_VAR = Attribute("token", "name of the render variable", default="")
SIZES = {
    "bufferSize": Attribute("uint64", "size of the data", unit="bytes"),
    "exec": Attribute("execution", "follows when there is data"),
    "format": Attribute("uint64", "texture format of an image, such as 11 for four bytes a pixel; 0 for a buffer"),
    "height": Attribute("uint", "rows of an image; 0 for a buffer", unit="px"),
    "strides": Attribute("int[2]", "from pixel to pixel and from row to row; 0, 0 for a buffer", unit="bytes"),
    "width": Attribute("uint", "pixels in a row; 0 for a buffer", unit="px"),
}


@dataclass(slots=True)
class _Reader:
    """The annotator that reads the variable, and the last handle."""

    annotator: Annotator | None = None
    handle: int = 0


def _release(db: Database) -> None:
    from sensors.handles import forget

    forget(db.memory.handle)
    if db.memory.annotator is not None:
        db.memory.annotator.detach()
    db.memory.annotator, db.memory.handle = None, 0


@node_type(
    "omni.syntheticdata.SdRenderVarPtr",
    version=2,
    inputs={"exec": EXEC, "renderResults": RESULTS_IN, "renderVar": RENDER_VAR},
    outputs={
        "cudaDeviceIndex": Attribute("int", "always -1: the data is in host memory", default=-1),
        "dataPtr": Attribute("uint64", "handle of the data", default=0),
        **SIZES,
    },
    memory=_Reader,
    release=_release,
)
def render_var_ptr(db: Database) -> bool:
    """Give a render variable of a product's newest frame as a handle; it is rendered while something reads it."""
    from sensors.handles import forget, handle

    array = _read(db)
    if array is None:
        return False
    forget(db.memory.handle)
    db.memory.handle = handle(array)
    db.outputs.dataPtr, db.outputs.cudaDeviceIndex = db.memory.handle, -1
    db.fire("exec")
    return True


@node_type(
    "omni.syntheticdata.SdRenderVarToRawArray",
    version=2,
    inputs={
        "cudaStream": Attribute("uint64", "without effect: the data is in host memory", default=0),
        "exec": EXEC,
        "renderResults": RESULTS_IN,
        "renderVar": RENDER_VAR,
    },
    outputs={
        "cudaStream": CUDA_STREAM,
        "data": Attribute("uchar[]", "the bytes of the render variable", default=[]),
        **SIZES,
    },
    memory=_Reader,
    release=_release,
)
def render_var_to_raw_array(db: Database) -> bool:
    """Give a render variable of a product's newest frame as bytes; it is rendered while something reads it."""
    import numpy as np

    array = _read(db)
    if array is None:
        return False
    db.outputs.data = array.reshape(-1).view(np.uint8)
    db.fire("exec")
    return True


def _read(db: Database) -> NDArray[Any] | None:
    """The variable of the newest frame, its sizes put on the outputs; None before it is rendered."""
    import numpy as np

    if not db.is_read():
        _release(db)
        return None
    annotator = _annotator(db)
    if annotator is None:
        return None
    found = annotator.get_data()
    data = found["data"] if isinstance(found, dict) else found
    if data is None or not data.size:
        return None
    array = np.ascontiguousarray(data)
    outputs = db.outputs
    outputs.bufferSize = array.nbytes
    outputs.height, outputs.width = array.shape[:2] if array.ndim > 1 else (0, 0)
    across = array.itemsize * (array.shape[2] if array.ndim > 2 else 1)
    outputs.strides = [across, across * array.shape[1]] if array.ndim > 1 else [0, 0]
    outputs.format = FORMATS.get((array.dtype.str, array.shape[2] if array.ndim > 2 else 1), 0) * (array.ndim > 1)
    return array


def _annotator(db: Database) -> Annotator | None:
    """The node's annotator on the product of renderResults. Fails the node for an unknown variable or sensor."""
    from graph.base.errors import UserError
    from sensors.annotators.annotator import Annotator
    from sensors.annotators.registry import find_annotator

    product, memory, name = product_of_handle(db), db.memory, variable(db.inputs.renderVar)
    if product is None:
        return None
    if name not in VARIABLES:
        known = did_you_mean(name, VARIABLES, f"there are {', '.join(VARIABLES)}")
        db.fail(f'input renderVar is "{db.inputs.renderVar}", which is not rendered here{known}')
    annotator: Annotator | None = memory.annotator
    if annotator is None or annotator.product is not product or annotator.name != VARIABLES[name]:
        _release(db)
        annotator = Annotator(find_annotator(VARIABLES[name]), app=db.app, owner=db.path, copies=False)
        try:
            memory.annotator = annotator.attach(product)
        except UserError as error:
            db.fail(str(error))
    return annotator


def variable(name: str) -> str:
    """A render variable's name without the suffixes of its copies: LdrColorSDhost is a copy of LdrColor."""
    for suffix in SUFFIXES:
        name = name.removesuffix(suffix)
    return name


COPIED = {
    "exec": Attribute("execution", "follows every compute"),
    "renderVar": Attribute("token", "name of the copy"),
}
NO_ADDRESS = "without effect: there are no addresses here"


def _suffix(default: str) -> Attribute:
    return Attribute("string", "put behind the name", default=default)


@node_type(
    "omni.syntheticdata.SdPostRenderVarToHost",
    version=1,
    inputs={
        "exec": EXEC,
        "gpu": Attribute("uint64", NO_ADDRESS, default=0),
        "renderVar": RENDER_VAR,
        "renderVarHostSuffix": _suffix("host"),
        "rp": Attribute("uint64", NO_ADDRESS, default=0),
    },
    outputs=COPIED,
)
def render_var_to_host(db: Database) -> None:
    """Name the copy of a render variable in host memory, where all data is already."""
    db.outputs.renderVar = db.inputs.renderVar + db.inputs.renderVarHostSuffix
    db.fire("exec")


@node_type(
    "omni.syntheticdata.SdPostRenderVarTextureToBuffer",
    version=1,
    inputs={
        "cudaCopyNoStride": Attribute("bool", "without effect: rows follow each other without gaps", default=True),
        "exec": EXEC,
        "gpu": Attribute("uint64", NO_ADDRESS, default=0),
        "renderVar": RENDER_VAR,
        "renderVarBufferSuffix": _suffix("buffer"),
        "rp": Attribute("uint64", NO_ADDRESS, default=0),
    },
    outputs=COPIED,
)
def render_var_to_buffer(db: Database) -> None:
    """Name the copy of a render variable in a buffer, where all data is already."""
    db.outputs.renderVar = db.inputs.renderVar + db.inputs.renderVarBufferSuffix
    db.fire("exec")
