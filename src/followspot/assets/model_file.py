"""Where models lie, and the images that they wear."""
# ruff: noqa: PTH113 - this one of os.path, unlike pathlib's, never raises.

from collections.abc import Sequence
from os.path import isfile
from pathlib import Path

from followspot.assets.archive import Archive, normalise
from followspot.assets.image import IMAGE_SUFFIXES, find_image
from followspot.errors import AssetError

MODEL_SUFFIXES = (".md2", ".md3")

_GAME_FOLDER_HOLDS = ("*.pk3", "scripts", "textures")


def locate_model(name_or_path: str, search: Sequence[Path]) -> tuple[Archive, str]:
    """Find a model, and open the archive that it and its images are read from.

    Args:
        name_or_path: A file, whose folder is looked in first (the game folder above ``models``
            where it lies in one); or the name of one in `search`, ``models/x/y.md3``.
        search: Folders and pk3 files to look in besides, best first.

    Returns:
        The archive, which the caller closes, and the model's normalised name in it.

    Raises:
        AssetError: There is no such model, or a root cannot be opened.
    """
    path, entry = Path(name_or_path), normalise(name_or_path)
    roots = list(search)
    if isfile(path):
        root = root_of(path.absolute())
        roots.insert(0, root)
        entry = normalise(str(path.absolute().relative_to(root)))
    archive = Archive.open(roots)
    if archive.exists(entry):
        return archive, entry
    archive.close()
    expected = "a file, or the name of one in a game folder or pk3 file"
    raise AssetError(name_or_path, expected=expected, found="none")


def find_model_image(archive: Archive, entry: str, name: str) -> tuple[str | None, list[str]]:
    """Find the image that a model calls so: by its path in the game, else beside the model.

    Of a model that lies in none of the archive's roots, its path in the model's folder comes first.

    Args:
        archive: Where the model is read from.
        entry: The model's name in it.
        name: As the model writes it; see `image.find_image`.

    Returns:
        The file's normalised name, or None, and the names that were tried, in order.
    """
    own = archive.beside(entry)
    beside = _folder(entry) + normalise(name).rpartition("/")[2]
    tried: list[str] = []
    for wanted in (own + name, name, beside) if own else (name, beside):
        found, more = find_image(archive, wanted)
        tried += [other for other in more if other not in tried]
        if found is not None:
            return found, tried
    return None, tried


def images_beside(archive: Archive, entry: str) -> list[str]:
    """List images that are a model's by their names alone: ``tris.pcx``, ``tris2.png``.

    These lie in its folder and start with its name; the one called as the model comes first.
    """
    folder, stem = _folder(entry), entry.rpartition(".")[0]
    images = [
        name
        for name in archive.names(stem)
        if name.endswith(IMAGE_SUFFIXES) and _folder(name) == folder
    ]
    return sorted(images, key=lambda name: (name.rpartition(".")[0] != stem, name))


def _folder(entry: str) -> str:
    head, slash, _ = entry.rpartition("/")
    return head + slash


def root_of(path: Path) -> Path:
    """The game folder that a model's file lies in, above ``models``; else the file's own folder."""
    for folder in path.parents:
        if folder.name.lower() == "models":
            game = folder.parent
            if any(any(game.glob(pattern)) for pattern in _GAME_FOLDER_HOLDS):
                return game
    return path.parent
