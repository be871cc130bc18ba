"""Archives: precedence, names, damaged and evil paks."""

import gc
import os
import struct
import threading
import warnings
import zipfile
import zlib
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from archive_fixtures import OPENARENA, write_files, write_pak
from hypothesis import given, settings
from hypothesis import strategies as st

from followspot.assets import archive as archive_module
from followspot.assets.archive import Archive, normalise
from followspot.assets.pak import MAX_FILE_BYTES, Pak
from followspot.errors import AssetError

# A pk3 file with one entry, a.txt, that holds "hi" uncompressed.
HAND_MADE_PAK = bytes.fromhex(
    "50 4B 03 04  0A 00  00 00  00 00  00 00 21 00  AC 2A 93 D8  02 00 00 00  02 00 00 00"
    "05 00  00 00  61 2E 74 78 74  68 69"
    "50 4B 01 02  0A 00  0A 00  00 00  00 00  00 00 21 00  AC 2A 93 D8  02 00 00 00  02 00 00 00"
    "05 00  00 00  00 00  00 00  00 00  00 00 00 00  00 00 00 00  61 2E 74 78 74"
    "50 4B 05 06  00 00  00 00  01 00  01 00  33 00 00 00  25 00 00 00  00 00"
)
EVIL = HAND_MADE_PAK.replace(b"a.txt", b"/etc/")  # its one name leads out
CENTRAL = HAND_MADE_PAK.index(b"PK\1\2")
END = HAND_MADE_PAK.index(b"PK\5\6")
LOCAL_NAME_LENGTH, LOCAL_DATA = 26, 35
CENTRAL_FLAGS, CENTRAL_METHOD, CENTRAL_CRC = CENTRAL + 8, CENTRAL + 10, CENTRAL + 16
CENTRAL_STORED, CENTRAL_SIZE, CENTRAL_OFFSET = CENTRAL + 20, CENTRAL + 24, CENTRAL + 42


def patched(position: int, layout: str, value: int, pak: bytes = HAND_MADE_PAK) -> bytes:
    data = bytearray(pak)
    struct.pack_into(layout, data, position, value)
    return bytes(data)


DEFLATED = patched(CENTRAL_METHOD, "<H", zipfile.ZIP_DEFLATED)


@pytest.mark.parametrize(
    "spelling",
    ["maps/a.bsp", "MAPS/A.BSP", "maps\\a.bsp", "maps//a.bsp", "./maps/./a.bsp", "/maps/a.bsp"],
)
def test_every_spelling_names_the_same_file(tmp_path: Path, spelling: str) -> None:
    assert normalise(spelling) == "maps/a.bsp"
    pak = write_pak(tmp_path / "Pak.PK3", {"Maps\\A.bsp": "packed"})
    loose = write_files(tmp_path / "loose", {"Maps/A.bsp": "loose"})
    for root, text in ((pak, b"packed"), (tmp_path, b"packed"), (loose, b"loose")):
        with Archive.open([root]) as archive:
            assert archive.exists(spelling)
            assert archive.read(spelling) == text


def test_hand_made_pak_is_read(tmp_path: Path) -> None:
    (tmp_path / "hand.pk3").write_bytes(HAND_MADE_PAK)
    with Archive.open([tmp_path]) as archive:
        assert archive.names() == ["a.txt"]
        assert archive.read("a.txt") == b"hi"
        assert archive.source("A.TXT") == "hand.pk3:a.txt"


def test_later_paks_win_and_loose_files_win_over_paks(tmp_path: Path) -> None:
    write_pak(tmp_path / "pak0.pk3", {"a": "0", "b": "0", "c": "0", "d": "0"})
    write_pak(tmp_path / "PAK1.pk3", {"b": "1", "c": "1", "d": "1"})
    write_pak(tmp_path / "pak_2.pk3", {"C": "2", "d": "2"})
    write_pak(tmp_path / "pakz.pk3", {"c": "z"})  # before pak_2, as upper case compares
    write_files(tmp_path, {"D": "loose"})
    with Archive.open([tmp_path]) as archive:
        assert [archive.read(name) for name in "abcd"] == [b"0", b"1", b"2", b"loose"]
        assert archive.source("c") == "pak_2.pk3:C"
        assert archive.source("d") == str(tmp_path / "D")
        assert archive.names() == ["a", "b", "c", "d"]


def test_later_entries_of_one_pak_win(tmp_path: Path) -> None:
    pak = write_pak(tmp_path / "p.pk3", {"A.txt": "first", "a.txt": "second"})
    with Archive.open([pak]) as archive:
        assert archive.read("a.txt") == b"second"


def test_earlier_roots_win_over_later_ones(tmp_path: Path) -> None:
    folder = write_files(tmp_path / "folder", {"a": "folder", "b": "folder"})
    pak = write_pak(tmp_path / "pak.pk3", {"b": "pak", "c": "pak"})
    for roots, b in (([folder, pak], b"folder"), ([pak, folder], b"pak")):
        with Archive.open(roots) as archive:
            assert [archive.read(name) for name in "abc"] == [b"folder", b, b"pak"]


def test_names_are_filtered_and_sorted(tmp_path: Path) -> None:
    files = dict.fromkeys(["maps/b.BSP", "Maps/a.bsp", "maps/a.aas", "maps2/c.bsp", "folder/"], "")
    with Archive.open([write_pak(tmp_path / "p.pk3", files)]) as archive:
        assert archive.names("maps/", ".bsp") == ["maps/a.bsp", "maps/b.bsp"]
        assert archive.names("MAPS\\", ".BSP") == ["maps/a.bsp", "maps/b.bsp"]
        assert archive.names(suffix=".aas") == ["maps/a.aas"]
        assert len(archive.names()) == 4


@pytest.mark.parametrize("name", ["missing", "../outside", "/etc/passwd", "", "folder", "a\0b"])
def test_what_is_not_in_the_archive_cannot_be_read(tmp_path: Path, name: str) -> None:
    write_files(tmp_path, {"outside": "secret", "root/folder/file": ""})
    with Archive.open([tmp_path / "root"]) as archive:
        assert not archive.exists(name)
        for method in (archive.read, archive.source):
            with pytest.raises(AssetError) as caught:
                method(name)
            assert caught.value.source == name
            assert str(tmp_path / "root") in caught.value.expected


def test_loose_files_survive_odd_folders(tmp_path: Path) -> None:
    root = write_files(tmp_path / "root", {"maps/a.bsp": "a", ".hidden/x": "", "z/deep/d": "d"})
    elsewhere = write_files(tmp_path / "elsewhere", {"t.tga": "t"})
    (root / "linked").symlink_to(elsewhere)
    (root / "alias").symlink_to(root / "maps")
    (root / "z/deep/up").symlink_to(root)
    (root / "maps/self").symlink_to(root / "maps/self")
    (root / "maps/broken.bsp").symlink_to(root / "nothing")
    os.mkfifo(root / "maps/pipe.bsp")
    (root / "folder.pk3").mkdir()
    with Archive.open([root]) as archive:
        assert archive.names() == ["alias/a.bsp", "linked/t.tga", "maps/a.bsp", "z/deep/d"]
        assert archive.read("linked/t.tga") == b"t"
        (root / "maps/a.bsp").unlink()
        with pytest.raises(AssetError, match=r"maps/a\.bsp: expected a readable file"):
            archive.read("maps/a.bsp")


def test_a_root_that_is_no_game_folder_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(AssetError, match="gone: expected a readable file"):
        Archive.open([tmp_path / "gone"])
    write_files(tmp_path, {f"{i}/file": "" for i in range(10)})
    monkeypatch.setattr(archive_module, "MAX_LOOSE_FILES", 19)
    with pytest.raises(AssetError, match="at most 19 files, found more"):
        Archive.open([tmp_path])
    monkeypatch.setattr(archive_module, "MAX_LOOSE_FILES", 20)
    with Archive.open([tmp_path]) as archive:
        assert len(archive.names()) == 10


@pytest.mark.parametrize(
    "name",
    [
        "../up",
        "maps/../../up",
        "maps\\..\\up",
        "..",
        "/etc/passwd",
        "\\root",
        "C:/x",
        "c:x",
        "a\0b",
    ],
)
def test_paks_with_names_that_lead_out_are_refused_whole(tmp_path: Path, name: str) -> None:
    raw = name.encode()
    data = bytearray(HAND_MADE_PAK)
    struct.pack_into("<I", data, len(data) - 10, 0x33 - 5 + len(raw))  # the table's size
    struct.pack_into("<H", data, CENTRAL + 28, len(raw))
    data[CENTRAL + 46 : CENTRAL + 51] = raw
    write_pak(tmp_path / "good.pk3", {"x": "x"})
    (tmp_path / "evil.pk3").write_bytes(data)
    with pytest.raises(AssetError) as caught:
        Archive.open([tmp_path / "evil.pk3"])
    assert caught.value.source == str(tmp_path / "evil.pk3")
    assert caught.value.found == repr(name)


@pytest.mark.parametrize("data", [b"", b"hello", HAND_MADE_PAK[:-1], EVIL])
def test_a_bad_pak_in_a_folder_is_left_out_and_listed(
    tmp_path: Path, data: bytes, monkeypatch: pytest.MonkeyPatch
) -> None:
    write_pak(tmp_path / "good.pk3", {"x": "x"})
    bad = tmp_path / "z_bad.pk3"
    bad.write_bytes(data)
    closed: list[Path] = []
    close = Pak.close

    def noted(pak: Pak) -> None:
        closed.append(pak.path)
        close(pak)

    monkeypatch.setattr(Pak, "close", noted)
    with Archive.open([tmp_path]) as archive:
        assert archive.names() == ["x"]
        assert [problem.source for problem in archive.problems] == [str(bad)]
        assert closed == [bad]
    with pytest.raises(AssetError) as caught:
        Archive.open([tmp_path, bad])
    assert caught.value.source == str(bad)


@pytest.mark.parametrize("name", ["a..b", "...", "maps/x..bsp", "ab:c", "maps/c:x", ".hidden"])
def test_names_that_only_look_odd_are_kept(tmp_path: Path, name: str) -> None:
    with Archive.open([write_pak(tmp_path / "p.pk3", {name: "fine"})]) as archive:
        assert archive.read(name) == b"fine"


def test_absurd_sizes_are_refused_unread(tmp_path: Path) -> None:
    path = tmp_path / "big.pk3"
    path.write_bytes(patched(CENTRAL_SIZE, "<I", MAX_FILE_BYTES + 1))
    with Archive.open([path]) as archive, pytest.raises(AssetError) as caught:
        archive.read("a.txt")
    assert caught.value.source == "big.pk3:a.txt"
    assert caught.value.expected == f"at most {MAX_FILE_BYTES} bytes"
    assert caught.value.found == str(MAX_FILE_BYTES + 1)
    sparse = tmp_path / "loose/huge.bsp"
    sparse.parent.mkdir()
    with sparse.open("wb") as file:
        file.truncate(MAX_FILE_BYTES + 1)
    with (
        Archive.open([sparse.parent]) as archive,
        pytest.raises(AssetError, match="expected at most"),
    ):
        archive.read("huge.bsp")


def test_data_that_inflate_past_their_stated_size_are_refused(tmp_path: Path) -> None:
    path = write_pak(tmp_path / "bomb.pk3", {"a": bytes(50_000_000)})
    data = bytearray(path.read_bytes())
    assert len(data) < 100_000
    central = data.index(b"PK\1\2")
    struct.pack_into("<I", data, central + 24, 1000)
    struct.pack_into("<I", data, central + 16, zlib.crc32(bytes(1000)))  # so that zipfile agrees
    path.write_bytes(data)
    with Archive.open([path]) as archive, pytest.raises(AssetError) as caught:
        archive.read("a")
    assert str(caught.value) == "bomb.pk3:a: expected 1000 bytes, found more"


@pytest.mark.parametrize(
    ("data", "expected", "found"),
    [
        (patched(CENTRAL_FLAGS, "<H", 1), "plain data", "encrypted data"),
        (patched(CENTRAL_METHOD, "<H", 14), "stored or deflated data", "method 14"),
        (patched(LOCAL_DATA, "B", 0xFF, DEFLATED), "deflated data", "damage"),
        (DEFLATED, "2 bytes", "0"),  # "hi" is the beginning of a deflated block
        (patched(CENTRAL_CRC, "<I", 7), "checksum 00000007", "d8932aac"),
        (patched(CENTRAL_SIZE, "<I", 3), "3 bytes", "2"),
        (patched(CENTRAL_STORED, "<I", 1), "2 bytes", "1"),
        (patched(CENTRAL_STORED, "<I", 0xFFFFFFF0), "4294967280 bytes of data", "the pak's end"),
        (patched(CENTRAL_OFFSET, "<I", 1), "an entry's header", "b'K"),
        (patched(CENTRAL_OFFSET, "<I", 0x7FFFFFFF), "an entry's header", "b''"),
        (patched(LOCAL_NAME_LENGTH, "<H", 0xFFFF), "2 bytes of data", "the pak's end"),
    ],
)
def test_damaged_entries_are_refused_and_named(
    tmp_path: Path, data: bytes, expected: str, found: str
) -> None:
    path = tmp_path / "bad.pk3"
    path.write_bytes(data)
    with Archive.open([path]) as archive:
        assert archive.exists("a.txt")
        with pytest.raises(AssetError) as caught:
            archive.read("a.txt")
    assert caught.value.source == "bad.pk3:a.txt"
    assert caught.value.expected == expected
    assert caught.value.found.startswith(found)


def test_a_pak_cut_anywhere_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "cut.pk3"
    for length in range(len(HAND_MADE_PAK)):
        path.write_bytes(HAND_MADE_PAK[:length])
        with pytest.raises(AssetError) as caught:
            Archive.open([path])
        assert caught.value.source == str(path)


def test_a_text_file_called_pk3_is_refused(tmp_path: Path) -> None:
    (tmp_path / "x.pk3").write_text("hello")
    with pytest.raises(AssetError, match=r"x\.pk3: expected a pk3 \(zip\) file, found no record"):
        Archive.open([tmp_path / "x.pk3"])


@pytest.mark.parametrize(
    ("data", "found"),
    [
        (patched(END + 12, "<I", 0x34), "a table of 52 bytes"),  # it would begin before the file
        (patched(END + 12, "<I", 0x32), "no entry at byte 0"),
        (patched(END + 12, "<I", 0xFFFFFFFF), "the zip64 format"),
        (patched(END + 16, "<I", 0xFFFFFFFF), "the zip64 format"),
        (patched(END + 16, "<I", 0x26), "a table of 51 bytes"),
        (patched(CENTRAL, "<I", 0), "no entry at byte 0"),
        (patched(CENTRAL + 28, "<H", 6), "its table's last entry cut short"),
        (patched(CENTRAL + 28, "<H", 4), "no entry at byte 50"),
        (patched(CENTRAL_FLAGS, "<H", 0x800, patched(CENTRAL + 46, "B", 0xE9)), "the name b'"),
    ],
)
def test_paks_with_a_damaged_table_are_refused(tmp_path: Path, data: bytes, found: str) -> None:
    path = tmp_path / "bad.pk3"
    path.write_bytes(data)
    with pytest.raises(AssetError) as caught:
        Archive.open([path])
    assert caught.value.source == str(path)
    assert caught.value.expected == "a pk3 (zip) file"
    assert caught.value.found.startswith(found)


@pytest.mark.parametrize("before", [b"", b"#!/bin/unzip\n"])
@pytest.mark.parametrize("comment", [b"", b"made by hand", b"PK\5\6", bytes(0xFFFF)])
def test_what_stands_around_a_zip_file_does_not_matter(
    tmp_path: Path, before: bytes, comment: bytes
) -> None:
    path = tmp_path / "a.pk3"
    path.write_bytes(before + patched(END + 20, "<H", len(comment)) + comment)
    with Archive.open([path]) as archive:
        assert archive.read("a.txt") == b"hi"


@pytest.mark.parametrize(
    ("flags", "raw", "name"), [(0, b"f\x82tes", "f\xe9tes"), (0x800, b"f\xc3\xa9te", "f\xe9te")]
)
def test_names_are_in_the_code_page_that_the_pak_says(
    tmp_path: Path, flags: int, raw: bytes, name: str
) -> None:
    data = patched(CENTRAL_FLAGS, "<H", flags).replace(b"a.txt", raw)
    (tmp_path / "a.pk3").write_bytes(data)
    with Archive.open([tmp_path]) as archive:
        assert archive.names() == [name]


@settings(deadline=None)
@given(
    st.lists(
        st.tuples(st.integers(0, len(HAND_MADE_PAK) - 1), st.integers(0, 255)),
        min_size=1,
        max_size=3,
    )
)
def test_damaged_bytes_give_the_data_or_one_clear_error(
    tmp_path_factory: pytest.TempPathFactory, edits: list[tuple[int, int]]
) -> None:
    data = bytearray(HAND_MADE_PAK)
    for position, value in edits:
        data[position] = value
    path = tmp_path_factory.getbasetemp() / "damaged.pk3"
    path.write_bytes(data)
    try:
        with Archive.open([path]) as archive:
            for name in archive.names():
                archive.read(name)
    except AssetError as error:
        assert "damaged.pk3" in error.source


def test_threads_read_in_parallel(tmp_path: Path) -> None:
    files = {f"{i}.txt": bytes([i]) * (1000 + i) for i in range(50)}
    path = write_pak(tmp_path / "p.pk3", files)
    with Archive.open([path]) as archive, ThreadPoolExecutor(4) as pool:
        names = list(files) * 20
        barrier = threading.Barrier(4)
        list(pool.map(lambda _: barrier.wait(), range(4)))  # all four threads are up
        assert list(pool.map(archive.read, names)) == [files[name] for name in names]


def test_what_is_put_beside_stands_in_for_nothing(tmp_path: Path) -> None:
    game = write_files(tmp_path / "game", {"maps/a.bsp": "game"})
    things = write_files(tmp_path / "things", {"maps/a.bsp": "loose", "inner/b.txt": "b"})
    write_pak(things / "pak.pk3", {"maps/a.bsp": "packed", "c.txt": "c"})
    (things / "broken.pk3").write_bytes(b"")
    write_pak(things / "inner/pak.pk3", {"d.txt": "d"})
    with Archive.open([game]) as archive:
        prefix = archive.put_beside(things, "Things")
        assert prefix == archive.put_beside(things, "things") == "beside:/things/"
        assert archive.read("maps/a.bsp") == b"game" and archive.names("maps/") == ["maps/a.bsp"]
        assert archive.read("beside:/Things/MAPS/a.bsp") == b"loose"
        assert archive.read("beside:/things/c.txt") == b"c"
        assert archive.root("beside:/things/c.txt") == -1
        assert [Path(problem.source).name for problem in archive.problems] == ["broken.pk3"]
        # Of a folder in a folder both are there; what lies in it is the inner one's.
        inner = archive.put_beside(things / "inner", "things/inner")
        assert archive.read(inner + "d.txt") == b"d"
        assert archive.beside(inner + "b.txt") == inner
        assert archive.beside("beside:/things/c.txt") == prefix
        assert archive.beside("maps/a.bsp") == ""
        assert archive.put_beside(things, ".") == "beside:/"


def test_no_archive_leaves_files_open(tmp_path: Path) -> None:
    write_pak(tmp_path / "a.pk3", {"x": "x"})
    (tmp_path / "b.pk3").write_text("no zip")
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", ResourceWarning)
        with pytest.raises(AssetError):
            Archive.open([tmp_path / "a.pk3", tmp_path / "b.pk3"])
        Archive.open([tmp_path])  # and let go
        gc.collect()
    assert [str(warning.message) for warning in caught] == []
    closed = Archive.open([tmp_path / "a.pk3"])
    closed.close()
    with pytest.raises(ValueError, match="closed file"):
        closed.read("x")


@pytest.mark.openarena
def test_openarena_is_one_archive() -> None:
    with Archive.open([OPENARENA]) as archive:
        assert len(archive.names("maps/", ".bsp")) >= 85
        assert archive.source("maps/oa_dm5.bsp") == "pak1-maps.pk3:maps/oa_dm5.bsp"
        assert archive.read("maps/oa_dm5.bsp")[:8] == struct.pack("<4si", b"IBSP", 46)
        scripts = archive.names("scripts/", ".shader")
        assert scripts
        for name in scripts:
            assert archive.read(name)
