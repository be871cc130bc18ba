"""From a name to a figure: its model, what it wears, and what of that is missing."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

from followspot.assets import image
from followspot.assets.archive import Archive, normalise
from followspot.assets.md2 import Md2Model, read_md2
from followspot.assets.md3 import Md3Model, read_md3
from followspot.assets.mesh_file import MESH_SUFFIXES
from followspot.assets.model_file import (
    MODEL_SUFFIXES,
    find_model_image,
    images_beside,
    locate_model,
)
from followspot.assets.player import DEFAULT_SKIN, load_player, parse_skin
from followspot.assets.script_files import Scripts, load_scripts
from followspot.assets.shader_script import ShaderScript
from followspot.errors import AssetError
from followspot.scene import figure, script_material
from followspot.scene.deform import RIGID
from followspot.scene.figure import WHITE, Figure
from followspot.scene.material import Material

PLAYER = "player:"
"""What a player's name begins with, to tell it from a file's."""


def is_model(name: str) -> bool:
    """Whether a name means a model, a mesh or a player, not a level."""
    return name.startswith(PLAYER) or name.lower().endswith((*MODEL_SUFFIXES, *MESH_SUFFIXES))


def open_archive(name: str, search: Sequence[Path]) -> tuple[Archive, str]:
    """The archive that a model named on the command line is read from, and its name there.

    Raises:
        AssetError: there is no such file, or a root cannot be opened.
    """
    if name.startswith(PLAYER):
        return Archive.open(search), name
    return locate_model(name, search)


class FigureFiles:
    """Reads figures from an archive, each once.

    Args:
        archive: Where models, skins and images are looked for.
        find_script: A shader's name to its script, if it has one.

    Attributes:
        missing: Images that were not found, by name, with the names that were tried.
        problems: What else is missing or broken and stands in white.
    """

    def __init__(self, archive: Archive, find_script: Callable[[str], ShaderScript | None]) -> None:
        self._archive = archive
        self._find_script = find_script
        self._figures: dict[tuple[str, str | None], Figure] = {}
        self._scripts_beside: dict[str, Scripts] = {}
        self.missing: dict[str, list[str]] = {}
        self.problems: list[AssetError] = []

    def has(self, name: str) -> bool:
        """Whether the archive has a file of that name."""
        return self._archive.exists(name)

    def open(self, name: str, skin: str | None = None) -> Figure:
        """Read a figure.

        Args:
            name: ``player:sarge``, or a model's name in the archive, ``models/x/y.md3``.
            skin: Which skin it wears, by its name; none is the default or first one.

        Raises:
            AssetError: there is no such model or player or skin, or it cannot be read.
        """
        key = name, skin
        if key not in self._figures:
            self._figures[key] = self._read(name, skin)
        return self._figures[key]

    def _read(self, name: str, skin: str | None) -> Figure:
        if name.startswith(PLAYER):
            player = name.removeprefix(PLAYER)
            loaded = load_player(self._archive, f"{player}/{skin}" if skin else player)
            self.problems += loaded.problems
            return figure.from_player(loaded, lambda worn: self.material(worn, None))
        entry = normalise(name)
        if not entry.endswith(MODEL_SUFFIXES):
            expected = f"player:NAME or a file {' or '.join(MODEL_SUFFIXES)}"
            raise AssetError(name, expected=expected, found="another name")
        data, source = self._archive.read(entry), self._archive.source(entry)
        if entry.endswith(".md2"):
            model = read_md2(data, source)
            return figure.from_md2(name, model, self._md2_skin(entry, model, skin))
        parts = read_md3(data, source)
        textures = self._md3_textures(entry, parts, skin)
        return figure.from_md3(name, parts, textures, lambda worn: self.material(worn, entry))

    def material(self, name: str, entry: str | None) -> Material:
        """The material of a shader's or an image's name; images may lie beside a model's entry."""

        def find(wanted: str) -> str | None:
            if entry is None:
                found, tried = image.find_image(self._archive, wanted)
            else:
                found, tried = find_model_image(self._archive, entry, wanted)
            if found is None:
                self.missing[wanted] = tried
            return found

        made = script_material.from_script(name, self._script(name, entry or ""), find)
        # Vertices of models have no colours, and move by their frames alone.
        layer = made.layer and replace(made.layer, fades=False, by_vertex=None)
        return replace(made, layer=layer, deforms=RIGID)

    def _script(self, name: str, entry: str) -> ShaderScript | None:
        """A shader's script; models that lie in no root bring their own."""
        folder = self._archive.beside(entry)
        if not folder:
            return self._find_script(name)
        if folder not in self._scripts_beside:
            self._scripts_beside[folder] = load_scripts(self._archive, folder)
            self.problems += self._scripts_beside[folder].problems
        script = self._scripts_beside[folder].find(name)
        if script is None:
            return self._find_script(name)
        self.problems += [problem for problem in script.problems if problem not in self.problems]
        return script

    def _md2_skin(self, entry: str, model: Md2Model, skin: str | None) -> Material:
        """The skin of a name, or the first one there is: as the file names them, or beside it."""
        named = {name: find_model_image(self._archive, entry, name) for name in model.skins}
        images = [found for found, _ in named.values() if found is not None]
        images += [i for i in images_beside(self._archive, entry) if i not in images]
        if skin is not None:
            wanted, tried = find_model_image(self._archive, entry, skin)
            if wanted is None:
                expected = "a skin: " + (", ".join(images) or "none is there")
                raise AssetError(model.source, place="skin", expected=expected, found=skin)
            images.insert(0, wanted)
        if images:
            return Material(images[0], images[0])
        for name, (_, tried) in named.items():
            self.missing[name] = tried
        if not named:
            stem = entry.rpartition(".")[0]
            self.missing[stem] = image.find_image(self._archive, stem)[1]
        return WHITE

    def _md3_textures(self, entry: str, model: Md3Model, skin: str | None) -> list[str | None]:
        """What each surface wears: a skin's textures, else what the file itself says."""
        own = [next(iter(surface.shaders), None) or None for surface in model.surfaces]
        stem = entry.rpartition(".")[0]
        file = f"{stem}_{skin or DEFAULT_SKIN}.skin"
        if skin is None and not self._archive.exists(file):
            return own
        if not self._archive.exists(file):
            names = (f.removeprefix(f"{stem}_") for f in self._archive.names(f"{stem}_", ".skin"))
            there_are = ", ".join(name.removesuffix(".skin") for name in names) or "none is there"
            raise AssetError(
                model.source, place="skin", expected=f"a skin: {there_are}", found=skin or "none"
            )
        worn = parse_skin(self._archive.read(file).decode("latin-1"), self._archive.source(file))
        return [
            worn.get(surface.name, name) for surface, name in zip(model.surfaces, own, strict=True)
        ]
