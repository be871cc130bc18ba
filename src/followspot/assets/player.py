"""Quake III players: a folder of three models that tags join, with skins and animations.

``models/players/NAME`` holds lower.md3 (legs), upper.md3 (torso) and head.md3, a skin for each of
them, and animation.cfg. What is missing or broken there is listed, and the rest stands.

Sources: ``CG_RegisterClientModelname`` and ``CG_Player`` of ioquake3's ``cg_players.c``,
``RE_RegisterSkin`` of its ``tr_image.c``.
"""

import difflib
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TypeVar

from followspot.assets.animation import Animation, AnimationConfig, parse_animation_config
from followspot.assets.archive import Archive, normalise
from followspot.assets.md3 import Md3Model, read_md3
from followspot.errors import AssetError

FOLDER = "models/players/"
PARTS = ("lower", "upper", "head")
DEFAULT_SKIN = "default"

_JOINTS = {"upper": ("lower", "tag_torso"), "head": ("upper", "tag_head")}
_PLAYED_BY = {"both": ("lower", "upper"), "legs": ("lower",), "torso": ("upper",)}

Read = TypeVar("Read")


@dataclass(frozen=True, eq=False)
class Part:
    """One of a player's models, dressed."""

    model: Md3Model
    textures: tuple[str | None, ...]
    """What each of the model's surfaces wears: a shader's or an image's normalised name, or None
    where the skin is missing or says nothing of it."""


@dataclass(frozen=True, eq=False)
class Player:
    """A player's parts, which tags join; Quake units, X forward, Z up, feet at about -24."""

    name: str
    """The folder's name."""
    skin: str
    """Which of its skins it wears: ``default``, ``red``, ``blue`` or another."""
    parts: dict[str, Part]
    """By the names in `PARTS`, in their order, without the missing ones."""
    config: AnimationConfig
    """What animation.cfg says, with every animation cut to the frames of the parts that play it;
    without one, there are no animations, and frame 0 is all there is to show."""
    problems: tuple[AssetError, ...]
    """What is missing, broken or more than the parts have."""


def list_players(archive: Archive) -> list[str]:
    """List the players' names, sorted: every folder with a part in it."""
    found = (name.removeprefix(FOLDER).split("/") for name in archive.names(FOLDER, ".md3"))
    parts = {f"{part}.md3" for part in PARTS}
    return sorted({path[0] for path in found if len(path) == 2 and path[1] in parts})


def load_player(archive: Archive, name: str) -> Player:
    """Read a player.

    Args:
        archive: Where its files are read from.
        name: As in the game: ``sarge``, or ``sarge/red`` for another skin than the default. A
            player without a default one wears the first that all three parts have.

    Raises:
        AssetError: There is no such player (the message proposes close names) or skin, or none of
            its parts can be read. All else that is wrong is in `Player.problems`.
    """
    name, _, asked = normalise(name).partition("/")
    folder = f"{FOLDER}{name}/"
    skin = asked or _first_skin(archive, folder)
    players = list_players(archive)
    if name not in players:
        close = ", ".join(difflib.get_close_matches(name, players)) or ", ".join(players)
        expected = "a folder with lower.md3, upper.md3 and head.md3"
        found = f"none; there are {close}" if close else "none"
        raise AssetError(folder, expected=expected, found=found)
    if asked and not any(archive.exists(f"{folder}{part}_{asked}.skin") for part in PARTS):
        expected = "a skin: " + (", ".join(_skins(archive, folder)) or "none is there")
        raise AssetError(folder, place="skin", expected=expected, found=asked)

    problems: list[AssetError] = []

    def read(entry: str, parse: Callable[[bytes, str], Read]) -> Read | None:
        try:
            return parse(archive.read(entry), archive.source(entry))
        except AssetError as error:
            problems.append(error)
            return None

    models = {part: read(f"{folder}{part}.md3", read_md3) for part in PARTS}
    if not any(models.values()):
        raise problems[0]
    if skin not in (asked, DEFAULT_SKIN):
        found = f"none; it wears {skin}"
        problems.append(AssetError(folder, expected=f"*_{DEFAULT_SKIN}.skin", found=found))
    parts: dict[str, Part] = {}
    for part, model in models.items():
        if model is not None:
            entry = f"{folder}{part}_{skin}.skin"
            worn = read(entry, lambda data, source: parse_skin(data.decode("latin-1"), source))
            parts[part] = Part(model, tuple((worn or {}).get(s.name) for s in model.surfaces))
            if worn is not None:
                problems += _undressed(parts[part], archive.source(entry))
    entry = f"{folder}animation.cfg"
    config = read(
        entry, lambda data, source: parse_animation_config(data.decode("latin-1"), source)
    )
    problems += _unjoined(parts)
    if config is None:
        config = AnimationConfig(animations={})
    else:
        config, excess = _fitted(config, parts, archive.source(entry))
        problems += excess
    return Player(name, skin, parts, config, tuple(problems))


def _skins(archive: Archive, folder: str) -> list[str]:
    """Names of the skins that any part of a player has."""
    starts = [f"{folder}{part}_" for part in PARTS]
    return sorted(
        {
            name.removeprefix(start).removesuffix(".skin")
            for start in starts
            for name in archive.names(start, ".skin")
        }
    )


def _first_skin(archive: Archive, folder: str) -> str:
    """The default skin, unless no part of a player has that and all have another."""
    starts = [f"{folder}{part}_" for part in PARTS]
    if any(archive.exists(f"{start}{DEFAULT_SKIN}.skin") for start in starts):
        return DEFAULT_SKIN
    found = [
        {name.removeprefix(start) for name in archive.names(start, ".skin")} for start in starts
    ]
    common = sorted(set.intersection(*found))
    return common[0].removesuffix(".skin") if common else DEFAULT_SKIN


def parse_skin(text: str, source: str) -> dict[str, str]:
    """Parse a ``.skin`` file: lines of ``surface,texture``.

    Lines about tags, and surfaces without a texture, are passed over.

    Args:
        text: The whole file.
        source: Its name for errors.

    Returns:
        Shader's or image's normalised name by surface, both in lower case; the first line that
        names a surface counts, as in the game.

    Raises:
        AssetError: A line is none of the above; with its number.
    """
    textures: dict[str, str] = {}
    for number, line in enumerate(text.replace("\r\n", "\n").replace("\r", "\n").split("\n"), 1):
        line = line.partition("//")[0].strip(" \t\0")
        surface, comma, texture = (word.strip('" \t') for word in line.partition(","))
        if not line or "tag_" in surface.lower():
            continue
        if not surface or not comma:
            place, found = f"line {number}", repr(line[:40])
            raise AssetError(source, place=place, expected="surface,texture", found=found)
        if texture:  # OpenArena takes off a hat by leaving it out
            textures.setdefault(surface.lower(), normalise(texture))
    return textures


def _undressed(part: Part, skin_source: str) -> list[AssetError]:
    dressed = zip(part.model.surfaces, part.textures, strict=True)
    bare = (surface for surface, texture in dressed if texture is None and surface.indices.size)
    return [
        AssetError(skin_source, place=name, expected="a line surface,texture", found="none")
        for name in dict.fromkeys(surface.name for surface in bare)
    ]


def _unjoined(parts: dict[str, Part]) -> list[AssetError]:
    """Tell which parts have another to carry but no tag for it."""
    return [
        AssetError(parts[below].model.source, place=tag, expected="a tag", found="none")
        for part, (below, tag) in _JOINTS.items()
        if part in parts and below in parts and tag not in parts[below].model.tags
    ]


def _fitted(
    config: AnimationConfig, parts: dict[str, Part], source: str
) -> tuple[AnimationConfig, list[AssetError]]:
    """Cut animations to the frames that there are, and tell which needed it."""
    animations: dict[str, Animation] = {}
    problems: list[AssetError] = []
    for name, animation in config.animations.items():
        players = [parts[p] for p in _PLAYED_BY[name.partition("_")[0]] if p in parts]
        frame_count = min((len(part.model.frames) for part in players), default=1)
        animations[name] = animation.clipped(frame_count)
        if players and animations[name] != animation:
            last = animation.first + animation.count - 1
            expected, found = f"frames below {frame_count}", f"{animation.first} to {last}"
            problems.append(AssetError(source, place=name, expected=expected, found=found))
    return replace(config, animations=animations), problems
