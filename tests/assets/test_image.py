"""Images: hand-written files decoded pixel by pixel, damage, colour spaces, threads."""

import io
import struct
import threading
import zlib
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image as PillowImage

from followspot.assets.archive import Archive
from followspot.assets.image import (
    IMAGE_SUFFIXES,
    MAX_SIDE,
    Image,
    decode,
    decode_all,
    find_image,
    linear_to_srgb,
    srgb_to_linear,
    to_linear,
)
from followspot.errors import AssetError

OPENARENA = Path("/usr/share/games/openarena/baseoa")

RED, GREEN, BLUE, WHITE = (255, 0, 0, 255), (0, 255, 0, 255), (0, 0, 255, 255), (255,) * 4

# Each: id length, map type, image type; map; x, y; width, height; depth, descriptor; pixels.
TGA_24_BOTTOM_LEFT = bytes.fromhex(
    "00 00 02  00 00 00 00 00  00 00 00 00  02 00 02 00  18 00"
    "FF 00 00  FF FF FF"  # bottom row: blue, white
    "00 00 FF  00 FF 00"  # top row: red, green
)
TGA_24_TOP_LEFT = bytes.fromhex(
    "00 00 02  00 00 00 00 00  00 00 00 00  02 00 02 00  18 2000 00 FF  00 FF 00FF 00 00  FF FF FF"
)
TGA_32_BOTTOM_LEFT = bytes.fromhex(
    "03 00 02  00 00 00 00 00  00 00 00 00  01 00 02 00  20 08"
    "69 64 21"  # the id, three letters long
    "01 02 03 80"
    "04 05 06 00"
)
TGA_32_RLE_TOP_LEFT = bytes.fromhex(
    "00 00 0A  00 00 00 00 00  00 00 00 00  03 00 02 00  20 28"
    "83 01 02 03 80"  # four times the same, on into the second row
    "01 04 05 06 FF  07 08 09 00"  # two that differ
)
TGA_24_RLE_BOTTOM_LEFT = bytes.fromhex(
    "00 00 0A  00 00 00 00 00  00 00 00 00  02 00 02 00  18 00"
    "81 FF 00 00"  # bottom row: blue twice
    "01 00 00 FF  00 FF 00"  # top row: red, green
)
TGA_GREY = bytes.fromhex("00 00 03  00 00 00 00 00  00 00 00 00  03 00 01 00  08 2000 80 FF")
TGA_PALETTE = bytes.fromhex(
    "00 01 01  00 00 02 00 18  00 00 00 00  03 00 01 00  08 20"
    "00 00 FF  FF 00 00"  # red, blue
    "01 00 01"
)
PNG_RGB = bytes.fromhex(
    "89 50 4E 47 0D 0A 1A 0A"
    "00 00 00 0D 49 48 44 52  00 00 00 02  00 00 00 01  08 02 00 00 00  7B 40 E8 DD"
    "00 00 00 12 49 44 41 54"
    "78 01  01 07 00 F8 FF  00 FF 00 00 00 FF 00  07 FF 01 FF  C5 0E E2 6A"
    "00 00 00 00 49 45 4E 44  AE 42 60 82"
)
PNG_ROWS_END = PNG_RGB.index(bytes.fromhex("07 FF 01 FF"))  # behind them a checksum and IEND

FIXTURES = {
    "tga 24 bottom left": (TGA_24_BOTTOM_LEFT, [[RED, GREEN], [BLUE, WHITE]]),
    "tga 24 top left": (TGA_24_TOP_LEFT, [[RED, GREEN], [BLUE, WHITE]]),
    "tga 32 bottom left": (TGA_32_BOTTOM_LEFT, [[(6, 5, 4, 0)], [(3, 2, 1, 128)]]),
    "tga 32 rle top left": (
        TGA_32_RLE_TOP_LEFT,
        [[(3, 2, 1, 128)] * 3, [(3, 2, 1, 128), (6, 5, 4, 255), (9, 8, 7, 0)]],
    ),
    "tga 24 rle bottom left": (TGA_24_RLE_BOTTOM_LEFT, [[RED, GREEN], [BLUE, BLUE]]),
    "tga grey": (TGA_GREY, [[(0, 0, 0, 255), (128, 128, 128, 255), WHITE]]),
    "tga palette": (TGA_PALETTE, [[BLUE, RED, BLUE]]),
    "png": (PNG_RGB, [[RED, GREEN]]),
}


def png(
    size: tuple[int, int],
    depth: int,
    kind: int,
    rows: bytes,
    chunks: Sequence[bytes] = (),
    interlaced: int = 0,
) -> bytes:
    """Make a png file: depth in bits, the colour type, filtered rows, chunks before the data."""
    header = struct.pack(">2I5B", *size, depth, kind, 0, 0, interlaced)
    parts = [chunk(b"IHDR", header), *chunks, chunk(b"IDAT", zlib.compress(rows)), chunk(b"IEND")]
    return b"\x89PNG\r\n\x1a\n" + b"".join(parts)


def chunk(tag: bytes, data: bytes = b"") -> bytes:
    return struct.pack(">I", len(data)) + tag + data + struct.pack(">I", zlib.crc32(tag + data))


def encoded(image: PillowImage.Image, kind: str) -> bytes:
    file = io.BytesIO()
    image.save(file, kind)
    return file.getvalue()


@pytest.mark.parametrize("name", FIXTURES)
def test_hand_written_files_decode_pixel_by_pixel(name: str) -> None:
    data, expected = FIXTURES[name]
    image = decode(data, name)
    assert image.pixels.dtype == np.uint8
    assert not image.pixels.flags.writeable
    np.testing.assert_array_equal(image.pixels, np.array(expected, np.uint8))
    assert image.size == (len(expected[0]), len(expected))
    assert image.has_alpha == any(pixel[3] < 255 for row in expected for pixel in row)
    assert image.source == name


@pytest.mark.parametrize("name", [name for name in FIXTURES if name.startswith("tga")])
def test_tga_cut_anywhere_is_refused(name: str) -> None:
    data, _ = FIXTURES[name]
    for length in range(len(data)):
        with pytest.raises(AssetError) as caught:
            decode(data[:length], "cut.tga")
        assert caught.value.source == "cut.tga"


def test_png_cut_before_its_last_row_is_refused() -> None:
    whole = decode(PNG_RGB, "whole.png").pixels
    for length in range(len(PNG_RGB)):
        if length < PNG_ROWS_END:
            with pytest.raises(AssetError):
                decode(PNG_RGB[:length], "cut.png")
        else:
            np.testing.assert_array_equal(decode(PNG_RGB[:length], "cut.png").pixels, whole)


@pytest.mark.parametrize("kind", ["JPEG", "BMP", "PCX"])
def test_cut_files_of_other_formats_are_refused(kind: str) -> None:
    colours = np.random.default_rng(3).integers(0, 256, (9, 8, 3), dtype=np.uint8)
    whole = encoded(PillowImage.fromarray(colours), kind)
    decode(whole, kind)
    for length in range(len(whole)):
        with pytest.raises(AssetError):
            decode(whole[:length], kind)


def test_pcx_without_its_palette_is_refused() -> None:
    indices = PillowImage.fromarray(np.arange(72, dtype=np.uint8).reshape(9, 8))
    indices.putpalette(bytes(range(255, -1, -1)) * 3)
    whole = encoded(indices, "PCX")
    np.testing.assert_array_equal(decode(whole, "skin.pcx").pixels, indices.convert("RGBA"))
    with pytest.raises(AssetError, match="expected a palette"):
        decode(whole[:-769], "skin.pcx")


def test_alpha_stays_where_a_tga_footer_calls_it_no_alpha() -> None:
    extension = struct.pack("<H492xB", 495, 0)  # its last byte is the type of alpha: none
    footer = struct.pack("<II", len(TGA_32_BOTTOM_LEFT), 0) + b"TRUEVISION-XFILE.\0"
    data = TGA_32_BOTTOM_LEFT + extension + footer
    whole = decode(TGA_32_BOTTOM_LEFT, "x.tga").pixels
    for length in range(len(TGA_32_BOTTOM_LEFT), len(data) + 1):
        np.testing.assert_array_equal(decode(data[:length], "x.tga").pixels, whole)


@pytest.mark.parametrize(
    ("depth", "kind", "row", "expected"),
    [
        (1, 0, "40", [[0] * 3 + [255], [255] * 4]),
        (16, 0, "1234 FF00", [[0x12] * 3 + [255], [255] * 4]),
        (8, 4, "1280 FF00", [[0x12] * 3 + [0x80], [255] * 3 + [0]]),
        (16, 4, "1234 8000 FF00 0001", [[0x12] * 3 + [0x80], [255] * 3 + [0]]),
        (16, 2, "0100 0200 0300 0400 0500 0600", [[1, 2, 3, 255], [4, 5, 6, 255]]),
        (16, 6, "0100 0200 0300 0400 0500 0600 0700 0800", [[1, 2, 3, 4], [5, 6, 7, 8]]),
        (8, 3, "01 00", [[4, 5, 6, 255], [1, 2, 3, 9]]),
    ],
)
def test_every_kind_of_png_becomes_rgba(
    depth: int, kind: int, row: str, expected: list[list[int]]
) -> None:
    palette = [chunk(b"PLTE", bytes([1, 2, 3, 4, 5, 6])), chunk(b"tRNS", bytes([9]))]
    chunks = palette if kind == 3 else []
    image = decode(png((2, 1), depth, kind, b"\0" + bytes.fromhex(row), chunks), "x.png")
    assert image.pixels.tolist() == [expected]


@pytest.mark.parametrize("mode", ["L", "RGB", "CMYK"])
def test_every_kind_of_jpg_becomes_rgba(mode: str) -> None:
    flat = PillowImage.new("RGB", (8, 8), (200, 200, 200)).convert(mode)
    image = decode(encoded(flat, "JPEG"), "x.jpg")
    assert np.abs(image.pixels[..., :3].astype(int) - 200).max() <= 1
    assert image.pixels[..., 3].min() == 255
    assert not image.has_alpha


def test_format_is_told_by_content_and_not_by_name() -> None:
    assert decode(PNG_RGB, "named.tga").pixels.tolist() == [[list(RED), list(GREEN)]]


@pytest.mark.parametrize(("width", "height"), [(0, 1), (1, 0), (MAX_SIDE + 1, 1), (1, 65535)])
def test_absurd_sizes_are_refused_by_the_header(width: int, height: int) -> None:
    tga = TGA_GREY[:12] + struct.pack("<HH", width, height) + TGA_GREY[16:]
    for data in (png((width, height), 8, 0, b""), tga):
        with pytest.raises(AssetError):
            decode(data, "x")
    if width and height:
        with pytest.raises(AssetError, match=f"x: header: .* found {width} x {height}"):
            decode(tga, "x")


@pytest.mark.parametrize(
    ("side", "depth", "kind", "interlaced", "row_bytes"),
    [
        (512, 16, 6, 0, 512 * (1 + 512 * 8)),  # more than is inflated at a time, of one colour
        # The seven passes of 5 x 5 pixels: the fourth onwards have 1 x 2, 3 x 1, 2 x 3, 5 x 2.
        (5, 8, 2, 1, (1 + 3) + (1 + 3) + (1 + 6) + 2 * (1 + 3) + (1 + 9) + 3 * (1 + 6) + 2 * 16),
    ],
)
def test_png_with_fewer_rows_than_stated_is_refused(
    side: int, depth: int, kind: int, interlaced: int, row_bytes: int
) -> None:
    whole = png((side, side), depth, kind, b"\0" * row_bytes, interlaced=interlaced)
    assert decode(whole, "x.png").size == (side, side)
    short = png((side, side), depth, kind, b"\0" * (row_bytes - 1), interlaced=interlaced)
    with pytest.raises(AssetError, match=f"IDAT: expected {row_bytes} .* found {row_bytes - 1}"):
        decode(short, "x.png")


def test_damaged_exif_is_no_concern() -> None:
    jpg = encoded(PillowImage.new("RGB", (8, 8), (9, 9, 9)), "JPEG")
    exif = b"Exif\0\0II*\0\xff\xff\0\0"
    segment = b"\xff\xe1" + struct.pack(">H", len(exif) + 2) + exif
    assert decode(jpg[:2] + segment + jpg[20:], "x.jpg").size == (8, 8)


@settings(deadline=None)
@given(
    st.sampled_from(sorted(FIXTURES)),
    st.lists(st.tuples(st.integers(0, 80), st.integers(0, 255)), min_size=1, max_size=4),
)
def test_damaged_bytes_give_an_image_or_one_clear_error(
    name: str, edits: list[tuple[int, int]]
) -> None:
    data = bytearray(FIXTURES[name][0])
    for position, value in edits:
        data[position % len(data)] = value
    try:
        assert decode(bytes(data), "x").pixels.shape[2] == 4
    except AssetError as error:
        assert error.source == "x"


def make_archive(folder: Path, files: dict[str, bytes]) -> Archive:
    for name, data in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data)
    return Archive.open([folder])


def test_textures_are_found_by_the_engines_rule(tmp_path: Path) -> None:
    names = ["t/a.jpg", "t/b.tga", "t/b.jpg", "t/c.png", "t/d.x.jpg", "t/E.JPG"]
    with make_archive(tmp_path, dict.fromkeys(names, b"")) as archive:
        assert find_image(archive, "t/a.tga") == ("t/a.jpg", ["t/a.tga", "t/a.jpg"])
        assert find_image(archive, "t/a") == ("t/a.jpg", ["t/a.tga", "t/a.jpg"])
        assert find_image(archive, "t/b.jpg") == ("t/b.jpg", ["t/b.jpg"])
        assert find_image(archive, "T\\B") == ("t/b.tga", ["t/b.tga"])
        assert find_image(archive, "t/c.jpg") == ("t/c.png", ["t/c.jpg", "t/c.tga", "t/c.png"])
        assert find_image(archive, "t/d.x")[0] == "t/d.x.jpg"
        assert find_image(archive, "t/e")[0] == "t/e.jpg"
        found, tried = find_image(archive, "t/none")
        assert found is None
        assert tried == ["t/none" + suffix for suffix in IMAGE_SUFFIXES]


@pytest.mark.parametrize("workers", [1, 3])
def test_images_come_in_order_and_few_are_read_ahead(
    tmp_path: Path, workers: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    files = {f"{i}.tga": TGA_GREY[:18] + bytes([i] * 3) for i in range(30)}
    files["7.tga"] = b"no image"
    with make_archive(tmp_path, files) as archive:
        read, reads = archive.read, list[str]()

        def counted(name: str) -> bytes:
            reads.append(name)
            return read(name)

        monkeypatch.setattr(archive, "read", counted)
        names = [*files, "missing.tga"]
        indices = []
        for index, result in decode_all(archive, names, workers):
            assert len(reads) <= index + 2 * workers
            indices.append(index)
            if index in (7, 30):
                assert isinstance(result, AssetError)
                assert names[index] in str(result)
            else:
                assert isinstance(result, Image)
                assert result.pixels[0, 0, 0] == index
        assert indices == list(range(31))
        assert sorted(reads) == sorted(names)


def test_a_consumer_may_stop_early(tmp_path: Path) -> None:
    with make_archive(tmp_path, {"a.tga": TGA_GREY}) as archive:
        threads = threading.active_count()
        images = decode_all(archive, ["a.tga"] * 100, 2)
        next(images)
        assert threading.active_count() > threads
        images.close()
        assert threading.active_count() == threads
        assert list(decode_all(archive, [])) == []


def test_transfer_functions_have_the_standards_values() -> None:
    encoded_values = np.array([0, 0.04045, 0.5, 1.0])
    linear_values = np.array([0, 0.04045 / 12.92, ((0.5 + 0.055) / 1.055) ** 2.4, 1.0])
    np.testing.assert_allclose(srgb_to_linear(encoded_values), linear_values, rtol=1e-15)
    np.testing.assert_allclose(linear_to_srgb(linear_values), encoded_values, rtol=1e-6)
    # The two pieces of each curve meet.
    for function, seam in ((srgb_to_linear, 0.04045), (linear_to_srgb, 0.0031308)):
        below, above = function(np.array([seam, np.nextafter(seam, 1)]))
        assert above == pytest.approx(below, rel=1e-5)
    assert srgb_to_linear(np.zeros(2, np.float32)).dtype == np.float32
    assert linear_to_srgb(np.zeros(2, np.float32)).dtype == np.float32


@settings(deadline=None)
@given(st.lists(st.floats(-1, 100), min_size=1))
def test_transfer_functions_are_each_others_inverse(values: list[float]) -> None:
    x = np.array(values)
    np.testing.assert_allclose(linear_to_srgb(srgb_to_linear(x)), x, rtol=1e-6, atol=1e-12)
    np.testing.assert_allclose(srgb_to_linear(linear_to_srgb(x)), x, rtol=1e-6, atol=1e-12)


def test_every_byte_decodes_by_the_table_and_encodes_back() -> None:
    levels = np.arange(256, dtype=np.uint8)
    pixels = np.stack([levels, levels[::-1], levels, levels], axis=1)
    linear = to_linear(pixels)
    assert linear.dtype == np.float32
    exact = srgb_to_linear(pixels[:, :3] / 255)
    np.testing.assert_array_equal(linear[:, :3], exact.astype(np.float32))
    np.testing.assert_array_equal(linear[:, 3], (levels / 255).astype(np.float32))
    np.testing.assert_array_equal(np.rint(linear_to_srgb(linear[:, :3]) * 255), pixels[:, :3])
    assert (np.diff(linear[:, 0]) > 0).all()


@pytest.mark.openarena
def test_openarenas_images_decode() -> None:
    with Archive.open([OPENARENA]) as archive:
        names = [name for name in archive.names() if name.endswith(IMAGE_SUFFIXES)]
        assert len(names) > 2000
        for index, image in decode_all(archive, names[::20]):
            assert isinstance(image, Image), (names[::20][index], image)


@pytest.mark.openarena
def test_openarenas_uncompressed_tgas_keep_every_byte() -> None:
    checked = disowned = 0
    with Archive.open([OPENARENA]) as archive:
        for name in archive.names("models/players/kyonshi/", ".tga"):
            data = archive.read(name)
            id_length, image_type, depth, descriptor = (data[i] for i in (0, 2, 16, 17))
            if (image_type, depth, descriptor & 0x30) != (2, 32, 0):
                continue
            width, height = struct.unpack_from("<HH", data, 12)
            count, start = width * height * 4, 18 + id_length
            bgra = np.frombuffer(data, np.uint8, count, start).reshape(height, width, 4)
            pixels = decode(data, name).pixels
            np.testing.assert_array_equal(pixels[::-1, :, [2, 1, 0, 3]], bgra)
            checked += 1
            with PillowImage.open(io.BytesIO(data)) as plain:
                disowned += np.asarray(plain)[..., 3].min() > bgra[..., 3].min()
    assert checked > 10
    assert disowned > 5  # so that this test would see the alpha go
