"""Images: plain colours for tests, and conversions of buffers given by handles."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from graph.base.records import dataclass
from graph.node import UNSET, Attribute, Database, node_type

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

LARGEST = 2**28
"""Most pixels of a generated image."""

CUDA_IN = Attribute("int", "must stay -1: buffers are in host memory", default=-1)
CUDA_OUT = Attribute("int", "always -1: the buffer is in host memory", default=-1)
EXEC_OUT = Attribute("execution", "follows every image")


def _pixels(doc: str, default: Any = UNSET) -> Attribute:
    return Attribute("uint", doc, default=default, unit="px")


@dataclass(slots=True)
class Given:
    """Memory of a node that outputs buffers: the last handle."""

    handle: int = 0


def release(db: Database) -> None:
    """Releases the node's handle."""
    from sensors.handles import forget

    forget(db.memory.handle)
    db.memory.handle = 0


def give(db: Database, buffer: NDArray[Any]) -> int:
    """A handle of a new buffer; releases the node's previous one."""
    from sensors.handles import handle

    release(db)
    db.memory.handle = handle(buffer)
    number: int = db.memory.handle
    return number


def buffer_of(db: Database, dtype: str, width: int, height: int, channels: int) -> NDArray[Any]:
    """(height, width, channels) of the buffer of dataPtr.

    Fails the node if the buffer is missing or has another size.
    """
    import numpy as np

    from sensors.handles import resolve

    inputs = db.inputs
    if inputs.cudaDeviceIndex != -1:
        db.fail(f"input cudaDeviceIndex is {inputs.cudaDeviceIndex}; buffers are in host memory, leave it at -1")
    found = resolve(inputs.dataPtr)
    if not isinstance(found, np.ndarray):
        db.lack("input dataPtr is not a handle of a buffer; connect it to what makes one")
    flat = np.ascontiguousarray(found).reshape(-1).view(np.uint8)
    wanted = width * height * channels * np.dtype(dtype).itemsize
    if flat.size != wanted:
        db.fail(f"the buffer has {flat.size} bytes; an image of {width} x {height} pixels has {wanted}")
    return flat.view(dtype).reshape(height, width, channels)


def given(db: Database) -> bool:
    """Whether dataPtr refers to an image; 0 means that its source has no image yet. Warns if no source is connected."""
    if db.inputs.dataPtr:
        return True
    if not db.connected("dataPtr"):
        db.warn("image-missing", "input dataPtr is 0, so nothing is converted; connect it to what makes an image")
    return False


def _size(db: Database) -> tuple[int, int]:
    """Width and height of an image that a node makes, 4 bytes a pixel."""
    width, height = db.inputs.width, db.inputs.height
    if width * height > LARGEST:
        db.fail(f"{width} x {height} pixels are too many; {LARGEST} fit")
    db.claim(width * height * 4)
    return width, height


def _write(db: Database, data: NDArray[np.uint8], size: tuple[int, int], encoding: str) -> None:
    outputs = db.outputs
    outputs.data, outputs.encoding = data.reshape(-1), encoding
    outputs.width, outputs.height = size


GENERATED = {
    "width": _pixels("width of the image"),
    "height": _pixels("height of the image"),
    "encoding": Attribute("token", "the pixels' encoding"),
}


@node_type(
    "isaacsim.core.nodes.IsaacGenerateRGBA",
    version=1,
    inputs={
        "color": Attribute("colorf[4]", "red, green, blue, alpha from 0 to 1"),
        "width": _pixels("width of the image", 100),
        "height": _pixels("height of the image", 100),
    },
    outputs={"data": Attribute("uchar[]", "the image, row by row, 4 bytes a pixel", default=[]), **GENERATED},
)
def generate_rgba(db: Database) -> None:
    """Make an image of one colour, encoding rgba8; each component is cut down to a whole number of 255ths; NaN is 0."""
    import numpy as np

    width, height = _size(db)
    pixel = (np.nan_to_num(np.clip(db.inputs.color, 0, 1)) * 255).astype(np.uint8)
    _write(db, np.tile(pixel, width * height), (width, height), "rgba8")


@node_type(
    "isaacsim.core.nodes.IsaacGenerate32FC1",
    version=1,
    inputs={
        "value": Attribute("float", "the value of every pixel"),
        "width": _pixels("width of the image", 100),
        "height": _pixels("height of the image", 100),
    },
    outputs={"data": Attribute("uchar[]", "the image, row by row, a float32 a pixel", default=[]), **GENERATED},
)
def generate_32fc1(db: Database) -> None:
    """Make an image of one float32 value, encoding 32FC1."""
    import numpy as np

    width, height = _size(db)
    _write(db, np.full(width * height, db.inputs.value, np.float32).view(np.uint8), (width, height), "32FC1")


@node_type(
    "isaacsim.core.nodes.IsaacConvertRGBAToRGB",
    version=1,
    inputs={
        "execIn": Attribute("execution", "converts the image"),
        "dataPtr": Attribute("uint64", "handle of the image, 4 bytes a pixel", default=0),
        "cudaDeviceIndex": CUDA_IN,
        "width": _pixels("width of the image"),
        "height": _pixels("height of the image"),
        "encoding": Attribute("token", "encoding of the image; only rgba8 can be converted", default="rgba8"),
        "bufferSize": Attribute("uint", "size of the image", unit="bytes"),
        "format": Attribute("uint64", "texture format; not used"),
    },
    outputs={
        "execOut": EXEC_OUT,
        "dataPtr": Attribute("uint64", "handle of the image, 3 bytes a pixel", default=0),
        "cudaDeviceIndex": CUDA_OUT,
        "encoding": Attribute("token", "encoding of the image, rgb8"),
        "width": _pixels("width of the image"),
        "height": _pixels("height of the image"),
        "bufferSize": Attribute("uint", "size of the image", unit="bytes"),
    },
    memory=Given,
    release=release,
)
def convert_rgba_to_rgb(db: Database) -> bool:
    """Drop the alpha channel."""
    import numpy as np

    if not given(db):
        return False
    inputs, outputs = db.inputs, db.outputs
    if inputs.encoding != "rgba8":
        db.fail(f'input encoding is "{inputs.encoding}"; only rgba8 can be converted')
    image = np.ascontiguousarray(buffer_of(db, "u1", inputs.width, inputs.height, 4)[:, :, :3])
    outputs.dataPtr, outputs.bufferSize, outputs.encoding = give(db, image), image.nbytes, "rgb8"
    outputs.width, outputs.height, outputs.cudaDeviceIndex = inputs.width, inputs.height, -1
    db.fire("execOut")
    return True


_PASSED = {
    "dataPtr": Attribute("uint64", "handle of the image"),
    "cudaDeviceIndex": Attribute("int", "device of the image; -1 is host memory", default=-1),
    "width": _pixels("width of the image"),
    "height": _pixels("height of the image"),
    "bufferSize": Attribute("uint", "size of the image", unit="bytes"),
    "format": Attribute("uint64", "texture format"),
}


@node_type(
    "isaacsim.core.nodes.IsaacPassthroughImagePtr",
    version=1,
    inputs={"execIn": Attribute("execution", "passes the image on"), **_PASSED},
    outputs={"execOut": EXEC_OUT, **_PASSED},
)
def passthrough_image_ptr(db: Database) -> None:
    """Pass an image on unchanged."""
    for name in _PASSED:
        setattr(db.outputs, name, getattr(db.inputs, name))
    db.fire("execOut")
