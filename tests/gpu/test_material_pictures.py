"""How materials look: blended, cut out, lying on others, at a slant; and light from all around."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from conftest import Draw
from followspot.assets.shader_values import AlphaTest, BlendFactor, Sides
from followspot.passes.view import View
from followspot.present.renderer import Renderer
from followspot.scene.material import Material, Shade
from followspot.scene.settings import Settings
from synthetic import (
    WHITE_SKY,
    camera,
    floor,
    image_archive,
    looking,
    make_scene,
    of,
    quad,
    turned,
)

pytestmark = pytest.mark.gl

BLEND = (BlendFactor.SRC_ALPHA, BlendFactor.ONE_MINUS_SRC_ALPHA)


def test_blended_surfaces_are_drawn_far_to_near_over_what_is_behind(
    draw: Draw, tmp_path: Path
) -> None:
    def pane(name: str, rgba: tuple[int, int, int, int]) -> Material:
        return Material(name, f"{name}.png", blend=BLEND, shade=Shade.LIT)

    colours = {"red": (255, 0, 0, 128), "green": (0, 255, 0, 64)}
    images = {f"{n}.png": np.full((4, 4, 4), c, np.uint8) for n, c in colours.items()}
    archive = image_archive(tmp_path, images)
    pieces = []
    for x, name in ((100, "red"), (50, "green")):
        pieces += of(pane(name, colours[name]), quad((x, 0, 0), (0, -x, 0), (0, 0, x)))
    scene = make_scene(pieces, sky=WHITE_SKY, archive=archive)
    over = 1.0 - 128 / 255
    expected = np.array([over + 128 / 255, over, over]) * (1 - 64 / 255) + (0, 64 / 255, 0)
    shown = draw(scene, camera((0, 0, 0)), View.FINAL)
    np.testing.assert_allclose(shown, np.broadcast_to(expected, shown.shape), atol=1e-6)
    behind = make_scene(
        [*pieces, quad((30, 0, 0), (0, -30, 0), (0, 0, 30))], sky=WHITE_SKY, archive=archive
    )
    np.testing.assert_allclose(draw(behind, camera((0, 0, 0)), View.FINAL), 1, atol=1e-6)


def test_blended_surfaces_come_far_to_near_also_where_another_camera_culls(
    draw: Draw, renderer: Renderer, tmp_path: Path
) -> None:
    """Flown round to the panes' other side: the nearer one is the other one."""
    colours = {"red": (255, 0, 0, 128), "green": (0, 255, 0, 128)}
    images = {f"{n}.png": np.full((4, 4, 4), c, np.uint8) for n, c in colours.items()}
    pieces = []
    for x, name in ((100, "red"), (50, "green")):
        pane = Material(name, f"{name}.png", blend=BLEND, sides=Sides.BOTH)
        pieces += of(pane, quad((x, 0, 0), (0, -99, 0), (0, 0, 99)))
    scene = make_scene(pieces, sky=WHITE_SKY, archive=image_archive(tmp_path, images))
    front, back = camera((0, 0, 0)), camera((150, 0, 0), yaw=180)
    expected = draw(scene, back, View.FINAL, culling=False)
    settings = Settings(exposure=1.0)
    for view in (front, back):
        seen = renderer.render(scene, view, settings=settings, linear=True, culled_from=front)
    np.testing.assert_array_equal(seen[View.FINAL], expected)
    assert (seen[View.FINAL][60, 80] != draw(scene, front, View.FINAL)[60, 80]).any()


def test_alpha_says_where_there_is_a_surface_whatever_is_blended_over_it(
    renderer: Renderer,
) -> None:
    """Which decides what an exposure is measured on."""
    one, zero = BlendFactor.ONE, BlendFactor.ZERO
    for blend in ((one, one), (zero, BlendFactor.ONE_MINUS_SRC_COLOR), BLEND):
        pane = quad((50, 0, 0), (0, -20, 0), (0, 0, 20))
        pieces = [quad((90, 0, 0), (0, -50, 0), (0, 0, 50)), *of(Material("p", blend=blend), pane)]
        scene, view = make_scene(pieces, sky=WHITE_SKY), camera((0, 0, 0))
        depth = renderer.render(scene, view, [View.DEPTH], linear=True)[View.DEPTH]
        renderer.render(scene, view, linear=True)
        alpha = renderer.target(linear=True).read(components=4)[..., 3]
        np.testing.assert_array_equal(alpha, np.isfinite(depth).astype(np.float32))


def test_decals_lie_on_the_surface_that_they_share_a_plane_with(draw: Draw, tmp_path: Path) -> None:
    """Tilted, and cut into triangles of their own: not a pixel of the wall comes through."""
    black = {"black.png": np.zeros((4, 4, 3), np.uint8)}
    wall = quad((200, 3, 1), (90, -300, 11), (31, 7, 300))
    decal = quad((200, 3, 1), (45.3, -151, 5.537), (16.1, 3.63, 155.8))
    on_it = Material("decal", "black.png", polygon_offset=True, blend=BLEND)
    scene = make_scene([wall, *of(on_it, decal)], archive=image_archive(tmp_path, black))
    view = camera((-400, 0, 0), fov=20)
    shown = draw(scene, view, View.LAMBERTIAN)
    alone = make_scene(of(replace(on_it, blend=None), decal), archive=scene.archive)
    covered = np.isfinite(draw(alone, view, View.DEPTH))
    assert covered.sum() > 2000
    assert (shown[covered] == 0).all()


def test_anisotropy_sharpens_what_is_seen_at_a_slant(draw: Draw, tmp_path: Path) -> None:
    stripes = np.zeros((64, 64, 3), np.uint8)
    stripes[:, ::2] = 255
    ground = quad((0, 0, 0), (600, 0, 0), (0, 600, 0))
    ground.vertices["texcoord"] *= 20
    scene = make_scene(
        of(Material("stripes", "s.png"), ground),
        archive=image_archive(tmp_path, {"s.png": stripes}),
    )
    view = looking((0, -580, 10), (0, 0, 0), 60)
    plain, sharp, again = (
        draw(scene, view, View.LAMBERTIAN, anisotropy=samples)[70:80].std()
        for samples in (1.0, 16.0, 1.0)
    )
    assert sharp > 1.2 * plain and again == plain


def test_light_from_all_around_is_added_to_the_skys(draw: Draw) -> None:
    """Also where it alone has changed since the last frame."""
    scene, view = make_scene([floor()], sky=WHITE_SKY), camera((0, 0, 50), pitch=60)
    for ambient in (0.0, 0.25, 2.0):
        seen = draw(replace(scene, ambient=ambient), view, View.ENVIRONMENT)
        np.testing.assert_allclose(seen[60, 80], 1 + ambient, rtol=1e-6)


def test_constant_albedo_leaves_blended_surfaces_out(draw: Draw) -> None:
    glass = of(Material("glass", blend=BLEND), quad((50, 0, 0), (0, -9, 0), (0, 0, 9)))
    scene = make_scene(glass, sky=WHITE_SKY)
    np.testing.assert_array_equal(draw(scene, camera((0, 0, 0)), View.FINAL, albedo=0.2), 1)


@pytest.mark.parametrize(
    ("test", "kept"),
    [
        (AlphaTest.GT0, [False, True, True, True, True]),
        (AlphaTest.LT128, [True, True, True, False, False]),
        (AlphaTest.GE128, [False, False, False, True, True]),
    ],
)
def test_alpha_test_compares_as_the_game_does(
    draw: Draw, tmp_path: Path, test: AlphaTest, kept: list[bool]
) -> None:
    for alpha, expected in zip((0, 1, 127, 128, 255), kept, strict=True):
        pixels = np.full((4, 4, 4), 255, np.uint8)
        pixels[..., 3] = alpha
        archive = image_archive(tmp_path, {f"a{alpha}.png": pixels})
        sheet = of(
            Material("sheet", f"a{alpha}.png", alpha_test=test),
            quad((50, 0, 0), (0, -90, 0), (0, 0, 90)),
        )
        depth = draw(make_scene(sheet, archive=archive), camera((0, 0, 0)), View.DEPTH)
        assert np.isfinite(depth).all() == expected, alpha


def test_a_clamped_image_still_repeats_for_other_materials(draw: Draw, tmp_path: Path) -> None:
    """Clamping belongs to a material's stage, not to the image that materials share."""
    stripes = np.zeros((4, 32, 3), np.uint8)
    stripes[:, 16:] = 255
    archive = image_archive(tmp_path, {"stripes.png": stripes})
    wall = quad((50, 0, 0), (0, -50, 0), (0, 0, 50))
    wall.vertices["texcoord"] *= 2
    repeats = of(Material("repeats", "stripes.png"), wall)
    clamps = of(Material("clamps", "stripes.png", clamps=True), wall)
    far_off = turned(clamps, np.eye(3), (9000, 0, 0))
    view = camera((0, 0, 0))
    alone = draw(make_scene(repeats, archive=archive), view, View.LAMBERTIAN)
    clamped = draw(make_scene(clamps, archive=archive), view, View.LAMBERTIAN)
    assert (alone != clamped).any()
    both = draw(make_scene([*repeats, *far_off], archive=archive), view, View.LAMBERTIAN)
    np.testing.assert_array_equal(both, alone)
