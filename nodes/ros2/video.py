"""Pictures as H.264 video, one access unit for each message, encoded by x264 in FFmpeg (package `av`)."""

from __future__ import annotations

from fractions import Fraction
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

from graph.base.extras import install_command

if TYPE_CHECKING:
    from .camera_messages import Reading

FORMAT = "h264"
KEY_EVERY = 30
"""Frames from one that can be decoded alone to the next."""

OPTIONS = {
    "preset": "veryfast",
    "tune": "zerolatency",
    "crf": "18",
    "threads": "1",
    "x264-params": "repeat-headers=1:annexb=1:sliced-threads=0",
}
"""No frame waits for a later one, each key frame carries the headers, and one thread makes the bytes repeatable."""


def no_encoder() -> str:
    """What to do without the encoder."""
    return f"type rgb_h264 needs the package av; use type rgb, or run: {install_command('video')}"


def has_encoder() -> bool:
    """Whether the encoder is installed."""
    return find_spec("av") is not None


class H264:
    """Encodes the pictures of one camera, in their order: reading -> `sensor_msgs/CompressedImage` (Annex B)."""

    def __init__(self) -> None:
        self._codec: Any = None
        self._count = 0

    def __call__(self, reading: Reading) -> Any:
        """The message of the next picture."""
        import av
        import numpy as np

        from .image_messages import compressed_image

        picture = np.ascontiguousarray(reading.found[:, :, :3])
        frame = av.VideoFrame.from_ndarray(picture, format="rgb24").reformat(format="yuv420p")
        frame.pts, frame.time_base = self._count, Fraction(1, KEY_EVERY)
        if self._codec is None:
            self._codec = _codec(frame.width, frame.height)
        self._count += 1
        data = b"".join(bytes(packet) for packet in self._codec.encode(frame))
        return compressed_image(reading.nanoseconds, reading.frame_id, FORMAT, data)


def _codec(width: int, height: int) -> Any:
    import av

    codec: Any = av.CodecContext.create("libx264", "w")
    codec.width, codec.height, codec.pix_fmt = width, height, "yuv420p"
    codec.time_base, codec.gop_size, codec.max_b_frames = Fraction(1, KEY_EVERY), KEY_EVERY, 0
    codec.options = dict(OPTIONS)
    return codec
