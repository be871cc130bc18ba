"""From a name to a `Scene`: scene file, level, scripts, images' places, sky, lights."""

from collections.abc import Callable, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path

import msgspec

from followspot.assets import image
from followspot.assets.archive import Archive
from followspot.assets.bsp_reader import read_bsp
from followspot.assets.mesh_file import MESH_SUFFIXES
from followspot.assets.script_files import load_scripts
from followspot.errors import AssetError, asked_by
from followspot.scene import (
    cast,
    figure_file,
    items,
    key_light,
    level,
    prop_mesh,
    props,
    sky_files,
    stage,
)
from followspot.scene.camera import Camera
from followspot.scene.cast_file import Actors, Items
from followspot.scene.character import Crowd
from followspot.scene.figure_file import FigureFiles
from followspot.scene.ground import Ground
from followspot.scene.level import Level
from followspot.scene.props import Prop, PropFiles
from followspot.scene.scene import MissingImage, Scene, spawn_cameras
from followspot.scene.scene_file import SceneFile
from followspot.scene.search import find_scene, search_roots

Step = Callable[[str], None]


def load(
    name: str | Path,
    assets: Sequence[str | Path] = (),
    *,
    patch_tolerance: float = level.PATCH_TOLERANCE,
    with_items: bool = False,
    seen_by: Callable[[Scene], Camera] = Scene.camera,
    on_step: Step = lambda _: None,
) -> Scene:
    """Open a scene or a level.

    Args:
        name: A scene that comes with the package (``courtyard``), a scene file (``x.toml``), a
            level's file (``maps/x.bsp``, ``x.pk3``), or a level's name in the search path.
        assets: Game folders and pk3 files to look in first; then come FOLLOWSPOT_ASSETS and the
            usual installs of OpenArena and Quake 3.
        patch_tolerance: Units by which triangles may miss a curved patch.
        with_items: Whether the level's pick-ups are there even if a scene file does not say so.
        seen_by: Tells the camera whose view a chosen light is to suit; may raise what it likes.
        on_step: Called with the name of each step of loading when it is done.

    Raises:
        AssetError: something is missing or unusable.
    """
    name = str(name)
    file, archive, entry = find_scene(name, assets)
    if with_items:
        file = msgspec.structs.replace(file, items=Items.ENTITIES)
    try:
        on_step("search")
        scene = _assemble(name, file, archive, entry, patch_tolerance, on_step)
        if file.lights is None:
            scene = with_chosen_light(scene, [seen_by(scene)])
            on_step("choose light")
        return scene
    except BaseException:
        archive.close()
        raise


def load_figure(
    name: str,
    assets: Sequence[str | Path] = (),
    animation: str | None = None,
    *,
    on_step: Step = lambda _: None,
) -> Scene:
    """Open a model or player as a scene of its own: on a plain floor, under a key light.

    Args:
        name: ``player:sarge``, ``player:sarge/red``, or a model's or mesh's file, on disk or in the
            archive.
        assets: As for `load`.
        animation: What it does; see `Figure.tracks`. None is how it stands. A mesh does nothing.
        on_step: As for `load`.

    Raises:
        AssetError: something is missing or unusable, or there is no such animation.
    """
    archive, entry = figure_file.open_archive(name, search_roots(assets))
    try:
        on_step("search")
        scripts = load_scripts(archive)
        on_step("find scripts")
        files = FigureFiles(archive, scripts.find)
        if entry.endswith(MESH_SUFFIXES):
            staged = _staged_prop(name, archive, entry, files, animation)
            on_step("read props")
            return staged
        found = files.open(entry)
        on_step("read figure")
        return stage.stage(name, archive, found, files, animation)
    except BaseException:
        archive.close()
        raise


def _staged_prop(
    name: str, archive: Archive, entry: str, files: FigureFiles, animation: str | None
) -> Scene:
    if animation is not None:
        raise AssetError(name, place="animation", expected="none", found=animation)
    prop = props.alone(entry, PropFiles(archive, files), name)
    return stage.stage_prop(name, archive, prop, files)


def _assemble(
    name: str, file: SceneFile, archive: Archive, entry: str, tolerance: float, on_step: Step
) -> Scene:
    with nullcontext() if name == file.level else asked_by(name, "level"):
        bsp = read_bsp(archive.read(entry), archive.source(entry))
    on_step("read level")
    scripts = load_scripts(archive)
    on_step("find scripts")

    missing: dict[str, MissingImage] = {}

    def find_image(wanted: str) -> str | None:
        found, tried = image.find_image(archive, wanted)
        if found is None:
            missing[wanted] = MissingImage(wanted, tuple(tried))
        return found

    built = level.build(bsp, scripts.find, find_image, tolerance)
    on_step("build geometry")
    skies = [s for n in sky_files.shaders(bsp) if (s := scripts.find(n)) is not None]
    if file.sky is None:
        sky = sky_files.of_scripts(archive, skies)
    else:
        with asked_by(name, "sky"):
            sky = sky_files.Found(sky_files.read(archive, file.sky), None, [])
    on_step("read sky")
    own = {camera: entry.camera(camera) for camera, entry in file.cameras.items()}
    spawns = spawn_cameras(bsp)
    cameras = own | {n: c for n, c in spawns.items() if n not in own}
    figures = FigureFiles(archive, scripts.find)
    placed = _props(name, file, built, figures, archive)
    built = prop_mesh.with_props(built, placed)
    on_step("read props")
    crowd = _crowd(name, file, built, figures, archive, spawns)
    missing |= {n: MissingImage(n, tuple(tried)) for n, tried in figures.missing.items()}
    on_step("read characters")
    return Scene(
        name=name,
        archive=archive,
        level=built,
        sky=sky.sky,
        clouds=sky.clouds,
        crowd=crowd,
        props=placed,
        sun=next((s.sun for s in skies if s.sun is not None), None),
        lights=tuple(each.light() for each in file.lights or ()),
        cameras=cameras,
        paths={path: entry.path() for path, entry in file.paths.items()},
        environment_constant=file.environment_constant,
        ambient=file.ambient,
        own_ambient=file.ambient,
        metres_per_unit=file.metres_per_unit,
        settings=file.settings,
        missing=tuple(missing.values()),
        problems=(*archive.problems, *scripts.problems, *sky.problems, *figures.problems),
    )


def _props(
    name: str, file: SceneFile, level: Level, figures: FigureFiles, archive: Archive
) -> tuple[Prop, ...]:
    """The props that a scene file asks for."""
    if not file.props:
        return ()
    files = PropFiles(archive, figures)
    return props.props(file.props, files, file.metres_per_unit, name, Ground(level))


def _crowd(
    name: str,
    file: SceneFile,
    level: Level,
    figures: FigureFiles,
    archive: Archive,
    spawns: Mapping[str, Camera],
) -> Crowd:
    """The characters that a scene file asks for."""
    if not file.characters and file.actors is Actors.NONE and file.items is Items.NONE:
        return Crowd()
    ground = Ground(level)
    found = cast.characters(file.characters, figures, ground, name)
    if file.actors is Actors.SPAWNS:
        places = [camera for spawn, camera in spawns.items() if spawn.startswith("spawn")]
        found += cast.actors(archive, places, figures, ground)
    if file.items is Items.ENTITIES:
        found += items.items(level.bsp, figures, ground)
    return Crowd(found)


def with_chosen_light(scene: Scene, cameras: Sequence[Camera]) -> Scene:
    """The scene under a light that suits its level and what cameras see."""
    light = key_light.choose(scene.level, scene.sun, cameras, scene.metres_per_unit)
    fill = key_light.ambient(scene.sky.towards_axes() * scene.environment_constant)
    ambient = max(scene.own_ambient, fill)
    return replace(scene, lights=(light,), lights_chosen=True, ambient=ambient)
