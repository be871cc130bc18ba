"""A whole scene: what is in it, what lights it, where it can be looked at from."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from followspot import spaces
from followspot.assets.archive import Archive
from followspot.assets.bsp import BspFile
from followspot.assets.entities import entity_angles, entity_vector, target_of
from followspot.assets.shader_values import Sun
from followspot.errors import AssetError, UsageError
from followspot.game import EYE_HEIGHT
from followspot.scene.camera import STEEPEST, Camera
from followspot.scene.character import Crowd
from followspot.scene.clouds import Clouds
from followspot.scene.level import Level, Visibility
from followspot.scene.light import Light
from followspot.scene.material import Material
from followspot.scene.mesh import Mesh
from followspot.scene.path import AutoPath, CameraPath
from followspot.scene.props import Prop
from followspot.scene.settings import Settings
from followspot.scene.sky import CubeMap


@dataclass(frozen=True)
class MissingImage:
    """A texture that is nowhere: white stands in for it."""

    name: str
    tried: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Scene:
    """Frozen data in world space; nothing of it is in GPU memory.

    Attributes:
        name: What it was opened as.
        archive: Where its images are read from when it is uploaded.
        level: The level with its file's records, materials and visibility.
        crowd: The characters.
        props: Things that never move; the level's mesh has them too.
        sky: The cube map behind everything, which also lights it.
        clouds: What of the sky may move, if it has any.
        sun: Of the level's sky script, where it has one.
        lights: In the scene file's or command line's order.
        lights_chosen: Whether the program chose the lights, since nobody gave any.
        cameras: Views by name; the first one is where a picture starts.
        paths: Cameras in motion by name; the first one is what a film takes.
        environment_constant: Radiance in W/(m^2 sr) of a sky texel of value 1.
        ambient: Radiance in W/(m^2 sr) from all around, added to the environment's.
        own_ambient: That without what was chosen to go with a chosen light.
        metres_per_unit: Length of a Quake unit.
        settings: The scene's own choice of switches.
        missing: Images that were not found.
        problems: Other things that are wrong with the data and were passed over.
    """

    name: str
    archive: Archive
    level: Level
    sky: CubeMap
    crowd: Crowd = field(default_factory=Crowd)
    props: tuple[Prop, ...] = ()
    clouds: Clouds | None = None
    sun: Sun | None = None
    lights: tuple[Light, ...] = ()
    lights_chosen: bool = False
    cameras: Mapping[str, Camera] = field(default_factory=dict)
    paths: Mapping[str, CameraPath | AutoPath] = field(default_factory=dict)
    environment_constant: float = 1.0
    ambient: float = 0.0
    own_ambient: float = 0.0
    metres_per_unit: float = spaces.METRES_PER_UNIT
    settings: Settings = field(default_factory=Settings)
    missing: tuple[MissingImage, ...] = ()
    problems: tuple[AssetError, ...] = ()

    @property
    def mesh(self) -> Mesh:
        """Everything that is drawn."""
        return self.level.mesh

    @property
    def materials(self) -> tuple[Material, ...]:
        """The mesh's faces name them by number."""
        return self.level.materials

    @property
    def worn(self) -> tuple[Material, ...]:
        """The mesh's materials and the characters'."""
        return *self.materials, *self.crowd.materials

    @property
    def images(self) -> tuple[str, ...]:
        """Paths in the archive of all images that materials have, each once."""
        found = (image for material in self.worn for image in material.images)
        return tuple(dict.fromkeys(image for image in found if image is not None))

    @cached_property
    def moves(self) -> bool:
        """Whether pictures of it follow the time."""
        moves = any(material.moves for material in self.worn)
        return moves or len(self.crowd) > 0 or (self.clouds is not None and self.clouds.moves)

    @property
    def bounds(self) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """(3,) mins and (3,) maxs in units of the level and of where characters go."""
        mins, maxs = self.mesh.bounds
        return (
            np.minimum(mins, self.crowd.mins.min(axis=0, initial=np.inf)),
            np.maximum(maxs, self.crowd.maxs.max(axis=0, initial=-np.inf)),
        )

    @property
    def triangle_count(self) -> int:
        """Triangles of the level and of all characters."""
        figures = (character.figure for character in self.crowd.characters)
        return self.mesh.triangle_count + sum(f.triangle_count for f in figures)

    @property
    def visibility(self) -> Visibility:
        """What can be seen from where."""
        return self.level.visibility

    def camera(self, name: str | None = None) -> Camera:
        """A view by its name, or the one where a picture starts.

        Raises:
            UsageError: no view has that name; lists those that have one.
        """
        if name is None:
            return next(iter(self.cameras.values()))
        if name not in self.cameras:
            raise UsageError(f"no camera is named {name!r}; there are {', '.join(self.cameras)}")
        return self.cameras[name]

    def path(self, name: str | None = None) -> CameraPath | AutoPath:
        """A path by its name, or the first one; ``auto`` is there in every scene.

        Raises:
            UsageError: no path has that name; lists those that have one.
        """
        paths = dict(self.paths)
        paths.setdefault("auto", AutoPath())
        if name is None:
            return next(iter(paths.values()))
        if name not in paths:
            raise UsageError(f"no path is named {name!r}; there are {', '.join(paths)}")
        return paths[name]

    def with_lights(self, *lights: Light) -> "Scene":
        """The same scene under other lights, without what was chosen to go with the old ones."""
        ambient = self.own_ambient if self.lights_chosen else self.ambient
        return replace(self, lights=lights, lights_chosen=False, ambient=ambient)


def spawn_cameras(bsp: BspFile) -> dict[str, Camera]:
    """Views from a level's spawn points at eye height: spawn0, spawn1, ... and intermission.

    A level without any gets one view from the middle of its box.
    """
    cameras: dict[str, Camera] = {}
    for entity in bsp.entities:
        kind = entity.get("classname", "").lower()
        is_spawn = kind.startswith(("info_player", "team_ctf_redspawn", "team_ctf_bluespawn"))
        is_spawn |= kind in ("team_ctf_redplayer", "team_ctf_blueplayer")
        origin = entity_vector(entity, "origin")
        if not is_spawn or origin is None or kind == "info_player_intermission":
            continue
        name = f"spawn{len(cameras)}"
        eye = origin + np.array([0, 0, EYE_HEIGHT])
        cameras[name] = Camera(spaces.vec3(eye), *_view_angles(entity), name=name)
    cameras |= _intermission(bsp)
    if not cameras:
        middle = (bsp.models["mins"][0].astype(np.float64) + bsp.models["maxs"][0]) / 2
        cameras["middle"] = Camera(spaces.vec3(middle), name="middle")
    return cameras


def _intermission(bsp: BspFile) -> dict[str, Camera]:
    """The view that the game shows between matches, which levels choose with care."""
    for entity in bsp.entities:
        origin = entity_vector(entity, "origin")
        if entity.get("classname", "").lower() != "info_player_intermission" or origin is None:
            continue
        yaw, pitch = _view_angles(entity)
        target = entity_vector(target_of(bsp, entity), "origin")
        if target is not None and not np.array_equal(target, origin):
            yaw, pitch = spaces.angles_from_forward(spaces.vec3(target - origin))
        return {"intermission": Camera(spaces.vec3(origin), yaw, pitch, name="intermission")}
    return {}


def _view_angles(entity: dict[str, str]) -> tuple[float, float]:
    """(yaw, pitch) in degrees of who looks as an entity says; the game lets nobody bend farther."""
    yaw, pitch = entity_angles(entity)
    return yaw, min(max((pitch + 180) % 360 - 180, -STEEPEST), STEEPEST)
