"""Pictures to a film's file: H.264, VP9, or a folder of PNGs; no larger than it may be.

A film is encoded at a constant quality first. Where it may not be larger than so many bytes, its
frames are kept beside it without loss; if it is larger, they are encoded again at the bit rate
that the limit allows, as often as it takes. H.264 has notes from the first time by then of what
each frame needs.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from itertools import islice
from pathlib import Path

import av
import numpy as np
from av.codec.context import Flags
from av.video.frame import PictureType
from av.video.reformatter import ColorPrimaries, ColorRange, Colorspace, ColorTrc, VideoReformatter
from PIL import Image

from followspot.errors import UsageError
from followspot.present.frames import Picture

AIM = 0.97
"""Share of the bytes allowed that a bit rate aims at."""

ATTEMPTS = 6
"""Bit rates that are tried before the lowest qualities are."""

LEAST_BIT_RATE = 1000
LEAST_SHARE = 0.04
"""Of the size at full quality: notes from that are of use down to here."""


@dataclass(frozen=True)
class Codec:
    """How frames are encoded; options as the FFmpeg libraries name them.

    Attributes:
        name: Of the encoder.
        options: For every film.
        good: For the quality of a film that may have any size.
        worst: Lowest qualities, each smaller than the one before; the last is for the smallest film
            that there can be.
        takes_notes: Whether it can write notes of what each frame needs, and use them.
    """

    name: str
    options: Mapping[str, str]
    good: Mapping[str, str]
    worst: tuple[Mapping[str, str], ...]
    takes_notes: bool = False


H264 = Codec(
    "libx264",
    # No B-frames: with them, x264's look ahead (mbtree) reads memory that it has not written, and
    # the same frames do not make the same film. They would save two bytes in a hundred.
    {"preset": "medium", "profile": "high", "fastfirstpass": "0", "bf": "0"},
    # A third of the time of the preset's own search, for a tenth of a decibel.
    good={"crf": "20", "refs": "1", "me_method": "dia", "subq": "2", "trellis": "0"},
    # Where H.264's scale ends, and where x264's own does, which goes on (its QP_MAX).
    worst=({"crf": "51", "qmin": "51"}, {"crf": "51", "qmin": "69", "qmax": "69"}),
    takes_notes=True,
)
VP9 = Codec(
    "libvpx-vp9",
    {"deadline": "good", "cpu-used": "4", "row-mt": "1"},
    good={"crf": "30", "b": "0"},
    worst=({"crf": "63", "b": "0", "qmin": "63", "qmax": "63"},),
)
KEPT = Codec("libx264", {"preset": "ultrafast"}, good={"qp": "0"}, worst=())
CODECS = {".mp4": H264, ".webm": VP9}


@dataclass(frozen=True)
class Shape:
    """What is the same of all of a film's frames: (width, height), and how many a second."""

    size: tuple[int, int]
    fps: Fraction


@dataclass(frozen=True)
class Written:
    """A film's file.

    Attributes:
        frames: How many it holds.
        bytes: Its size.
        wanted_bytes: The size that it had before its quality was lowered, if it was.
    """

    frames: int
    bytes: int
    wanted_bytes: int


def can_hold(size: tuple[int, int]) -> bool:
    """Whether FFmpeg's libraries take frames of that size (their ``av_image_check_size2``)."""
    return (size[0] + 128) * (size[1] + 128) < 2**31 / 8


class _Encoder:
    """One file being made from frames in yuv420p."""

    def __init__(
        self,
        path: Path,
        shape: Shape,
        codec: Codec,
        options: Mapping[str, str],
        notes_flag: Flags | None = None,
    ) -> None:
        faststart = {"movflags": "+faststart"} if path.suffix.lower() == ".mp4" else {}
        self._container = av.open(str(path), "w", options=faststart)
        options = {**codec.options, **options}
        if codec.takes_notes and notes_flag:
            options["stats"] = str(path.with_name("notes"))
        stream = self._container.add_stream(codec.name, rate=shape.fps, options=options)
        assert isinstance(stream, av.VideoStream)
        stream.width, stream.height = shape.size
        stream.pix_fmt = "yuv420p"
        context = stream.codec_context
        context.thread_count = 0  # as many as suit the machine
        if codec.takes_notes and notes_flag:
            context.flags |= notes_flag
        context.color_range = ColorRange.MPEG
        context.colorspace = Colorspace.ITU709
        context.color_primaries = ColorPrimaries.BT709
        context.color_trc = ColorTrc.BT709
        self._stream, self._time_base = stream, 1 / shape.fps
        self.count = 0

    def add(self, frame: av.VideoFrame) -> None:
        frame.pts, frame.time_base = self.count, self._time_base
        frame.pict_type = PictureType.NONE  # a decoded frame asks to be what it was
        self._container.mux(self._stream.encode(frame))
        self.count += 1

    def close(self) -> None:
        if self.count:
            self._container.mux(self._stream.encode(None))
        self._container.close()
        del self._stream, self._container  # the notes are there when the codec has gone


def write_video(
    path: Path,
    pictures: Iterable[Picture],
    shape: Shape,
    max_bytes: int | None,
    stopped: Callable[[], bool],
    on_attempt: Callable[[int], object] = lambda _: None,
) -> Written:
    """Encode a film.

    Args:
        path: Gets the film; its ending chooses the format. Other files may lie beside it later.
        pictures: One a frame; as many as come.
        shape: Of even width and height.
        max_bytes: What the file may have at most.
        stopped: Whether to leave it at the frames done so far, when it is encoded again.
        on_attempt: Told how many bytes are too many, whenever it is encoded again.

    Returns:
        What was written; the file means nothing if there was no picture.

    Raises:
        UsageError: even the lowest quality is larger than allowed.
    """
    codec, kept = CODECS[path.suffix.lower()], path.with_name("kept.mkv")
    encoders = [_Encoder(path, shape, codec, codec.good, Flags.pass1 if max_bytes else None)]
    if max_bytes:
        encoders.append(_Encoder(kept, shape, KEPT, KEPT.good))
    for frame in _converted(pictures):
        for encoder in encoders:
            encoder.add(frame)
    for encoder in encoders:
        encoder.close()
    count = encoders[0].count
    size = wanted = smallest = path.stat().st_size if count else 0
    aim = AIM * (max_bytes or 0)
    for attempt in range(ATTEMPTS + len(codec.worst)):
        if not max_bytes or size <= max_bytes:
            break
        on_attempt(size)
        rate = {"b": str(max(LEAST_BIT_RATE, int(aim * 8 * shape.fps / count)))}
        # Notes help to use what is allowed, but x264 refuses to follow them far below their rate.
        follow = Flags.pass2 if aim > wanted * LEAST_SHARE else None
        options = rate if attempt < ATTEMPTS else codec.worst[attempt - ATTEMPTS]
        encoder = _Encoder(path, shape, codec, options, follow if options is rate else None)
        for frame in islice(_decoded(kept), count):
            encoder.add(frame)
            if stopped():
                break
        encoder.close()
        count, size = encoder.count, path.stat().st_size
        smallest = min(smallest, size)
        aim *= AIM * (max_bytes / size) ** 1.5  # the hardest films hardly heed a bit rate
    if max_bytes and size > max_bytes:
        raise UsageError(
            f"--max-bytes: {count} frames of {shape.size[0]}x{shape.size[1]} take "
            f"{smallest:,} bytes even at the lowest quality, and {max_bytes:,} are allowed"
        )
    return Written(count, size, wanted)


def _converted(pictures: Iterable[Picture]) -> Iterator[av.VideoFrame]:
    """Pictures as frames in yuv420p by BT.709, studio range."""
    reformatter = VideoReformatter()
    for picture in pictures:
        yield reformatter.reformat(
            av.VideoFrame.from_ndarray(np.ascontiguousarray(picture), format="rgb24"),
            format="yuv420p",
            src_color_range=ColorRange.JPEG,
            dst_color_range=ColorRange.MPEG,
            dst_colorspace=Colorspace.ITU709,
        )


def _decoded(path: Path) -> Iterator[av.VideoFrame]:
    with av.open(str(path)) as container:
        container.streams.video[0].thread_type = "AUTO"
        yield from container.decode(video=0)


def write_folder(folder: Path, pictures: Iterable[Picture]) -> Written:
    """Write frame-00000.png and so on into a new folder."""
    folder.mkdir()
    count = size = 0
    for picture in pictures:
        file = folder / f"frame-{count:05}.png"
        Image.fromarray(picture).save(file, compress_level=3)
        count, size = count + 1, size + file.stat().st_size
    return Written(count, size, size)
