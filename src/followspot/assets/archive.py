"""Game folders and pk3 files as one read-only tree with case-insensitive names.

Quake 3 keeps its files in game folders (`baseq3`, OpenArena's `baseoa`): loose files, and pk3
files, which are zip archives. Look-ups ignore case and the direction of slashes, and where
several files share a name, one wins:

- an earlier root wins over a later one;
- within a folder, a loose file wins over the pk3 files in it;
- of the pk3 files in a folder, the later by name wins;
- within a pk3 file, the later entry wins.

Names are gathered once, when the archive is opened, and only a gathered name can be read: no name
that stands in a level or a script can reach a file outside the roots.
"""
# ruff: noqa: PTH111, PTH112, PTH113 - these three of os.path, unlike pathlib's, never raise.

import difflib
import os
import re
import struct
import threading
import zipfile
import zlib
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from os.path import expanduser, expandvars, isdir, isfile
from pathlib import Path
from typing import Self

from followspot.errors import AssetError

MAX_FILE_BYTES = 256 << 20
"""Largest file that is read; the largest levels and textures stay well below it."""

MAX_LOOSE_FILES = 100_000
"""Most files and folders below one root: a home folder or a whole disk is no game folder."""

GAME_FOLDERS = ("baseoa", "baseq3")

_STEAM = "steamapps/common/Quake 3 Arena"
INSTALL_FOLDERS = (
    *("~/.openarena", "~/.q3a"),
    *(f"~/Library/Application Support/{game}" for game in ("OpenArena", "Quake3")),
    *(f"%APPDATA%/{game}" for game in ("OpenArena", "Quake3")),
    *(f"~/{steam}/{_STEAM}" for steam in (".local/share/Steam", ".steam/steam")),
    f"~/Library/Application Support/Steam/{_STEAM}",
    f"C:/Program Files (x86)/Steam/{_STEAM}",
    *(f"C:/Program Files (x86)/{game}" for game in ("OpenArena", "Quake III Arena")),
    *(f"C:/Program Files/{game}" for game in ("OpenArena", "Quake III Arena")),
    "C:/GOG Games/Quake III Arena",
    *(f"/Applications/{game}" for game in ("OpenArena", "Quake3")),
    *(f"/usr/local/games/{game}" for game in ("openarena", "quake3")),
    *(f"/usr/share/games/{game}" for game in ("openarena", "quake3")),
    *(f"/usr/share/{game}" for game in ("openarena", "quake3")),
    *(f"/usr/lib/{game}" for game in ("openarena", "quake3")),
    *(f"/usr/lib/games/{game}" for game in ("openarena", "quake3")),
    *(f"/opt/{game}" for game in ("openarena", "quake3")),
)
"""Where OpenArena and Quake 3 install themselves, a user's own folders in front."""

_LOCAL_HEADER = struct.Struct("<4s22xHH")  # signature, length of the name, length of the extra
_LOCAL_SIGNATURE = b"PK\3\4"
_ENCRYPTED = 1
_PAK_AND_LEVEL = re.compile(r"(?P<pak>.+\.pk3)(:(?P<level>.+))?", re.IGNORECASE)


def normalise(name: str) -> str:
    """Give a file's name its one spelling: lower case, `/`, no empty or `.` parts."""
    parts = name.replace("\\", "/").lower().split("/")
    return "/".join(part for part in parts if part not in ("", "."))


@dataclass(frozen=True, slots=True)
class _LooseFile:
    path: Path

    @property
    def source(self) -> str:
        return str(self.path)

    def read(self) -> bytes:
        try:
            _refuse_absurd_size(self.source, self.path.stat().st_size)
            return self.path.read_bytes()
        except OSError as error:
            raise _unreadable(self.path, error) from error


class _Pak:
    """One open pk3 file; the lock keeps threads from moving each other's file position."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._lock = threading.Lock()
        try:
            self._file = path.open("rb")
            self._size = path.stat().st_size
        except OSError as error:
            raise _unreadable(path, error) from error

    def close(self) -> None:
        self._file.close()

    def entries(self) -> "dict[str, _PakEntry]":
        try:
            with zipfile.ZipFile(self._file) as table:
                infos = table.infolist()
        except (
            zipfile.BadZipFile,
            NotImplementedError,
            OSError,
            ValueError,
            struct.error,
        ) as error:
            raise AssetError(
                str(self.path), expected="a pk3 (zip) file", found=str(error)
            ) from error
        for info in infos:
            _refuse_unsafe_name(self.path, info.orig_filename)
        files = [info for info in infos if not info.is_dir()]
        return {normalise(info.filename): _PakEntry(self, info) for info in files}

    def read_at(self, start: int, count: int) -> bytes:
        """Read `count` bytes, or none where the file has fewer: a lying count allocates nothing."""
        if not 0 <= start <= self._size - count:
            return b""
        try:
            with self._lock:
                self._file.seek(start)
                return self._file.read(count)
        except OSError as error:
            raise _unreadable(self.path, error) from error


@dataclass(frozen=True, slots=True)
class _PakEntry:
    """One file in a pk3 file.

    zipfile reads the pak's table of contents; the data are read here, because zipfile neither
    bounds what an entry inflates to nor lets several threads inflate at once.
    """

    pak: _Pak
    info: zipfile.ZipInfo

    @property
    def source(self) -> str:
        return f"{self.pak.path.name}:{self.info.filename}"

    def read(self) -> bytes:
        info = self.info
        _refuse_absurd_size(self.source, info.file_size)
        if info.flag_bits & _ENCRYPTED:
            raise self._wrong("plain data", "encrypted data")
        if info.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
            raise self._wrong("stored or deflated data", f"method {info.compress_type}")
        data = self._raw()
        if info.compress_type == zipfile.ZIP_DEFLATED:
            inflater = zlib.decompressobj(-zlib.MAX_WBITS)
            try:
                # One byte more than the pak states tells data that lies from data that fits.
                data = inflater.decompress(data, info.file_size + 1)
            except zlib.error as error:
                raise self._wrong("deflated data", f"damage ({error})") from error
        if len(data) != info.file_size:
            found = "more" if len(data) > info.file_size else f"{len(data)}"
            raise self._wrong(f"{info.file_size} bytes", found)
        if zlib.crc32(data) != info.CRC:
            raise self._wrong(f"checksum {info.CRC:08x}", f"{zlib.crc32(data):08x}")
        return data

    def _raw(self) -> bytes:
        start = self.info.header_offset
        header = self.pak.read_at(start, _LOCAL_HEADER.size)
        if not header.startswith(_LOCAL_SIGNATURE):
            raise self._wrong("an entry's header", repr(header[:4]), place=f"byte {start}")
        _, name_length, extra_length = _LOCAL_HEADER.unpack(header)
        start += _LOCAL_HEADER.size + name_length + extra_length
        data = self.pak.read_at(start, self.info.compress_size)
        if len(data) != self.info.compress_size:
            expected = f"{self.info.compress_size} bytes of data"
            raise self._wrong(expected, "the pak's end", place=f"byte {start}")
        return data

    def _wrong(self, expected: str, found: str, place: str = "") -> AssetError:
        return AssetError(self.source, place=place, expected=expected, found=found)


class Archive:
    """The files of several folders and pk3 files, read by name; a context manager.

    Names may be given in any case and with either slash. Reading is safe from several threads.
    """

    def __init__(
        self, roots: Sequence[Path], files: dict[str, _LooseFile | _PakEntry], paks: ExitStack
    ) -> None:
        self._roots = roots
        self._files = files
        self._paks = paks

    @classmethod
    def open(cls, roots: Sequence[Path]) -> Self:
        """Gather the names in `roots`: folders or pk3 files, an earlier one winning.

        Raises:
            AssetError: A root is missing, unreadable or absurdly large, or a pk3 file is broken
                or holds a name that leads out of it (`..`, an absolute path, a drive letter, a NUL
                byte). Such a pak is refused whole, and with it the archive: nothing is half loaded.
        """
        files: dict[str, _LooseFile | _PakEntry] = {}
        with ExitStack() as paks:

            def add(path: Path) -> None:
                pak = _Pak(path)
                paks.callback(pak.close)
                files.update(pak.entries())

            for root in reversed(roots):  # the winner is written last
                if not isdir(root):
                    add(root)
                    continue
                loose = _loose_files(root)
                inner = [name for name in loose if name.endswith(".pk3") and "/" not in name]
                # The engines compare in upper case, which puts `_` behind the letters.
                for name in sorted(inner, key=str.upper):
                    add(loose.pop(name).path)
                files.update(loose)
            return cls(roots, files, paks.pop_all())

    def close(self) -> None:
        """Close the pk3 files; their entries can no longer be read."""
        self._paks.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def exists(self, name: str) -> bool:
        """Tell whether there is such a file."""
        return normalise(name) in self._files

    def read(self, name: str) -> bytes:
        """Read a whole file.

        Raises:
            AssetError: There is no such file, it is larger than `MAX_FILE_BYTES` or than its pak
                states, damaged, encrypted, or compressed by a method other than deflate.
        """
        return self._file(name).read()

    def source(self, name: str) -> str:
        """Say where a file lies: `pak0.pk3:maps/q3dm1.bsp`, or a loose file's path."""
        return self._file(name).source

    def names(self, prefix: str = "", suffix: str = "") -> list[str]:
        """List the normalised names that start and end so, sorted."""
        prefix, suffix = prefix.replace("\\", "/").lower(), suffix.lower()
        return sorted(n for n in self._files if n.startswith(prefix) and n.endswith(suffix))

    def _file(self, name: str) -> _LooseFile | _PakEntry:
        file = self._files.get(normalise(name))
        if file is None:
            raise AssetError(name, expected=f"a file in {_listed(self._roots)}", found="none")
        return file


def search_path(extra: Sequence[Path] = ()) -> list[Path]:
    """List the game folders and pk3 files to look in, best first, none twice.

    These are `extra`, then what the environment variable FOLLOWSPOT_ASSETS lists (separated as in
    PATH), then the usual installs of OpenArena and Quake 3 that exist. A folder that holds
    `baseoa` or `baseq3` stands for those.

    Raises:
        AssetError: One of the first two kinds does not exist.
    """
    listed = os.environ.get("FOLLOWSPOT_ASSETS", "").split(os.pathsep)
    found: list[Path] = []
    for folder in [*extra, *(Path(text) for text in listed if text)]:
        if not isdir(folder) and not isfile(folder):
            place = "" if folder in extra else "environment variable FOLLOWSPOT_ASSETS"
            expected = "a game folder or a pk3 file"
            raise AssetError(str(folder), place=place, expected=expected, found="nothing there")
        found += _game_folders(folder) or [folder]
    for text in INSTALL_FOLDERS:
        folder = Path(expandvars(expanduser(text)))
        if folder.is_absolute():  # not another system's drive letter or unknown variable
            found += _game_folders(folder)
    return _distinct(found)


def list_levels(archive: Archive) -> list[str]:
    """List the levels' names, sorted: `maps/q3dm1.bsp` is `q3dm1`."""
    return [_level_name(name) for name in archive.names("maps/", ".bsp")]


def locate_level(name_or_path: str, search: Sequence[Path]) -> tuple[Archive, str]:
    """Find a level, and open the archive that it and its textures are read from.

    Args:
        name_or_path: One of four: a bsp file, whose game folder (the one above `maps`, else the
            file's own) is looked in first; a pk3 file that holds one level; a pk3 file and one of
            its levels, `some.pk3:name`; the name of a level in `search`, `q3dm1` or
            `maps/q3dm1.bsp`.
        search: Folders and pk3 files to look in besides, best first; see `search_path`.

    Returns:
        The archive, which the caller closes, and the level's normalised name in it.

    Raises:
        AssetError: There is no such level (the message proposes close names), a pk3 file does
            not tell which of its levels is meant, or a root cannot be opened.
    """
    path = Path(name_or_path)
    roots = list(search)
    name = _level_name(name_or_path)
    entry = f"maps/{name}.bsp"
    pak = _PAK_AND_LEVEL.fullmatch(name_or_path)
    if pak and isfile(pak["pak"]):
        roots.insert(0, Path(pak["pak"]))
        entry = f"maps/{_level_in_pak(roots[0], pak['level'])}.bsp"
    elif path.suffix.lower() == ".bsp" and isfile(path):
        folder = path.absolute().parent
        if folder.name.lower() == "maps":
            roots.insert(0, folder.parent)
            entry = f"maps/{path.name}"
        else:
            roots.insert(0, folder)
            entry = path.name

    archive = Archive.open(_distinct(roots))
    if archive.exists(entry):
        return archive, normalise(entry)
    with archive:
        found = _close_names(name, list_levels(archive))
    expected = f"a bsp or pk3 file, or the name of a level in {_listed(roots)}"
    raise AssetError(name_or_path, expected=expected, found=found)


def _level_in_pak(pak: Path, wanted: str | None) -> str:
    with Archive.open([pak]) as archive:
        levels = list_levels(archive)
    if wanted is None:
        if len(levels) == 1:
            return levels[0]
        expected = f"one level, or {pak}:NAME to pick one"
        raise AssetError(str(pak), expected=expected, found=", ".join(levels) or "no level")
    name = _level_name(wanted)
    if name not in levels:
        found = _close_names(name, levels)
        raise AssetError(str(pak), place=wanted, expected="a level in the pak", found=found)
    return name


def _level_name(text: str) -> str:
    return normalise(text).removeprefix("maps/").removesuffix(".bsp")


def _close_names(name: str, levels: Sequence[str]) -> str:
    close = difflib.get_close_matches(name, levels)
    return f"none; close names are {', '.join(close)}" if close else "none"


def _loose_files(root: Path) -> dict[str, _LooseFile]:
    """Gather the files below `root` by normalised name, following links but not in circles."""
    if not os.access(root, os.R_OK | os.X_OK):
        raise AssetError(str(root), expected="a readable folder", found="no permission")
    files: dict[str, _LooseFile] = {}
    pending: list[tuple[Path, str, tuple[Path, ...]]] = [(root, "", ())]
    met = 0
    while pending:
        folder, prefix, above = pending.pop()
        real = folder.resolve()
        if real in above:
            continue
        try:
            paths = sorted(folder.iterdir())
        except OSError:
            continue
        met += len(paths)
        if met > MAX_LOOSE_FILES:
            expected = f"a game folder of at most {MAX_LOOSE_FILES} files"
            raise AssetError(str(root), expected=expected, found="more")
        for path in paths:
            name = prefix + normalise(path.name)
            if isfile(path):  # not a broken link, nor a pipe that would block its reader
                files[name] = _LooseFile(path)
            elif isdir(path) and not path.name.startswith("."):
                pending.append((path, f"{name}/", (*above, real)))
    return files


def _game_folders(folder: Path) -> list[Path]:
    return [folder / name for name in GAME_FOLDERS if isdir(folder / name)]


def _distinct(paths: Sequence[Path]) -> list[Path]:
    first: dict[Path, Path] = {}
    for path in paths:
        first.setdefault(path.resolve(), path)
    return list(first.values())


def _listed(paths: Sequence[Path]) -> str:
    return ", ".join(map(str, paths)) or "a game folder (none is known; name one with --assets)"


def _refuse_unsafe_name(pak: Path, name: str) -> None:
    parts = name.replace("\\", "/").split("/")
    if not parts[0] or ".." in parts or re.match("[A-Za-z]:", name) or "\0" in name:
        expected = "relative names without '..', drive letter or NUL"
        raise AssetError(str(pak), place="an entry's name", expected=expected, found=repr(name))


def _refuse_absurd_size(source: str, size: int) -> None:
    if size > MAX_FILE_BYTES:
        raise AssetError(source, expected=f"at most {MAX_FILE_BYTES} bytes", found=str(size))


def _unreadable(path: Path, error: OSError) -> AssetError:
    return AssetError(str(path), expected="a readable file", found=error.strerror or str(error))
