"""Which world point a pixel shows: rays worked out in NumPy against depth and normals."""

import math
from collections.abc import Callable
from pathlib import Path

import moderngl
import numpy as np
import pytest
from numpy.typing import NDArray

from conftest import Draw
from followspot.arrays import Floats
from followspot.assets.image import Image
from followspot.assets.shader_values import BlendFactor
from followspot.passes.frame import FrameInput
from followspot.passes.view import View
from followspot.present.renderer import Renderer
from followspot.scene import sky
from followspot.scene.camera import Camera
from followspot.scene.material import Material
from followspot.scene.settings import CullFace, Settings
from followspot.scene.sky import CubeMap
from synthetic import (
    SIZE,
    WHITE_SKY,
    box,
    camera,
    cube_map,
    floor,
    image_archive,
    make_scene,
    of,
    point,
    quad,
    rays,
    rotation,
    sphere,
    spot,
    srgb_encoded,
    turned,
)

pytestmark = pytest.mark.gl

LOW, HIGH = np.array([-300.0, -200, -100]), np.array([400.0, 250, 180])
RANDOM = np.random.default_rng(11)
CAMERAS = [
    camera(RANDOM.uniform(LOW + 20, HIGH - 20), RANDOM.uniform(-180, 180), pitch, fov)
    for pitch, fov in ((-80, 90), (-30, 60), (0, 90), (0, 20), (12, 110), (45, 90), (88, 130))
]


def inside_box(view: Camera) -> tuple[Floats, NDArray[np.int64]]:
    """(h, w) distances along the view axis to the room's walls, and which axis the wall lies on."""
    towards = rays(view)
    with np.errstate(divide="ignore"):
        planes = np.where(towards > 0, HIGH, LOW)
        distance = (planes - view.position) / towards
    distance[towards == 0] = np.inf
    return distance.min(axis=2), distance.argmin(axis=2)


@pytest.mark.parametrize("view", CAMERAS, ids=[f"pitch {c.pitch:g} fov {c.fov:g}" for c in CAMERAS])
def test_depth_and_normals_of_a_room(draw: Draw, view: Camera) -> None:
    scene = make_scene(box(LOW, HIGH, inward=True))
    expected, axis = inside_box(view)
    # Vertices snap to a 256th of a pixel, which moves a steep wall's depth a little.
    np.testing.assert_allclose(draw(scene, view, View.DEPTH), expected, rtol=1e-4)
    normal = np.zeros((*axis.shape, 3))
    np.put_along_axis(normal, axis[..., np.newaxis], 1, axis=2)
    normal *= -np.sign(rays(view))
    encoded = draw(scene, view, View.NORMALS)
    # Where two walls meet, the pixel's middle may fall on either side.
    settled = np.abs(encoded - (normal * 0.5 + 0.5)).max(axis=2) < 1e-6
    assert settled.mean() > 0.999


def test_sphere_depth_and_normals_are_renormalised(draw: Draw) -> None:
    """Flat triangles show interpolated normals of length one, near those of the true sphere."""
    centre, radius, view = np.array([200.0, 0, 0]), 90.0, camera((0, 0, 0), fov=70)
    scene = make_scene([sphere(centre, radius, rings=64)])
    n = draw(scene, view, View.NORMALS) * 2 - 1
    depth = draw(scene, view, View.DEPTH)
    hit = np.isfinite(depth)
    np.testing.assert_allclose(np.linalg.norm(n[hit], axis=1), 1, atol=1e-5)
    p = view.position + rays(view)[hit] * depth[hit][:, np.newaxis]
    outward = (p - centre) / np.linalg.norm(p - centre, axis=1, keepdims=True)
    assert np.abs(n[hit] - outward).max() < 0.05
    coarse = draw(make_scene([sphere(centre, radius, rings=5)]), view, View.NORMALS) * 2 - 1
    hit = np.isfinite(draw(make_scene([sphere(centre, radius, rings=5)]), view, View.DEPTH))
    np.testing.assert_allclose(np.linalg.norm(coarse[hit], axis=1), 1, atol=1e-5)


def test_nothing_is_infinitely_far(draw: Draw) -> None:
    scene = make_scene([quad((100, 0, 0), (0, -10, 0), (0, 0, 10))])
    depth = draw(scene, camera((0, 0, 0)), View.DEPTH)
    assert np.isinf(depth[0]).all() and np.isinf(depth[:, 0]).all()
    assert depth[60, 80] == pytest.approx(100, rel=1e-6)
    away = draw(scene, camera((0, 0, 0), yaw=180), View.DEPTH)
    assert np.isinf(away).all()


def test_top_row_comes_first_and_left_is_left(draw: Draw) -> None:
    """Looking along +X: a mark at +Y and +Z shows in the upper left corner."""
    mark = quad((100, 60, 45), (0, -10, 0), (0, 0, 10))
    depth = draw(make_scene([mark]), camera((0, 0, 0)), View.DEPTH)
    rows, columns = np.nonzero(np.isfinite(depth))
    assert rows.max() < SIZE[1] // 2 and columns.max() < SIZE[0] // 2
    middle = rows.mean() + 0.5, columns.mean() + 0.5
    expected = SIZE[1] / 2 - 45 / 100 * SIZE[0] / 2, SIZE[0] / 2 - 60 / 100 * SIZE[0] / 2
    np.testing.assert_allclose(middle, expected, atol=0.5)


def test_displayed_and_linear_pictures_lie_alike(renderer: Renderer, draw: Draw) -> None:
    mark = quad((100, 60, 45), (0, -10, 0), (0, 0, 10))
    scene, view = make_scene([mark]), camera((0, 0, 0))
    shown = renderer.render(scene, view, ["lambertian"])[View.LAMBERTIAN]
    assert shown.shape == (*SIZE[::-1], 3)
    np.testing.assert_array_equal(shown[..., 0] == 255, np.isfinite(draw(scene, view, View.DEPTH)))


def test_texture_coordinates_run_right_and_down(draw: Draw, tmp_path: Path) -> None:
    """(s, t) = (0, 0) is the image's first texel, as in Quake's files."""
    pixels = np.zeros((2, 2, 3), np.uint8)
    pixels[0, 0], pixels[0, 1], pixels[1, 0] = (255, 0, 0), (0, 255, 0), (0, 0, 255)
    pixels = pixels.repeat(32, axis=0).repeat(32, axis=1)
    archive = image_archive(tmp_path, {"wall.png": pixels})
    wall = of(Material("wall", "wall.png"), quad((100, 0, 0), (0, -100, 0), (0, 0, 75)))
    shown = draw(make_scene(wall, archive=archive), camera((0, 0, 0)), View.LAMBERTIAN)
    for row, column, colour in ((30, 40, (1, 0, 0)), (30, 120, (0, 1, 0)), (90, 40, (0, 0, 1))):
        np.testing.assert_allclose(shown[row, column], colour, atol=1e-6)
    np.testing.assert_allclose(shown[90, 120], 0, atol=1e-6)


def test_clockwise_triangles_are_the_front(draw: Draw) -> None:
    front, back = camera((0, 0, 50), pitch=90), camera((0, 0, -50), pitch=-90)
    scene = make_scene([floor(100)])
    assert np.isfinite(draw(scene, front, View.DEPTH)).all()
    assert np.isinf(draw(scene, back, View.DEPTH)).all()


def test_near_plane_clips_at_the_games_distance(draw: Draw) -> None:
    wall = quad((3.9, 0, 0), (0, -50, 0), (0, 0, 50))
    assert np.isinf(draw(make_scene([wall]), camera((0, 0, 0)), View.DEPTH)).all()
    wall = quad((4.1, 0, 0), (0, -50, 0), (0, 0, 50))
    assert np.isfinite(draw(make_scene([wall]), camera((0, 0, 0)), View.DEPTH)).all()


def test_vertex_stage_projection_equals_projection_at_each_pixel(
    renderer: Renderer, draw: Draw
) -> None:
    """Visibility at every pixel of long, steep triangles, worked out again from its position.

    Positions come from rays, the map is read back, and NumPy projects each point, compares it with
    four texels and mixes: what the pixel stage would do had it the point instead of the
    interpolated product.
    """
    light = spot((60, 40, 150), (20, 0, 0), 40)
    posts = [box((x, y, -50), (x + 4, y + 30, 80)) for x in (-60, 0, 50) for y in (-60, 20)]
    scene = make_scene([floor(2000, -50), *(side for post in posts for side in post)], light)
    view = camera((200, 80, 60), yaw=205, pitch=15)
    settings = Settings(
        shadow_map_size=256,
        shadow_fit=False,
        shadow_cull=CullFace.BACK,
        shadow_bias=3.0,
        shadow_normal_offset=0.0,
        exposure=1.0,
    )
    visibility = draw(scene, view, View.SHADOW, settings)
    depth = draw(scene, view, View.DEPTH)
    normals = draw(scene, view, View.NORMALS) * 2 - 1

    renderer.draw(FrameInput(scene, view, settings, 1.0, View.SHADOW))
    pipeline = renderer.pipeline
    tile = pipeline.shadow.tiles[0].frustum
    raw = pipeline.shadow.atlas.read(alignment=1)
    stored = np.frombuffer(raw, np.float32).reshape(256, 256)

    hit = np.isfinite(depth)
    p = view.position + rays(view)[hit] * depth[hit][:, np.newaxis]
    p = p + normals[hit] * settings.shadow_bias
    clip = np.concatenate([p, np.ones((len(p), 1))], axis=1) @ tile.clip_from_world.T
    place = clip[:, :3] / clip[:, 3:] * 0.5 + 0.5
    inside = (clip[:, 3] > 0) & (np.abs(place[:, :2] - 0.5) < 0.49).all(axis=1)
    corner = place[inside, :2] * 256 - 0.5
    low = np.floor(corner).astype(int)
    share = corner - low
    gaps = np.array([
        [stored[low[:, 1] + dy, low[:, 0] + dx] - place[inside, 2] for dx in (0, 1)]
        for dy in (0, 1)
    ])  # fmt: skip
    rows = (gaps[:, 0] >= 0) * (1 - share[:, 0]) + (gaps[:, 1] >= 0) * share[:, 0]
    expected = rows[0] * (1 - share[:, 1]) + rows[1] * share[:, 1]
    sure = np.abs(gaps).min(axis=(0, 1)) > 2e-5  # equal but for rounding compares either way
    assert sure.sum() > 5000 and (expected[sure] == 0).sum() > 100
    assert ((expected > 0.1) & (expected < 0.9))[sure].sum() > 50
    lit = draw(scene, view, View.DIRECT, shadows=False)[hit][inside].any(axis=1)
    expected[~lit] = 0  # turned away, or outside of the cone
    np.testing.assert_allclose(visibility[hit][inside][sure], expected[sure], atol=0.02)


SKY_AXES = {"rt": (3, -1, 2), "lf": (-3, 1, 2), "bk": (1, 3, 2), "ft": (-1, -3, 2),
            "up": (-2, -1, 3), "dn": (2, -1, -3)}  # fmt: skip
"""World x, y and z of a sky box's point, told by 1: rightwards in the image, 2: upwards, 3: one;
negative ones turned round (the table of ``tr_sky.c`` in the game's source)."""


def quake_sky(colour_of: Callable[[Floats], Floats], size: int) -> CubeMap:
    """Six Quake images of a function of direction, as `from_quake_images` makes a cube of them."""
    middles = (np.arange(size) + 0.5) / size * 2 - 1
    right, up = np.meshgrid(middles, -middles)
    images = []
    for suffix in sky.SUFFIXES:
        parts = np.stack([right, up, np.ones_like(right)])
        axes = np.array(SKY_AXES[suffix[1:]])
        towards = np.stack([np.sign(a) * parts[abs(a) - 1] for a in axes], axis=-1)
        rgb = srgb_encoded(colour_of(towards / np.linalg.norm(towards, axis=-1, keepdims=True)))
        pixels = np.full((size, size, 4), 255, np.uint8)
        pixels[..., :3] = np.round(rgb * 255)
        images.append(Image(pixels, False, suffix))
    return sky.from_quake_images("coded", images)


def by_direction(towards: Floats) -> Floats:
    """A smooth colour that is different in every direction."""
    return np.asarray(0.5 + 0.4 * towards)


AROUND = [camera((0, 0, 0), yaw, pitch, 80) for yaw in range(0, 360, 45) for pitch in (-35, 0, 35)]
AROUND += [camera((0, 0, 0), 30, 90, 80), camera((0, 0, 0), 120, -90, 80)]


def test_sky_shows_the_right_colour_in_every_direction_without_seams(draw: Draw) -> None:
    """Middles, edges and corners of the six images: yaw by yaw and towards both poles."""
    scene = make_scene([], sky=quake_sky(by_direction, 128))
    for view in AROUND:
        towards = rays(view)
        expected = by_direction(towards / np.linalg.norm(towards, axis=-1, keepdims=True))
        shown = draw(scene, view, View.FINAL)
        # Half a step of 8-bit sRGB is 0.005 of linear light here; seams would jump by far more.
        np.testing.assert_allclose(shown, expected, atol=0.01)


@pytest.mark.parametrize("axis", range(6))
def test_environment_light_comes_from_where_the_sky_shows_it(draw: Draw, axis: int) -> None:
    """The six-direction sum and the drawn sky agree on which way is which."""
    direction = np.zeros(3)
    direction[axis // 2] = 1 - 2 * (axis % 2)
    coded = quake_sky(lambda towards: (towards @ direction > 0.8)[..., np.newaxis] * np.ones(3), 64)
    six = coded.towards_axes()
    assert six.argmax(axis=0).tolist() == [axis] * 3
    # A surface that faces the bright side is lit by it most.
    tangent = np.roll(direction, 1) * 50
    facing = quad(-direction * 100, tangent, np.cross(direction, tangent))
    seen = camera((0, 0, 0), *_angles(-direction))
    assert draw(make_scene([facing], sky=coded), seen, View.ENVIRONMENT)[60, 80, 0] > 0.3
    looking_up = draw(make_scene([], sky=coded), camera((0, 0, 0), *_angles(direction)), View.FINAL)
    assert looking_up[60, 80, 0] > 0.99


def _angles(forward: Floats) -> tuple[float, float]:
    x, y, z = forward
    return math.degrees(math.atan2(y, x)), -math.degrees(math.asin(z))


@pytest.mark.parametrize("exposure", [0.004, 0.2, 1.0, 4.0])
def test_display_is_the_encoded_exposed_radiance(renderer: Renderer, exposure: float) -> None:
    coded = quake_sky(by_direction, 64)
    scene = make_scene([sphere((100, 0, 0), 30)], point((0, 50, 60), 500), sky=coded)
    view, settings = camera((0, 0, 0)), Settings(exposure=exposure)
    for stage in (View.FINAL, View.SHADING, View.DIRECT, View.ENVIRONMENT, View.LAMBERTIAN):
        linear = renderer.render(scene, view, [stage], settings=settings, linear=True)[stage]
        scale = exposure if stage.is_light else 1.0
        shown = renderer.render(scene, view, [stage], settings=settings)[stage]
        assert shown.dtype == np.uint8
        assert np.abs(shown / 255 - srgb_encoded(linear * scale)).max() <= 0.6 / 255  # rounded
    normals = renderer.render(scene, view, ["normals"], linear=True)[View.NORMALS]
    shown = renderer.render(scene, view, ["normals"])[View.NORMALS]
    assert np.abs(shown / 255 - normals).max() <= 1 / 255  # data, not encoded


def test_display_blends_in_linear_light(renderer: Renderer, tmp_path: Path) -> None:
    """Half-covering glass over a bright sky."""
    pixels = np.full((4, 4, 4), (255, 128, 0, 128), np.uint8)
    archive = image_archive(tmp_path, {"glass.png": pixels})
    blend = (BlendFactor.SRC_ALPHA, BlendFactor.ONE_MINUS_SRC_ALPHA)
    pane = of(Material("glass", "glass.png", blend=blend), quad((9, 0, 0), (0, -9, 0), (0, 0, 9)))
    scene = make_scene(pane, sky=WHITE_SKY, archive=archive)
    for exposure in (0.25, 1.0):
        settings = Settings(exposure=exposure)
        linear = renderer.render(scene, camera((0, 0, 0)), settings=settings, linear=True)
        shown = renderer.render(scene, camera((0, 0, 0)), settings=settings)
        expected = srgb_encoded(linear[View.FINAL] * exposure)
        assert np.abs(shown[View.FINAL] / 255 - expected).max() <= 2 / 255


def test_views_show_nothing_but_black_where_there_is_no_surface(draw: Draw) -> None:
    """The sky is drawn in the final view alone."""
    scene, view = make_scene([sphere((100, 0, 0), 30)], sky=WHITE_SKY), camera((0, 0, 0))
    for stage in View:
        if stage in (View.FINAL, View.DEPTH, View.SHADOW_MAP):
            continue
        assert not draw(scene, view, stage)[0].any(), stage
    assert (draw(scene, view, View.FINAL)[0] == 1).all()


def test_sky_is_behind_everything_even_far_away(draw: Draw) -> None:
    far = turned([quad((0, 0, 0), (0, -9e4, 0), (0, 0, 9e4))], rotation((0, 0, 1), 0), (6e4, 0, 0))
    scene = make_scene([*far, sphere((20, 0, 0), 2)], sky=cube_map((255, 255, 255)))
    assert not draw(scene, camera((0, 0, 0)), View.FINAL, sky_light=False).any()


def test_gpu_sees_the_same_low_mip_levels_of_the_sky(renderer: Renderer) -> None:
    """`towards_axes` against the cube map's own MIP levels, looked up by the hardware."""
    random = np.random.default_rng(5)
    noise = cube_map(random.integers(0, 256, (6, 32, 32, 3), np.uint8))
    gpu_scene = renderer.open(make_scene([floor()], sky=noise))
    context = gpu_scene.context
    program = context.program(
        vertex_shader="#version 330 core\nvoid main() { gl_Position = vec4(gl_VertexID == 1 ? 3.0 :"
        " -1.0, gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0); }",
        fragment_shader="#version 330 core\nuniform samplerCube sky; uniform float level;"
        "out vec4 value; void main() { int k = int(gl_FragCoord.x); vec3 d = vec3(0.0);"
        "d[k / 2] = 1.0 - 2.0 * float(k % 2); value = textureLod(sky, d, level); }",
    )
    target = context.framebuffer([context.texture((6, 1), 4, dtype="f4")])
    array = context.vertex_array(program, [])
    context.enable_only(moderngl.NOTHING)
    try:
        for level in (0.0, 1.0, 2.5, 4.0, 4.25, 5.0, 9.0):
            target.use()
            gpu_scene.sky.use(0)
            program["level"] = level
            array.render(vertices=3)
            seen = np.frombuffer(target.read(components=3, dtype="f4"), np.float32).reshape(6, 3)
            # Each MIP level is rounded to nine bits anew.
            np.testing.assert_allclose(seen, noise.towards_axes(level), atol=0.004)
    finally:
        renderer.target().framebuffer.use()  # moderngl binds the one used last again
        target.color_attachments[0].release()
        for thing in (target, array, program):
            thing.release()
