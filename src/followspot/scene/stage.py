"""A scene without a level: one figure or prop on a plain floor under a key light."""

import math
from typing import Any

import numpy as np

from followspot import spaces
from followspot.arrays import Floats
from followspot.assets.archive import Archive
from followspot.assets.bsp import LUMPS, BspFile
from followspot.scene import walk
from followspot.scene.camera import Camera
from followspot.scene.character import Character, Crowd
from followspot.scene.figure import Figure, Tracks
from followspot.scene.figure_file import FigureFiles
from followspot.scene.level import Level, Visibility
from followspot.scene.light import SpotLight
from followspot.scene.material import Material
from followspot.scene.mesh import FACE, VERTEX, Mesh
from followspot.scene.prop_mesh import with_props
from followspot.scene.props import Prop, moved
from followspot.scene.scene import MissingImage, Scene
from followspot.scene.settings import Settings
from followspot.scene.sky import CubeMap

FLOOR_SIZES = 40.0
"""Half the floor's edge, in radii of the figure."""

FOV = 40.0
"""Degrees: a portrait is taken from farther off than a room."""

IRRADIANCE = 12.0
"""W/m^2 of the key light on a surface turned to it."""

_SKY_BYTE = 150
_MOMENTS = 9  # of an animation, at which the figure is measured
_VIEWS = {"start": 30.0, "front": 0.0, "left": 90.0, "back": 180.0, "right": 270.0}
"""Views by name: degrees round the figure, which looks along +X."""


def stage(
    name: str, archive: Archive, figure: Figure, files: FigureFiles, animation: str | None = None
) -> Scene:
    """A scene of one figure.

    Args:
        name: What it was opened as.
        archive: Where its images are read from.
        figure: Who stands there.
        files: What has been missing so far.
        animation: What it does; none is how it stands.

    Raises:
        AssetError: the figure has no such animation.
    """
    tracks = figure.tracks(animation)
    feet = figure.floor_below(tracks.legs)
    crowd = Crowd([Character(figure, walk.standing((0, 0, feet)), ((tracks, 0.0),))])
    return _scene(name, archive, _extent(crowd, tracks), files, crowd, ())


def stage_prop(name: str, archive: Archive, prop: Prop, files: FigureFiles) -> Scene:
    """A scene of one prop, which is put down in the middle of the floor; otherwise as `stage`."""
    mins, maxs = (corner.astype(np.float64) for corner in prop.bounds)
    matrix = np.eye(4)
    matrix[:3, 3] = -(mins[0] + maxs[0]) / 2, -(mins[1] + maxs[1]) / 2, -mins[2]
    prop = moved(prop, matrix)
    mins, maxs = (corner.astype(np.float64) for corner in prop.bounds)
    return _scene(name, archive, (mins, maxs), files, Crowd(), (prop,))


def _scene(
    name: str,
    archive: Archive,
    extent: tuple[Floats, Floats],
    files: FigureFiles,
    crowd: Crowd,
    props: tuple[Prop, ...],
) -> Scene:
    mins, maxs = extent
    middle = spaces.vec3((mins + maxs) / 2)
    radius = max(float(np.linalg.norm(maxs - mins)) / 2, 0.1)
    level = with_props(_floor(FLOOR_SIZES * radius), props)
    metres = spaces.METRES_PER_UNIT
    return Scene(
        name=name,
        archive=archive,
        level=level,
        sky=_plain_sky(),
        crowd=crowd,
        props=props,
        lights=(_key_light(middle, radius, metres),),
        cameras={view: _camera(view, middle, radius) for view in _VIEWS},
        settings=Settings(shadow_taps=2),
        missing=tuple(MissingImage(n, tuple(tried)) for n, tried in files.missing.items()),
        problems=(*archive.problems, *files.problems),
    )


def _extent(crowd: Crowd, tracks: Tracks) -> tuple[Floats, Floats]:
    """(3,) mins and (3,) maxs in units of the one character while it does what it does."""
    corners = [np.zeros((1, 3))]
    for seconds in np.linspace(0, max(track.seconds for track in tracks), _MOMENTS).tolist():
        rows = crowd.instances(seconds, crowd.places(seconds), np.zeros(1, np.intp))[0]
        for part in crowd.figures[0].parts:
            matrix, (first, _, _, _) = rows[part.slot, :3], rows[part.slot, 3]
            points = part.positions[int(first) // part.vertex_count]
            world = points @ matrix[:, :3].T + matrix[:, 3]
            corners.append(np.stack([world.min(axis=0), world.max(axis=0)]))
    every = np.concatenate(corners)
    return every.min(axis=0), every.max(axis=0)


def _camera(view: str, middle: spaces.Vec3, radius: float) -> Camera:
    angle = math.radians(_VIEWS[view])
    distance = 0.9 * radius / math.tan(math.radians(spaces.vertical_fov(FOV, 4 / 3)) / 2)
    towards = np.array([math.cos(angle), math.sin(angle), 0.22])
    position = middle + towards * distance
    yaw, pitch = spaces.angles_from_forward(spaces.vec3(middle - position))
    return Camera(spaces.vec3(position), yaw, pitch, FOV, near=min(4.0, radius / 8), name=view)


def _key_light(middle: spaces.Vec3, radius: float, metres_per_unit: float) -> SpotLight:
    """A spot light over the camera's left shoulder, wide enough for the figure and its shadow."""
    distance = 12.0 * radius
    position = middle + distance * spaces.normalised(spaces.vec3((0.7, -0.45, 0.9)))
    half_angle = math.atan2(3.5 * radius, distance)
    full, rim = math.cos(half_angle * 0.5), math.cos(half_angle)
    solid_angle = 2 * math.pi * (1 - (full + rim) / 2)
    power = IRRADIANCE * (distance * metres_per_unit) ** 2 * solid_angle
    color = np.array([1.0, 0.96, 0.9])
    direction = spaces.normalised(spaces.vec3(middle - position))
    return SpotLight(
        spaces.vec3(position), direction, half_angle, spaces.vec3(color * power), 0.5, name="key"
    )


def _plain_sky() -> CubeMap:
    faces = np.full((6, 4, 4, 4), _SKY_BYTE, np.uint8)
    faces[..., 3] = 255
    return CubeMap("plain", faces)


def _floor(half: float) -> Level:
    """A square that looks up, in a level without walls."""
    corners = np.array([(-1, -1), (-1, 1), (1, 1), (1, -1)], np.float32)
    vertices = np.zeros(4, VERTEX)
    vertices["position"][:, :2] = corners * half
    vertices["normal"] = 0, 0, 1
    vertices["texcoord"] = corners
    face = np.zeros(1, FACE)
    face["index_count"], face["normal"] = 6, (0, 0, 1)
    face["mins"], face["maxs"] = (-half, -half, 0), (half, half, 0)
    mesh = Mesh(vertices, np.array([0, 1, 2, 0, 2, 3], np.uint32), face)
    bsp = _open_bsp()
    visibility = Visibility(bsp, np.zeros(1, np.int64), np.ones(1, bool))
    return Level(bsp, mesh, (Material("floor"),), visibility)


def _open_bsp() -> BspFile:
    """A level of one place, which is outside of all clusters: everything is visible there."""
    records: dict[str, Any] = {name: np.empty(0, dtype) for name, dtype in LUMPS.items()}
    del records["entities"], records["visibility"]
    nodes, planes, leafs = (np.zeros(1, LUMPS[name]) for name in ("nodes", "planes", "leafs"))
    nodes["children"], planes["normal"], leafs["cluster"] = -1, (0, 0, 1), -1
    records |= {"nodes": nodes, "planes": planes, "leafs": leafs}
    return BspFile(
        source="stage",
        entities=(),
        shader_names=(),
        cluster_count=0,
        cluster_visible=np.empty((0, 0), np.uint8),
        **records,
    )
