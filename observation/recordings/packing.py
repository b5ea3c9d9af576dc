"""Unpacks what recorders packed by zstd or LZ4, in pieces, from a limited number of frames.

Packed content may be any number of frames, one after the other, and a frame without content has nine bytes:
20 MB of them take minutes. Recorders write one frame for a file, a chunk or a message.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, BinaryIO

FRAMES = 16
"""Frames that any packed content may have; a large one may have one for each KiB."""

_READ = 1 << 16
_MADE = 1 << 20


def pieces(packed: BinaryIO, kind: str, size: int) -> Iterator[bytes]:
    """Yield unpacked content, a MiB at a time at most.

    Parameters
    ----------
    packed : BinaryIO
        The packed content.
    kind : {"zstd", "lz4"}
        How it is packed.
    size : int
        Its size in bytes.

    Raises
    ------
    ValueError
        It has more frames than recorders write.
    EOFError
        It ends within a frame. Errors of the library pass.
    """
    most, frames, data = FRAMES + (size >> 10), 0, b""
    frame: Any = None
    while True:
        if not data and (frame is None or frame.needs_input):
            data = packed.read(_READ)
            if not data:
                if frame is not None:
                    raise EOFError(f"content packed by {kind} ends too early")
                return
        if frame is None:
            frame, frames = _frame(kind), frames + 1
            if frames > most:
                raise ValueError(f"packed by {kind} in more than {most:,} frames; recorders write one")
        piece, data = frame.decompress(data, _MADE), b""
        if piece:
            yield piece
        if frame.eof:
            frame, data = None, frame.unused_data or b""


def _frame(kind: str) -> Any:
    if kind == "lz4":
        from lz4.frame import LZ4FrameDecompressor  # type: ignore[import-untyped]

        return LZ4FrameDecompressor()
    from backports.zstd import ZstdDecompressor

    return ZstdDecompressor()
