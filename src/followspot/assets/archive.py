"""Game folders and pk3 files as one tree with case-insensitive names.

Quake 3 keeps its files in game folders (`baseq3`, OpenArena's `baseoa`): loose files, and pk3
files, which are zip archives. Look-ups ignore case and the direction of slashes, and where
several files share a name, one wins:

- an earlier root wins over a later one;
- within a folder, a loose file wins over the pk3 files in it;
- of the pk3 files in a folder, the later by name wins;
- within a pk3 file, the later entry wins.

Names are gathered when the archive is opened, or a folder put beside it, and only a gathered name
can be read: no name that stands in a level or a script can reach a file outside the roots.
"""
# ruff: noqa: PTH112, PTH113 - these two of os.path, unlike pathlib's, never raise.

import os
import weakref
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from os.path import isdir, isfile, realpath
from pathlib import Path
from typing import Self

from followspot.assets.pak import Pak, PakEntry, refuse_absurd_size, unreadable
from followspot.errors import AssetError

BESIDE = "beside:/"
"""What the names of files begin with that lie in no root; see `Archive.put_beside`."""

MAX_LOOSE_FILES = 100_000
"""Most files and folders below one root: a home folder or a whole disk is no game folder."""


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
            refuse_absurd_size(self.source, self.path.stat().st_size)
            return self.path.read_bytes()
        except OSError as error:
            raise unreadable(self.path, error) from error


@dataclass(frozen=True, slots=True)
class _HeldFile:
    data: bytes
    source: str

    def read(self) -> bytes:
        return self.data


class _Paks:
    """The open pk3 files. One that several folders link to, under its own name, is read once."""

    def __init__(self) -> None:
        self._opened = ExitStack()
        self._read: dict[tuple[str, str], dict[str, PakEntry]] = {}

    def entries(self, path: Path) -> dict[str, PakEntry]:
        """A pk3 file's entries by normalised name."""
        key = realpath(path), path.name  # messages tell the name
        if key not in self._read:
            pak = Pak(path)
            with ExitStack() as if_it_fails:
                if_it_fails.callback(pak.close)
                self._read[key] = {normalise(entry.name): entry for entry in pak.entries()}
                self._opened.push(if_it_fails.pop_all())
        return self._read[key]

    def close(self) -> None:
        self._opened.close()


class Archive:
    """The files of several folders and pk3 files, read by name; a context manager.

    Names may be given in any case and with either slash. Reading is safe from several threads.

    Attributes:
        problems: The pk3 files in folders that were left out, and why.
    """

    def __init__(
        self,
        roots: Sequence[Path],
        files: dict[str, _LooseFile | PakEntry],
        places: dict[str, int],
        problems: Sequence[AssetError],
        paks: _Paks,
    ) -> None:
        self.problems = tuple(problems)
        self._roots = roots
        self._files: dict[str, _LooseFile | PakEntry | _HeldFile] = {**files}
        self._places = places
        self._beside: set[str] = set()
        self._paks = paks
        self._close = weakref.finalize(self, paks.close)

    @classmethod
    def open(cls, roots: Sequence[Path]) -> Self:
        """Gather the names in `roots`: folders or pk3 files, an earlier one winning.

        Raises:
            AssetError: A root is missing, unreadable or absurdly large, or is a pk3 file that is
                broken or holds a name that leads out of it (`..`, an absolute path, a drive letter,
                a NUL byte). Such a pak in a folder is left out whole and is one of the `problems`:
                nothing is half loaded, and a bad download stops no game.
        """
        files: dict[str, _LooseFile | PakEntry] = {}
        places: dict[str, int] = {}
        problems: list[AssetError] = []
        paks = _Paks()
        with ExitStack() as if_it_fails:
            if_it_fails.callback(paks.close)
            for place, root in reversed([*enumerate(roots)]):  # the winner is written last
                found = _in_folder(root, paks, problems) if isdir(root) else paks.entries(root)
                files.update(found)
                places.update(dict.fromkeys(found, place))
            if_it_fails.pop_all()
        return cls(roots, files, places, problems, paks)

    @property
    def places(self) -> str:
        """The folders and pk3 files that it was opened with, for messages."""
        roots = ", ".join(map(str, self._roots))
        return roots or "a game folder (none is known; name one with --assets)"

    def close(self) -> None:
        """Close the pk3 files; their entries can no longer be read.

        An archive that nobody holds any more closes itself.
        """
        self._close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def add(self, name: str, data: bytes, source: str) -> str:
        """Put in a file that lies inside of another one.

        Returns:
            Its normalised name.
        """
        name = normalise(name)
        self._files[name] = _HeldFile(data, source)
        self._places.pop(name, None)
        return name

    def put_beside(self, folder: Path, name: str) -> str:
        """Gather the names in a folder whose files stand in for none of the others.

        They begin with what is returned: `BESIDE`, and the name that the folder is to have.

        Raises:
            AssetError: The folder is unreadable or absurdly large. As with roots, a broken pk3
                file in it is one of the `problems`.
        """
        prefix = f"{BESIDE}{normalise(name)}/".replace("//", "/")
        if prefix not in self._beside:
            problems: list[AssetError] = []
            found = _in_folder(folder, self._paks, problems)
            self._files.update({prefix + inside: file for inside, file in found.items()})
            self._beside.add(prefix)
            self.problems += tuple(problems)
        return prefix

    def beside(self, name: str) -> str:
        """What `put_beside` has returned of a file's folder; empty for a file in the roots."""
        name = normalise(name)
        return max((p for p in self._beside if name.startswith(p)), key=len, default="")

    def exists(self, name: str) -> bool:
        """Tell whether there is such a file."""
        return normalise(name) in self._files

    def read(self, name: str) -> bytes:
        """Read a whole file.

        Raises:
            AssetError: There is no such file, or it cannot be read; see `PakEntry.read`.
        """
        return self._file(name).read()

    def source(self, name: str) -> str:
        """Say where a file lies: `pak0.pk3:maps/q3dm1.bsp`, or a loose file's path."""
        return self._file(name).source

    def root(self, name: str) -> int:
        """Say which of the roots a file is read from, counted from 0; -1 for one in none."""
        self._file(name)
        return self._places.get(normalise(name), -1)

    def names(self, prefix: str = "", suffix: str = "") -> list[str]:
        """List the normalised names that start and end so, sorted."""
        prefix, suffix = prefix.replace("\\", "/").lower(), suffix.lower()
        return sorted(n for n in self._files if n.startswith(prefix) and n.endswith(suffix))

    def _file(self, name: str) -> _LooseFile | PakEntry | _HeldFile:
        file = self._files.get(normalise(name))
        if file is None:
            raise AssetError(name, expected=f"a file in {self.places}", found="none")
        return file


def _in_folder(
    root: Path, paks: _Paks, problems: list[AssetError]
) -> dict[str, _LooseFile | PakEntry]:
    """Gather the files in a game folder and in its good pk3 files by normalised name."""
    files: dict[str, _LooseFile | PakEntry] = {}
    loose = _loose_files(root)
    inner = [name for name in loose if name.endswith(".pk3") and "/" not in name]
    # The engines compare in upper case, which puts `_` behind the letters.
    for name in sorted(inner, key=str.upper):
        try:
            files.update(paks.entries(loose.pop(name).path))
        except AssetError as error:
            problems.append(error)
    return {**files, **loose}


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
