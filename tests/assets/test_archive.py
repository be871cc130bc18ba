"""Archives: precedence, names, damaged and evil paks, and finding levels."""

import os
import struct
import threading
import warnings
import zipfile
import zlib
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from followspot.assets import archive as archive_module
from followspot.assets.archive import (
    MAX_FILE_BYTES,
    Archive,
    list_levels,
    locate_level,
    normalise,
    search_path,
)
from followspot.errors import AssetError

OPENARENA = Path("/usr/share/games/openarena/baseoa")

# A pk3 file with one entry, a.txt, that holds "hi" uncompressed.
HAND_MADE_PAK = bytes.fromhex(
    "50 4B 03 04  0A 00  00 00  00 00  00 00 21 00  AC 2A 93 D8  02 00 00 00  02 00 00 00"
    "05 00  00 00  61 2E 74 78 74  68 69"
    "50 4B 01 02  0A 00  0A 00  00 00  00 00  00 00 21 00  AC 2A 93 D8  02 00 00 00  02 00 00 00"
    "05 00  00 00  00 00  00 00  00 00  00 00 00 00  00 00 00 00  61 2E 74 78 74"
    "50 4B 05 06  00 00  00 00  01 00  01 00  33 00 00 00  25 00 00 00  00 00"
)
CENTRAL = HAND_MADE_PAK.index(b"PK\1\2")
LOCAL_NAME_LENGTH, LOCAL_DATA = 26, 35
CENTRAL_FLAGS, CENTRAL_METHOD, CENTRAL_CRC = CENTRAL + 8, CENTRAL + 10, CENTRAL + 16
CENTRAL_STORED, CENTRAL_SIZE, CENTRAL_OFFSET = CENTRAL + 20, CENTRAL + 24, CENTRAL + 42


def write_pak(path: Path, files: Mapping[str, bytes | str]) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as pak:
        for name, data in files.items():
            pak.writestr(name, data)
    return path


def write_files(folder: Path, files: Mapping[str, str]) -> Path:
    for name, text in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)
    return folder


def patched(position: int, layout: str, value: int, pak: bytes = HAND_MADE_PAK) -> bytes:
    data = bytearray(pak)
    struct.pack_into(layout, data, position, value)
    return bytes(data)


DEFLATED = patched(CENTRAL_METHOD, "<H", zipfile.ZIP_DEFLATED)


@pytest.fixture
def no_installs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(archive_module, "INSTALL_FOLDERS", ())
    monkeypatch.delenv("FOLLOWSPOT_ASSETS", raising=False)


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
        assert list_levels(archive) == ["a", "b"]


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
        Archive.open([tmp_path])
    assert caught.value.source == str(tmp_path / "evil.pk3")
    assert caught.value.found == repr(name)


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
        for root in (path, tmp_path):
            with pytest.raises(AssetError) as caught:
                Archive.open([root])
            assert caught.value.source == str(path)


def test_a_text_file_called_pk3_is_refused(tmp_path: Path) -> None:
    (tmp_path / "x.pk3").write_text("hello")
    with pytest.raises(AssetError, match=r"x\.pk3: expected a pk3 \(zip\) file, found File is not"):
        Archive.open([tmp_path])


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


def test_a_refused_archive_leaves_no_file_open(tmp_path: Path) -> None:
    write_pak(tmp_path / "a.pk3", {"x": "x"})
    (tmp_path / "b.pk3").write_text("no zip")
    with warnings.catch_warnings():
        warnings.simplefilter("error", ResourceWarning)
        with pytest.raises(AssetError):
            Archive.open([tmp_path])
    closed = Archive.open([tmp_path / "a.pk3"])
    closed.close()
    with pytest.raises(ValueError, match="closed file"):
        closed.read("x")


def test_search_path_puts_named_folders_first(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    home = tmp_path / "home"
    for folder in ("home/.q3a/baseq3", "home/.openarena/baseoa", "a", "b/baseq3", "b/baseoa", "c"):
        (tmp_path / folder).mkdir(parents=True)
    pak = write_pak(tmp_path / "p.pk3", {})
    (tmp_path / "link").symlink_to(tmp_path / "a")
    monkeypatch.setenv("HOME", str(home))
    listed = [tmp_path / "c", tmp_path / "link", home / ".q3a"]
    monkeypatch.setenv("FOLLOWSPOT_ASSETS", os.pathsep.join(["", *map(str, listed)]))
    found = search_path([tmp_path / "a", tmp_path / "b", pak])
    assert found[:7] == [
        tmp_path / "a",
        tmp_path / "b/baseoa",
        tmp_path / "b/baseq3",
        pak,
        tmp_path / "c",
        home / ".q3a/baseq3",
        home / ".openarena/baseoa",
    ]
    assert all(path.name in ("baseoa", "baseq3") for path in found[7:])


@pytest.mark.usefixtures("no_installs")
def test_search_path_refuses_what_does_not_exist(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert search_path() == []
    with pytest.raises(AssetError, match="gone: expected a game folder"):
        search_path([tmp_path / "gone"])
    monkeypatch.setenv("FOLLOWSPOT_ASSETS", str(tmp_path / "gone"))
    with pytest.raises(AssetError, match="gone: environment variable FOLLOWSPOT_ASSETS: expected"):
        search_path()


def test_levels_are_located_by_name_path_and_pak(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    game = write_files(tmp_path / "game", {"maps/One.bsp": "game one", "maps/two.bsp": "game two"})
    mine = write_files(tmp_path / "mine", {"maps/one.bsp": "my one", "textures/t.tga": "t"})
    write_files(tmp_path / "loose", {"one.bsp": "bare one"})
    single = write_pak(tmp_path / "Single.pk3", {"maps/one.bsp": "packed one", "x.txt": ""})
    many = write_pak(tmp_path / "many.pk3", {"maps/one.bsp": "1", "maps/sub/two.bsp": "2"})
    monkeypatch.chdir(mine / "maps")

    def read(name: str) -> tuple[str, str]:
        archive, entry = locate_level(name, [game])
        with archive:
            assert archive.exists("maps/two.bsp")  # the search path is always there
            return entry, archive.read(entry).decode()

    for name in ("one", "ONE", "maps/one.bsp", "Maps\\One.BSP", "one.BSP"):
        assert read(name) == ("maps/one.bsp", "game one")
    assert read("one.bsp") == ("maps/one.bsp", "my one")  # a file in the working directory
    assert read(str(mine / "maps/one.bsp")) == ("maps/one.bsp", "my one")
    assert read("../maps/one.bsp") == ("maps/one.bsp", "my one")
    assert read(str(tmp_path / "loose/one.bsp")) == ("one.bsp", "bare one")
    assert read(str(single)) == ("maps/one.bsp", "packed one")
    assert read(f"{single}:ONE") == ("maps/one.bsp", "packed one")
    assert read(f"{many}:maps/sub/two.bsp") == ("maps/sub/two.bsp", "2")
    archive, _ = locate_level(str(mine / "maps/one.bsp"), [])
    with archive:
        assert archive.read("textures/t.tga") == b"t"


def test_levels_that_cannot_be_located_say_what_is_near(tmp_path: Path) -> None:
    game = write_files(tmp_path / "game", {f"maps/oa_dm{i}.bsp": "" for i in range(1, 4)})
    many = write_pak(tmp_path / "many.pk3", {"maps/one.bsp": "", "maps/two.bsp": ""})
    none = write_pak(tmp_path / "none.pk3", {"x": ""})

    def refused(name: str, search: list[Path]) -> AssetError:
        with pytest.raises(AssetError) as caught:
            locate_level(name, search)
        assert "\n" not in str(caught.value)
        return caught.value

    error = refused("oa_dm1x", [game, many])
    assert error.source == "oa_dm1x"
    assert f"in {game}, {many}" in error.expected
    assert error.found.startswith("none; close names are oa_dm1, ")
    assert refused("zzz", [game]).found == "none"
    assert "name one with --assets" in refused("oa_dm1", []).expected
    assert refused(str(tmp_path / "gone/maps/oa_dm2.bsp"), [game]).found == "none"
    assert refused(str(tmp_path / "gone.pk3"), []).source == str(tmp_path / "gone.pk3")
    assert refused(str(many), []).found == "one, two"
    assert refused(str(none), []).found == "no level"
    error = refused(f"{many}:tow", [])
    assert (error.place, error.found) == ("tow", "none; close names are two")
    refused("x" * 5000, [game])
    refused("a\0b", [game])


@pytest.mark.openarena
def test_openarena_is_one_archive() -> None:
    with Archive.open([OPENARENA]) as archive:
        levels = list_levels(archive)
        assert len(levels) >= 85
        assert archive.source("maps/oa_dm5.bsp") == "pak1-maps.pk3:maps/oa_dm5.bsp"
        assert archive.read("maps/oa_dm5.bsp")[:8] == struct.pack("<4si", b"IBSP", 46)
        scripts = archive.names("scripts/", ".shader")
        assert scripts
        for name in scripts:
            assert archive.read(name)


@pytest.mark.openarena
def test_openarena_is_found_without_being_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("FOLLOWSPOT_ASSETS", raising=False)
    found = search_path()
    assert OPENARENA in found
    archive, entry = locate_level("OA_DM5", found)
    with archive:
        assert entry == "maps/oa_dm5.bsp"
