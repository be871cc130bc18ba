"""Where levels lie: the games' install folders, and levels named in several ways."""
# ruff: noqa: PTH111, PTH112, PTH113 - these three of os.path, unlike pathlib's, never raise.

import difflib
import os
import re
from collections.abc import Sequence
from os.path import expanduser, expandvars, isdir, isfile
from pathlib import Path

from followspot.assets.archive import Archive, normalise
from followspot.errors import AssetError

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

_PAK_AND_LEVEL = re.compile(r"(?P<pak>.+\.pk3)(:(?P<level>.+))?", re.IGNORECASE)


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


def locate_level(
    name_or_path: str, search: Sequence[Path], others: Sequence[str] = ()
) -> tuple[Archive, str]:
    """Find a level, and open the archive that it and its textures are read from.

    Args:
        name_or_path: One of four: a bsp file, whose game folder (the one above `maps`, else the
            file's own) is looked in first; a pk3 file that holds one level; a pk3 file and one of
            its levels, `some.pk3:name`; the name of a level in `search`, `q3dm1` or
            `maps/q3dm1.bsp`.
        search: Folders and pk3 files to look in besides, best first; see `search_path`.
        others: Names of what is no level but could have been meant, to be proposed likewise.

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
        found = _close_names(name, [*others, *list_levels(archive)])
    found += "".join(f"; left out: {problem}" for problem in archive.problems)
    expected = f"a bsp or pk3 file, or the name of a level in {archive.places}"
    raise AssetError(name_or_path, expected=expected, found=found)


def file_of(name_or_path: str) -> Path:
    """The file that a level's name may mean: of `some.pk3:name` the pk3 file."""
    pak = _PAK_AND_LEVEL.fullmatch(name_or_path)
    return Path(pak["pak"] if pak else name_or_path)


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
    close = difflib.get_close_matches(name, dict.fromkeys(levels))
    return f"none; close names are {', '.join(close)}" if close else "none"


def _game_folders(folder: Path) -> list[Path]:
    return [folder / name for name in GAME_FOLDERS if isdir(folder / name)]


def _distinct(paths: Sequence[Path]) -> list[Path]:
    first: dict[Path, Path] = {}
    for path in paths:
        first.setdefault(path.resolve(), path)
    return list(first.values())
