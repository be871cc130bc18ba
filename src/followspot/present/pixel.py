"""One pixel, and how it came about: the values down the pipeline as the shaders work them out."""

from dataclasses import dataclass, replace

import msgspec
import numpy as np
from numpy.typing import NDArray

from followspot.arrays import Floats
from followspot.assets.shader_values import Sides
from followspot.errors import UsageError
from followspot.passes import lighting
from followspot.passes.frame import FrameInput
from followspot.passes.shadow_tiles import GRAZING, LIT_SIDE, STEEP, Tile, near_reach
from followspot.passes.view import View
from followspot.present.renderer import Renderer
from followspot.scene.fog import optical_depths
from followspot.scene.light import CubeSide, SpotLight
from followspot.scene.settings import CullFace
from followspot.scene.sight import Crossing, crossings

_FOREVER = 1e9
"""Units, as far as the sky is."""


@dataclass(frozen=True)
class Surface:
    """What is seen.

    Attributes:
        material: The shader's name in the level.
        texture: Path of its image; none is plain white.
        face: Number of the mesh's face, if it belongs to the level.
        character: Name of the figure, if it belongs to a character.
    """

    material: str
    texture: str | None
    face: int | None
    character: str | None


@dataclass(frozen=True, eq=False)
class ShadowLookup:
    """A surface point looked up in one light's shadow map.

    Attributes:
        light: What `lighting.names` calls it; a point light with the side of its cube.
        light_space: (4,) homogeneous place in the atlas, moved off the surface by the bias.
        divided: (3,) the same after the division, in [0, 1]; the third is what is compared.
        texel: Column and row in the light's tile, from the top left.
        is_near: Whether that is its near tile, not its wide one.
        stored: Depth in that texel, in [0, 1].
        stored_distance: The same in units along the light's axis; infinite where nothing is.
        compared_distance: That of the point.
        arrives: Share of the comparisons around it that let light through, as the filter weights
            them.
        is_lit: Whether the surface is turned to the light and inside its cone.
    """

    light: str
    light_space: Floats
    divided: Floats
    texel: tuple[int, int]
    is_near: bool
    stored: float
    stored_distance: float
    compared_distance: float
    arrives: float
    is_lit: bool


@dataclass(frozen=True, eq=False)
class PixelReport:
    """A pixel of the final picture. Values of the sky are 0 but for its radiance.

    Attributes:
        x: Column.
        y: Row from the top.
        surface: The opaque surface that is seen; none is the sky.
        in_front: Blended surfaces before it, near ones first.
        position: (3,) world units; none is the sky's.
        depth: Units along the view axis; infinite for the sky.
        normal: (3,) unit world normal of the side that is seen.
        shadows: For each light with a shadow map, in their order; of a point light's, that on the
            side of its cube in which the place is.
        visibility: Share of the key light that arrives.
        rho: (3,) Lambertian coefficients, those of blended surfaces blended in.
        direct: (3,) irradiance from all lights in W/m^2.
        environment: (3,) irradiance from the environment, or what was baked, in W/m^2.
        fog: Share of the light from there that fog before it holds back.
        radiance: (3,) of the final picture in W/(m^2 sr), blended surfaces and fog included.
        emitted: (3,) of that what surfaces shine by themselves.
        exposed: (3,) radiance times exposure: what is displayed, before the sRGB curve.
        displayed: (3,) uint8 of the picture.
    """

    x: int
    y: int
    surface: Surface | None
    in_front: tuple[Surface, ...]
    position: Floats | None
    depth: float
    normal: Floats | None
    shadows: tuple[ShadowLookup, ...]
    visibility: float
    rho: Floats
    direct: Floats
    environment: Floats
    fog: float
    radiance: Floats
    emitted: Floats
    exposed: Floats
    displayed: NDArray[np.uint8]


def inspect_pixel(renderer: Renderer, frame: FrameInput, x: int, y: int) -> PixelReport:
    """Draw one pixel of every stage and put together what they tell.

    Irradiance is read off a surface of albedo 1, which shows the radiance E/pi.

    Args:
        renderer: Has the frame's scene open; its pictures are left with this pixel of the last
            stage drawn.
        frame: Any view of it.
        x: Column of its picture.
        y: Row from the top.

    Raises:
        UsageError: there is no such pixel.
    """
    width, height = renderer.size
    if not (0 <= x < width and 0 <= y < height):
        raise UsageError(f"pixel {x}, {y} is not in a picture of {width} x {height}")
    frame = replace(frame, overlays=frozenset())
    white = replace(frame, settings=msgspec.structs.replace(frame.settings, albedo=1.0))
    part = x, y, 1, 1

    def value(view: View, of: FrameInput = frame) -> Floats:
        renderer.draw(replace(of, view=view), linear=True, part=part)
        read: Floats = renderer.target(linear=True).read(part=part)[0, 0].astype(np.float64)
        return read

    depth = float(value(View.DEPTH)[0])
    direct, environment = value(View.DIRECT, white), value(View.ENVIRONMENT, white)
    normal, visibility = value(View.NORMALS) * 2 - 1, float(value(View.SHADOW)[0])
    rho, radiance = value(View.LAMBERTIAN), value(View.FINAL)
    renderer.draw(replace(frame, view=View.FINAL), part=part)
    displayed = renderer.target().read(part=part)[0, 0]

    ray = _ray(frame, renderer.size, x, y)
    surface, in_front = _along(frame, ray, depth)
    is_sky = not np.isfinite(depth)
    dark = replace(frame, settings=msgspec.structs.replace(frame.settings, emission=0.0))
    met = in_front if surface is None else [surface, *in_front]
    shines = any(each.material.shines for each in met)
    emitted = radiance - value(View.FINAL, dark) if shines else np.zeros(3)
    position = None if is_sky else frame.camera.position + ray * depth
    shadows: tuple[ShadowLookup, ...] = ()
    if surface is not None and position is not None:
        lit_at = surface.weights @ surface.corners["position"].astype(np.float64)
        shadows = tuple(
            _look_up(renderer, frame, number, surface, lit_at, normal)
            for number, light in enumerate(frame.shadowed)
            if not isinstance(light, CubeSide) or _is_on_side(light, lit_at)
        )
    return PixelReport(
        x=x,
        y=y,
        surface=None if surface is None else _named(surface),
        in_front=tuple(_named(each) for each in in_front),
        position=position,
        depth=depth,
        normal=None if is_sky else normal,
        shadows=shadows,
        visibility=visibility,
        rho=rho,
        direct=direct * np.pi,
        environment=environment * np.pi,
        fog=_fog(frame, ray * (depth if np.isfinite(depth) else _FOREVER)),
        radiance=radiance,
        emitted=emitted,
        exposed=radiance * frame.exposure,
        displayed=displayed,
    )


def _ray(frame: FrameInput, size: tuple[int, int], x: int, y: int) -> Floats:
    """(3,) world direction through a pixel's middle, one unit long along the view axis."""
    width, height = size
    camera = frame.camera
    clip_from_view = camera.clip_from_view(width / height, camera.near * 2)
    middle = np.array([(2 * x + 1) / width - 1, 1 - (2 * y + 1) / height, 0, 1])
    matrix = lighting.direction_from_clip(clip_from_view, camera.view_from_world)
    return np.asarray((matrix @ middle)[:3])


def _fog(frame: FrameInput, ray: Floats) -> float:
    """Share of light that fog holds back along a ray from the eye."""
    if not frame.settings.fog:
        return 0.0
    eye = frame.camera.position
    depths = optical_depths(frame.scene.level.fogs, eye, (eye + ray)[np.newaxis])
    return float(-np.expm1(-depths.sum()))


def _along(frame: FrameInput, ray: Floats, depth: float) -> tuple[Crossing | None, list[Crossing]]:
    """The opaque surface at the depth that was drawn, and the blended ones before it.

    The depth knows of holes that texels make in cut-out surfaces, and of faces that were culled.
    """
    eye, scene = frame.camera.position, frame.scene
    far = frame.camera.far_for(*scene.bounds)
    met = crossings(scene, eye, eye + ray * far, frame.time)
    opaque = [crossing for crossing in met if crossing.material.blend is None]
    surface = None
    if opaque and np.isfinite(depth):
        surface = min(opaque, key=lambda crossing: abs(crossing.fraction * far - depth))
    nearest = frame.camera.near / far
    behind = 1.0 if surface is None else surface.fraction
    has_blended = frame.settings.albedo is None
    in_front = [
        crossing
        for crossing in met
        if has_blended
        and crossing.material.blend is not None
        and nearest < crossing.fraction <= behind
    ]
    return surface, in_front


def _look_up(
    renderer: Renderer,
    frame: FrameInput,
    number: int,
    surface: Crossing,
    position: Floats,
    normal: Floats,
) -> ShadowLookup:
    """What surface.vert and surface.frag do for one light."""
    shadow, settings, light = renderer.pipeline.shadow, frame.settings, frame.shadowed[number]
    tile, light_space = _light_space(renderer, frame, number, surface)
    divided = light_space[:3] / light_space[3]
    # The place in the tile, in texels from the bottom left, as the atlas has it.
    size = shadow.size
    place = divided[:2] * shadow.atlas.size - np.array(tile.place) * size
    weights, texels = zip(*(_filter(at, settings.shadow_taps, size) for at in place), strict=True)
    columns, rows = texels
    left, right, bottom, top = (int(each) for each in (*columns[[0, -1]], *rows[[0, -1]]))
    part = left, size - 1 - top, right - left + 1, top - bottom + 1
    depths = shadow.read_depths(tile, part)[::-1]
    around = depths[np.ix_(rows - bottom, columns - left)]
    compared = min(max(float(divided[2]), 0.0), 1.0)
    column, row = (min(max(int(at), 0), size - 1) for at in place)
    stored = shadow.read_depths(tile, (column, size - 1 - row, 1, 1))
    distances = tile.frustum.distances
    return ShadowLookup(
        light=lighting.names(frame.shadowed)[number],
        light_space=light_space,
        divided=divided,
        texel=(column, size - 1 - row),
        is_near=tile.is_near,
        stored=float(stored[0, 0]),
        stored_distance=float(distances(stored)[0, 0]),
        compared_distance=float(distances(divided[2])),
        arrives=float(weights[1] @ (np.float32(compared) <= around) @ weights[0]),
        is_lit=_is_lit(light, position, normal),
    )


def _light_space(
    renderer: Renderer, frame: FrameInput, number: int, surface: Crossing
) -> tuple[Tile, Floats]:
    """The tile, and (4,) the place in the atlas that surface.frag makes of its inputs."""
    shadow, settings, light = renderer.pipeline.shadow, frame.settings, frame.shadowed[number]
    wide, *near = shadow.tiles_of(number)
    corners = surface.corners["position"].astype(np.float64)
    normals = surface.corners["normal"].astype(np.float64)
    if isinstance(light, CubeSide):  # looked up pixel by pixel
        corners, normals = (surface.weights @ each for each in (corners, normals))
        corners, normals = (np.tile(each, (3, 1)) for each in (corners, normals))
        normals /= np.linalg.norm(normals[0])
    ray = light.position - corners
    cosine = np.einsum("ij,ij->i", normals, ray) / np.linalg.norm(ray, axis=1)
    shows_backs = surface.material.sides is not Sides.FRONT
    if shows_backs:
        normals, cosine = np.where(cosine < 0, -normals.T, normals.T).T, np.abs(cosine)
    axes, texel_in_depth = shadow.layout.offsets(wide, settings.shadow_normal_offset, shadow.size)
    across = normals @ axes[:, :3].T
    depth = np.zeros(3)
    if shows_backs or settings.shadow_cull is not CullFace.FRONT:  # common/offset.glsl
        facing = np.clip((cosine - GRAZING) / (STEEP - GRAZING), 0, 1)
        facing = facing * facing * (3 - 2 * facing)
        deepens = np.abs(across).sum(axis=1) / np.maximum(cosine, GRAZING)
        deepens = np.maximum(deepens, cosine / LIT_SIDE)
        cosine = np.maximum(cosine, 0)
        depth = LIT_SIDE * (cosine + (deepens - cosine) * facing)
        across = across * (LIT_SIDE + (1 - LIT_SIDE) * facing)[:, np.newaxis]
    places = np.c_[corners + normals * settings.shadow_bias, np.ones(3)]
    places = places @ shadow.layout.atlas_from_world(wide).T
    offsets = np.c_[across * axes[:, 3] * places[:, 3:], texel_in_depth * depth]
    place, offset = surface.weights @ places, surface.weights @ offsets
    if near:
        scale, shift = np.split(shadow.layout.near_from_wide()[number], 2)
        there = place[:2] * scale + place[3] * shift + offset[:2]
        tiles = np.array(shadow.atlas.size) / shadow.size
        middle = (np.array(near[0].place) + 0.5) / tiles
        reach = near_reach(settings) / tiles
        if (np.abs(there - place[3] * middle) < place[3] * reach).all():
            return near[0], np.array([*there, place[2] + offset[2] / scale.min(), place[3]])
    return wide, place + np.array([*offset, 0.0])


def _filter(at: float, taps: int, size: int) -> tuple[Floats, NDArray[np.intp]]:
    """Weights and numbers of the texels that the shadow filter compares along one axis.

    Each of the taps, a texel apart, is the hardware's mean of two neighbours, weighted by how near
    their middles are.
    """
    first = at - 0.5 - (taps - 1) / 2
    share = first - np.floor(first)
    weights = np.convolve(np.full(taps, 1 / taps), [1 - share, share])
    texels = np.clip(int(np.floor(first)) + np.arange(taps + 1), 0, size - 1)
    return weights, texels


def _is_on_side(light: CubeSide, position: Floats) -> bool:
    """Whether the ray to a place goes through a side of a point light's cube."""
    way = position - light.position
    return bool(way @ light.direction >= np.abs(way).max())


def _is_lit(light: SpotLight, position: Floats, normal: Floats) -> bool:
    towards = light.position - position
    if isinstance(light, CubeSide):
        return bool(normal @ towards > 0)
    cosine = -(towards @ light.direction) / np.linalg.norm(towards)
    return bool(normal @ towards > 0 and cosine > light.cos_rim)


def _named(crossing: Crossing) -> Surface:
    material = crossing.material
    return Surface(material.name, material.image, crossing.face, crossing.character)
