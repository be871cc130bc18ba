"""The characters of a scene, from what its file says of them."""

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from followspot.assets.archive import Archive
from followspot.assets.player import list_players
from followspot.errors import AssetError, UsageError, asked_by
from followspot.game import EYE_HEIGHT, STEP_HEIGHT
from followspot.scene import walk
from followspot.scene.camera import Camera
from followspot.scene.cast_file import CharacterEntry
from followspot.scene.character import Character
from followspot.scene.figure import Figure, Tracks
from followspot.scene.figure_file import PLAYER, FigureFiles
from followspot.scene.ground import Ground
from followspot.scene.walk import Walk

_ACTOR_SECONDS = 0.37
"""Clocks of neighbouring actors differ by so much, lest they move as one."""


def characters(
    entries: Sequence[CharacterEntry], files: FigureFiles, ground: Ground, source: str
) -> list[Character]:
    """The characters that a scene file names.

    Args:
        entries: In the file's order.
        files: Where their models come from.
        ground: What they stand and walk on.
        source: The scene file's name for errors.

    Raises:
        AssetError: a model or animation is not there, or a path is none.
    """
    found = []
    for number, entry in enumerate(entries):
        try:
            found.append(_character(entry, files, ground, source, f"characters[{number}]"))
        except UsageError as error:
            expected, _, got = str(error).removeprefix("expected ").partition(", found ")
            place = f"characters[{number}].path"
            raise AssetError(source, place=place, expected=expected, found=got) from None
    return found


def _character(
    entry: CharacterEntry, files: FigureFiles, ground: Ground, source: str, key: str
) -> Character:
    with asked_by(source, f"{key}.model", skin=f"{key}.{'skin' if entry.skin else 'model'}"):
        figure = files.open(entry.model, entry.skin)
    with asked_by(source, f"{key}.animation"):
        first = figure.tracks(entry.animation)
    plays = [(first, 0.0)]
    if entry.path is None:
        assert entry.position is not None, entry
        way = walk.standing(entry.position, entry.yaw)
    else:
        if entry.animation is None:
            first = _running(figure)
            plays = [(first, 0.0)]
        speed = entry.speed or walk.fitting_speed(figure, first.legs)
        way = walk.along(entry.path, speed, is_closed=entry.closed)
        if not entry.closed:
            plays.append((figure.tracks(), way.length / speed))
    for number, then in enumerate(entry.then):
        with asked_by(source, f"{key}.then[{number}].animation"):
            plays.append((figure.tracks(then.animation), then.at))
    plays[1:] = sorted(plays[1:], key=lambda play: play[1])
    if entry.on_ground:
        way = on_ground(way, ground, figure, first)
    return Character(figure, way, tuple(plays), entry.clock)


def _running(figure: Figure) -> Tracks:
    """How a figure gets on: it runs, if it can."""
    runs = "run" in figure.animations or "legs_run" in figure.animations
    return figure.tracks("run" if runs else None)


def on_ground(way: Walk, ground: Ground, figure: Figure, tracks: Tracks) -> Walk:
    """A way whose places are as high over the floor as a figure's origin is over its feet.

    It may be given as far below the floor as a step is high.
    """
    above = way.places[:, :3] + (0.0, 0.0, STEP_HEIGHT)
    floor = ground.below(above)
    places = way.places.copy()
    found = floor < above[:, 2]
    places[:, 2] = np.where(found, floor + figure.floor_below(tracks.legs), places[:, 2])
    return replace(way, places=places)


def actors(
    archive: Archive, cameras: Iterable[Camera], files: FigureFiles, ground: Ground
) -> list[Character]:
    """Players at a level's spawn points, one after another of those that there are.

    Players that cannot be read are listed in `FigureFiles.problems` and left out.

    Args:
        archive: Its players are taken.
        cameras: At the spawn points, at eye height.
        files: Where the players come from.
        ground: What they stand on.
    """
    players = []
    for name in list_players(archive):
        try:
            players.append(files.open(PLAYER + name))
        except AssetError as error:
            files.problems.append(error)
    found = []
    for number, camera in enumerate(cameras):
        if not players:
            break
        figure = players[number % len(players)]
        tracks = figure.tracks()
        way = walk.standing(camera.position - (0.0, 0.0, EYE_HEIGHT), camera.yaw)
        way = on_ground(way, ground, figure, tracks)
        found.append(Character(figure, way, ((tracks, 0.0),), clock=number * _ACTOR_SECONDS))
    return found
