"""What was changed in the window, into the scene file: those keys alone.

A scene that has no file of its own, a level or one that comes with the package, gets a new one.
"""

import os
from dataclasses import replace
from itertools import count
from os.path import isfile, lexists, relpath
from pathlib import Path

from followspot.errors import AssetError, FollowspotError, UnwritableError, UsageError
from followspot.present import files
from followspot.present.viewer import scene_text
from followspot.present.viewer.copying import as_toml
from followspot.present.viewer.state import State
from followspot.scene import figure_file, scene_file
from followspot.scene.camera import Camera
from followspot.scene.path import CameraPath
from followspot.scene.scene import spawn_cameras
from followspot.scene.scene_file import SceneFile
from followspot.scene.search import BUILTIN, builtin_scenes

# ruff: noqa: PTH113 - isfile of os.path, unlike pathlib's, never raises.


def own_file(state: State) -> Path | None:
    """The scene file that is open, unless it comes with the package."""
    name = state.scene.name
    return Path(name) if name.lower().endswith(".toml") else None


def new_file(state: State) -> Path:
    """A free name for the file of a scene that has none."""
    folder = state.recording.place
    stem = Path(state.scene.name).stem
    names = (f"{stem}-{n}.toml" if n else f"{stem}.toml" for n in count())
    return next(folder / name for name in names if not lexists(folder / name))


def saved(state: State) -> State:
    """The state as it is in its scene file, after that has been written; or told why it is not.

    Switched-off lights are on in the file, which has no word for them.
    """
    try:
        path = own_file(state) or _chosen_file(state)
        before = _text(state, path)
        text = _changed(state, before, path)
        file = scene_file.parse(text, str(path))  # what cannot be read is not written
        if text != before or not lexists(path):
            _write(path, text)
    except FollowspotError as error:
        return replace(state, notice=str(error))
    are_off = not all(lamp.is_on for lamp in state.lamps)
    told = ", with its lights on" if are_off and file.lights is not None else ""
    return replace(_as_file(state, file, path), notice=f"{path} is saved{told}.")


def _chosen_file(state: State) -> Path:
    if not state.save_as.strip():
        return new_file(state)
    path = state.recording.place / state.save_as.strip()
    path = path if path.suffix.lower() == ".toml" else Path(f"{path}.toml")
    if lexists(path):
        raise UsageError(f"{path}: it is there already, and only its own scene is saved into it")
    return path


def _text(state: State, path: Path) -> str:
    """The file as it is, or as a new one begins."""
    name = state.scene.name
    if own_file(state) is not None:
        scene_file.read(path)  # which tells best what is wrong
        return path.read_bytes().decode("utf-8-sig")
    if name in builtin_scenes():
        return (BUILTIN / f"{name}.toml").read_text(encoding="utf-8")
    if figure_file.is_model(name):
        raise UsageError(f"{name} is a model: only levels have scene files")
    level = relpath(name, path.parent) if isfile(name) else name
    return scene_text.new(level)


def _changed(state: State, text: str, path: Path) -> str:
    """The text with what the state has otherwise."""
    file = scene_file.parse(text, str(path))
    scene, lit, is_new = state.scene, state.lit, own_file(state) is None
    document = scene_text.Document(text, str(path))
    document.put_number("environment_constant", lit.environment_constant, file.environment_constant)
    known = [entry.light() for entry in file.lights or ()]
    opened = 0 if scene.lights_chosen else len(scene.lights)
    if len(known) != opened:
        expected = f"{opened} lights, as when it was opened"
        raise AssetError(str(path), place="lights", expected=expected, found=str(len(known)))
    if is_new or [lamp.light for lamp in state.lamps] != list(scene.lights):
        document.put_number("ambient", lit.ambient, file.ambient)
        document.put_lights([(lamp.light, lamp.number) for lamp in state.lamps], known)
    own = _own_cameras(state, file)
    for name, camera in own.items() if own or not is_new else [("start", state.camera)]:
        entry = file.cameras.get(name)
        document.put_camera(name, camera, None if entry is None else entry.camera(name))
    for name, route in scene.paths.items():
        if name not in file.paths and isinstance(route, CameraPath):
            document.put_path(name, route)
    document.put_settings(state.look.settings(state.settings), file.settings)
    return document.text


def _own_cameras(state: State, file: SceneFile) -> dict[str, Camera]:
    """The views that are not the level's own spawn points."""
    spawns = spawn_cameras(state.scene.level.bsp)
    return {
        name: camera
        for name, camera in state.scene.cameras.items()
        if name in file.cameras or name not in spawns or as_toml(camera) != as_toml(spawns[name])
    }


def _write(path: Path, text: str) -> None:
    """Write the file itself, where the path is a link to it."""
    if lexists(path) and not os.access(path, os.W_OK):
        raise UsageError(f"{path}: cannot be written: it is read-only")
    try:
        encoded = text.encode()
    except UnicodeEncodeError:  # its level's name is bytes that are no text
        raise UnwritableError(path, "expected names of UTF-8 text in it, found others") from None
    files.write_whole(path, lambda part: part.write_bytes(encoded))


def _as_file(state: State, file: SceneFile, path: Path) -> State:
    """The state with every value as its file has it, rounded, so that saving again is nothing."""
    cameras = {name: entry.camera(name) for name, entry in file.cameras.items()}
    scene = replace(
        state.scene,
        name=str(path),
        cameras=cameras | {n: c for n, c in state.scene.cameras.items() if n not in cameras},
        paths={name: entry.path() for name, entry in file.paths.items()},
        environment_constant=file.environment_constant,
        settings=file.settings,
    )
    state = replace(
        state,
        scene=scene,
        settings=file.settings,
        environment_constant=file.environment_constant,
        save_as="",
    )
    if file.lights is None:
        return state
    lights = tuple(entry.light() for entry in file.lights)
    scene = replace(scene, lights=lights, lights_chosen=False, ambient=file.ambient)
    lamps = [
        replace(lamp, light=light, number=number)
        for number, (lamp, light) in enumerate(zip(state.lamps, lights, strict=True))
    ]
    return replace(state, scene=scene, lamps=tuple(lamps))
