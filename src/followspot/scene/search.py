"""From what was typed to a scene file, and to its level and where its assets lie."""

from collections.abc import Sequence
from os.path import isfile
from pathlib import Path

import msgspec

from followspot.assets.archive import Archive
from followspot.assets.locate import file_of, locate_level, search_path
from followspot.assets.model_file import root_of
from followspot.errors import AssetError, asked_by
from followspot.scene import scene_file
from followspot.scene.scene_file import SceneFile

BUILTIN = Path(__file__).parent.parent / "builtin"
"""Folder of the scenes and the pak that come with the package."""


def search_roots(assets: Sequence[str | Path]) -> list[Path]:
    """Folders and pk3 files to look in: those given, the usual installs, the package's own."""
    return [*search_path([Path(folder) for folder in assets]), *sorted(BUILTIN.glob("*.pk3"))]


def builtin_scenes() -> list[str]:
    """Names of the scenes that come with the package."""
    return sorted(path.stem for path in BUILTIN.glob("*.toml"))


def find_scene(name: str, assets: Sequence[str | Path]) -> tuple[SceneFile, Archive, str]:
    """What `load` is to open.

    Args:
        name: As for `load`.
        assets: As for `load`.

    Returns:
        The scene file, of a level alone one that says no more than its name; the archive, which
        the caller closes; the level's name in it.

    Raises:
        AssetError: there is no such scene or level, or the scene file cannot be used.
    """
    path = _scene_path(name)
    if path is None:
        located = locate_level(name, search_roots(assets), others=builtin_scenes())
        return SceneFile(level=name), *located
    file, of_props = _with_props_beside(scene_file.read(path), path.parent.absolute())
    beside = str(path.parent / file.level)
    wanted = beside if isfile(file_of(beside)) else file.level  # noqa: PTH113 - it never raises
    roots = [*of_props, *search_roots(assets)]
    try:
        return file, *locate_level(wanted, roots)
    except AssetError as error:
        if not wanted.startswith(error.source):
            raise  # of one of the roots
        with asked_by(name, "level"):
            raise


def _scene_path(name: str) -> Path | None:
    if name.lower().endswith(".toml"):
        return Path(name)
    return BUILTIN / f"{name}.toml" if name in builtin_scenes() else None


def _with_props_beside(file: SceneFile, folder: Path) -> tuple[SceneFile, list[Path]]:
    """The scene file with the props that lie beside it named as in an archive, and its roots."""
    entries, roots = [], []
    for prop in file.props:
        path = folder / prop.file
        if isfile(path):  # noqa: PTH113 - it never raises
            roots.append(root_of(path))
            prop = msgspec.structs.replace(prop, file=str(path.relative_to(roots[-1])))
        entries.append(prop)
    return msgspec.structs.replace(file, props=tuple(entries)), roots
