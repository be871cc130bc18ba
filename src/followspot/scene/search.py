"""From what was typed to a scene file, and to its level and where its assets lie."""

from collections.abc import Sequence
from os.path import isfile
from pathlib import Path

import msgspec

from followspot.assets.archive import Archive
from followspot.assets.locate import file_of, locate_level, search_path
from followspot.assets.mesh_file import MESH_SUFFIXES
from followspot.assets.model_file import MODEL_SUFFIXES, root_of
from followspot.errors import AssetError, asked_by
from followspot.scene import scene_file
from followspot.scene.scene_file import SceneFile

BUILTIN = Path(__file__).parent.parent / "builtin"
"""Folder of the scenes and the pak that come with the package."""

_PROPS = (*MESH_SUFFIXES, *MODEL_SUFFIXES)


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
    file, folder = scene_file.read(path), path.parent
    beside = str(folder / file.level)
    wanted = beside if isfile(file_of(beside)) else file.level  # noqa: PTH113 - it never raises
    try:
        archive, entry = locate_level(wanted, search_roots(assets))
    except AssetError as error:
        if not wanted.startswith(error.source):
            raise  # of one of the roots
        with asked_by(name, "level"):
            raise
    try:
        return _with_props_beside(name, file, folder.absolute(), archive), archive, entry
    except BaseException:
        archive.close()
        raise


def _scene_path(name: str) -> Path | None:
    if name.lower().endswith(".toml"):
        return Path(name)
    return BUILTIN / f"{name}.toml" if name in builtin_scenes() else None


def _with_props_beside(name: str, file: SceneFile, folder: Path, archive: Archive) -> SceneFile:
    """The scene file with the props that lie beside it named as in the archive, where they come.

    What else lies in their folders is there for them alone: it decides nothing about the level.
    """
    entries = []
    for number, prop in enumerate(file.props):
        path, place = folder / prop.file, f"props[{number}].file"
        if isfile(path):  # noqa: PTH113 - it never raises
            root = root_of(path)
            called = root.relative_to(folder) if root.is_relative_to(folder) else root
            with asked_by(name, place):
                prefix = archive.put_beside(root, str(called))
            prop = msgspec.structs.replace(prop, file=f"{prefix}{path.relative_to(root)}")
        elif not archive.exists(prop.file) and prop.file.lower().endswith(_PROPS):
            expected = f"a file in {folder}, {archive.places}"
            raise AssetError(name, place=f"{place}: {prop.file}", expected=expected, found="none")
        entries.append(prop)
    return msgspec.structs.replace(file, props=tuple(entries))
