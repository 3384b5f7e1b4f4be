"""Images as the raw lines of a VB1940 sensor: 10 bit Bayer samples, packed as its two data planes carry them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from graph.node import Attribute, Database, node_type
from nodes.ros2.image_messages import PIXEL_BYTES
from nodes.ros2.images import pixels

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

COE, LINUX = "vb1940_csi_coe", "vb1940_csi_linux"
MODES = (COE, LINUX)
BLANK_ABOVE, BLANK_BELOW = 1, 2
"""Lines of zeros around the image."""


def bayer(colours: NDArray[np.uint8]) -> NDArray[np.uint16]:
    """(height, width) samples of 10 bit of colours (height, width, 3 or 4), in the pattern green blue / red green.

    A sample is 1023 / 255 of the colour that its place in the pattern measures, rounded half to even.
    """
    import numpy as np

    found = np.empty(colours.shape[:2], np.uint8)
    for row, column, colour in ((0, 0, 1), (0, 1, 2), (1, 0, 0), (1, 1, 1)):
        found[row::2, column::2] = colours[row::2, column::2, colour]
    samples: NDArray[np.uint16] = np.rint(found * (1023 / 255)).astype(np.uint16)
    return samples


def packed(samples: NDArray[np.uint16], mode: str) -> NDArray[np.uint8]:
    """The bytes of a frame of samples (height, width) of 10 bit: a blank line, the image, two blank lines.

    vb1940_csi_linux: four samples in five bytes, their upper 8 bits and then the lower 2 of all (MIPI RAW10), lines of
    a multiple of 8 bytes. vb1940_csi_coe: three samples in a little-endian word of 32 bits, lines of a multiple of 64.
    """
    import numpy as np

    height, width = samples.shape
    group, align = (4, 8) if mode == LINUX else (3, 64)
    groups = -(-width // group)
    padded = np.zeros((height, groups * group), np.uint16)
    padded[:, :width] = samples
    parts = padded.reshape(height, groups, group)
    if mode == LINUX:
        line = np.empty((height, groups, 5), np.uint8)
        line[..., :4] = parts >> 2
        line[..., 4] = ((parts & 3) << np.arange(0, 8, 2, dtype=np.uint16)).sum(axis=-1)
    else:
        words = (parts.astype(np.uint32) << np.arange(0, 30, 10, dtype=np.uint32)).sum(axis=-1, dtype=np.uint32)
        line = words.astype("<u4").view(np.uint8).reshape(height, groups, 4)
    length = line.shape[1] * line.shape[2]
    frame = np.zeros((height + BLANK_ABOVE + BLANK_BELOW, -(-length // align) * align), np.uint8)
    frame[BLANK_ABOVE : BLANK_ABOVE + height, :length] = line.reshape(height, length)
    return frame.reshape(-1)


@node_type(
    "isaacsim.hsb.nodes.RGBToVB1940",
    version=1,
    inputs={
        "execIn": Attribute("execution", "converts the image"),
        "data": Attribute("uchar[]", "pixels, rows from the top", default=[], optional=True),
        "width": Attribute("uint", "pixels in a row", default=0, unit="px"),
        "height": Attribute("uint", "rows of pixels", default=0, unit="px"),
        "encoding": Attribute("token", "what a pixel is", default="rgb8", allowed_tokens=("rgb8", "rgba8")),
        "outputMode": Attribute("token", "data plane that carries it", default=LINUX, allowed_tokens=MODES),
        "dataPtr": Attribute("uint64", "handle of the pixels; 0 takes data", default=0),
        "cudaDeviceIndex": Attribute("int", "must stay -1: pixels are in host memory", default=-1),
        "bufferSize": Attribute("uint", "size of dataPtr; not needed, the handle knows", default=0, unit="bytes"),
    },
    outputs={
        "execOut": Attribute("execution", "follows every image"),
        "data": Attribute("uchar[]", "the frame's bytes", default=[]),
    },
)
def rgb_to_vb1940(db: Database) -> bool:
    """Turn a colour image into the raw bytes of a VB1940: Bayer samples of 10 bit between blank lines."""
    inputs = db.inputs
    data, mode = pixels(db), inputs.outputMode
    if not data.size:
        return False
    if mode not in MODES or inputs.encoding not in ("rgb8", "rgba8"):
        db.fail(f'"{inputs.encoding}" to "{mode}": use rgb8 or rgba8, and one of {", ".join(MODES)}')
    wide = PIXEL_BYTES[inputs.encoding]
    expected = inputs.width * inputs.height * wide
    if data.size != expected:
        db.fail(
            f"{inputs.width} x {inputs.height} pixels of {inputs.encoding} are {expected} bytes, but there are "
            f"{data.size}; correct width, height or encoding"
        )
    db.outputs.data = frame_bytes(data.reshape(inputs.height, inputs.width, wide), mode)
    db.fire("execOut")
    return True


def frame_bytes(colours: Any, mode: str) -> NDArray[np.uint8]:
    """The bytes of a frame of colours (height, width, 3 or 4) uint8."""
    return packed(bayer(colours), mode)
