"""The pixel inspector: its values agree with one another, with the picture and with geometry."""

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from figures import at, figure, with_characters
from followspot.assets.shader_deform import Move
from followspot.assets.shader_motion import Shape, Wave
from followspot.assets.shader_values import AlphaTest, BlendFactor, Sides
from followspot.errors import UsageError
from followspot.passes.frame import FrameInput
from followspot.passes.shadow_preview import ShadowPreview
from followspot.passes.shadow_reading import read_distance
from followspot.passes.view import View
from followspot.present.pixel import PixelReport, ShadowLookup, inspect_pixel
from followspot.present.renderer import Renderer
from followspot.scene.camera import Camera
from followspot.scene.deform import Deforms
from followspot.scene.fog import Fog
from followspot.scene.light import SpotLight
from followspot.scene.load import load
from followspot.scene.material import Laid, Layer, Material, Shade
from followspot.scene.scene import Scene
from followspot.scene.settings import CullFace, Settings
from followspot.spaces import vec3
from synthetic import (
    WHITE_SKY,
    box,
    camera,
    floor,
    image_archive,
    looking,
    make_scene,
    of,
    point,
    quad,
    rays,
    sphere,
    spot,
    srgb_encoded,
)

pytestmark = pytest.mark.gl

GLASS = (BlendFactor.SRC_ALPHA, BlendFactor.ONE_MINUS_SRC_ALPHA)


@pytest.fixture
def garden(tmp_path: Path) -> Scene:
    """All kinds of surfaces under two spot lights and a point light."""
    random = np.random.default_rng(4)
    leaf = random.integers(60, 256, (8, 8, 4), np.uint8)
    leaf[..., 3] = np.kron([[0, 255], [255, 0]], np.ones((4, 4)))
    archive = image_archive(tmp_path, {"leaf.png": leaf, "wall.png": leaf[..., :3]})
    lamp = Material("lamp", "wall.png", layer=Layer("leaf.png", Laid.GLOW))
    sheet = Material("leaf", "leaf.png", sides=Sides.BOTH, alpha_test=AlphaTest.GE128)
    pane = Material("pane", "leaf.png", blend=GLASS, shade=Shade.LIT)
    pieces = [floor(400), *of(Material("wall", "wall.png"), *box((40, -30, 0), (90, 30, 50)))]
    pieces += of(sheet, quad((0, 60, 40), (50, 0, 0), (0, 0, 40)))
    pieces += of(pane, quad((0, -70, 40), (50, 0, 0), (0, 0, 40)))
    pieces += of(lamp, *box((-70, 60, 0), (-30, 110, 60)))
    pieces += of(Material("ball"), sphere((0, 0, 30), 25))
    lamps = (
        spot((150, 60, 220), (30, 0, 0), 30, 6e4, 0.3),
        spot((-60, -200, 150), (30, -30, 0), 35, 3e4),
        point((0, 150, 120), 3e3),
    )
    scene = make_scene(pieces, *lamps, sky=WHITE_SKY, archive=archive, environment_constant=0.2)
    figures = at(figure([box((-9, -9, -9), (9, 9, 9))], name="cube"), (100, 90, 15), yaw=30)
    return with_characters(scene, figures)


def frame_of(scene: Scene, view: Camera, settings: Settings | None = None) -> FrameInput:
    settings = settings or Settings(exposure=0.5)
    return FrameInput(scene, view, settings, 0.5)


def reports(renderer: Renderer, frame: FrameInput, count: int, seed: int) -> list[PixelReport]:
    renderer.open(frame.scene)
    random = np.random.default_rng(seed)
    places = random.integers((0, 0), renderer.size, (count, 2)).tolist()
    return [inspect_pixel(renderer, frame, x, y) for x, y in places]


def check(report: PixelReport, frame: FrameInput, glow: float = 0.0) -> None:
    """The formulae between one pixel's values; `glow` is the radiance of fog."""
    scene = frame.scene
    np.testing.assert_allclose(report.exposed, report.radiance * frame.exposure)
    steps = 3 if report.in_front else 1  # what is blended is rounded before and behind
    shown = srgb_encoded(report.exposed)
    np.testing.assert_allclose(report.displayed / 255, shown, atol=steps / 255)
    if report.surface is None:
        assert report.position is None and report.normal is None and math.isinf(report.depth)
        assert not report.direct.any() and not report.environment.any() and not report.shadows
        return
    assert report.position is not None and report.normal is not None
    assert abs(np.linalg.norm(report.normal) - 1) < 1e-5
    to_eye = frame.camera.position - report.position
    assert abs(-to_eye @ frame.camera.forward - report.depth) < 1e-4 * report.depth
    if not report.in_front:
        lit = report.rho / np.pi * (report.direct + report.environment)
        lit += report.fog * (glow - lit) + report.emitted
        np.testing.assert_allclose(report.radiance, lit, rtol=2e-5, atol=1e-7)
    expected = np.zeros(3)
    for light in frame.lights:
        towards = light.position - report.position
        r = np.linalg.norm(towards)
        share: Any = 1.0
        if light.casts_shadow:  # these come first, and of a point light's sides there is one
            share = report.shadows[frame.lights.index(light)].arrives
        if isinstance(light, SpotLight):
            cosine = -(towards @ light.direction) / r
            rim = np.clip(
                (cosine - light.cos_rim) / max(light.cos_full - light.cos_rim, 1e-6), 0, 1
            )
            share *= rim * rim * (3 - 2 * rim)
        intensity = light.intensity / scene.metres_per_unit**2
        expected += share * intensity * max(report.normal @ towards, 0) / r**3
    doubtful = any(is_close_call(lookup) for lookup in report.shadows)
    if not doubtful:
        np.testing.assert_allclose(report.direct, expected, rtol=2e-3, atol=2e-3)
    for lookup in report.shadows:
        np.testing.assert_allclose(lookup.divided, lookup.light_space[:3] / lookup.light_space[3])
    if report.shadows and not doubtful:
        key = report.shadows[0]
        assert abs(report.visibility - key.arrives * key.is_lit) < 0.01
        if key.is_lit and min(key.arrives, 1 - key.arrives) < 0.01:
            passes = key.divided[2] <= key.stored
            assert passes == (key.arrives > 0.5)
            assert (key.compared_distance <= key.stored_distance) == passes


def is_close_call(lookup: ShadowLookup) -> bool:
    """Whether float32 may compare otherwise than float64."""
    partly = 0 < lookup.arrives < 1
    return partly or abs(lookup.divided[2] - lookup.stored) < 2e-5


@pytest.mark.parametrize(
    "settings",
    [
        Settings(exposure=0.5),
        Settings(exposure=0.5, shadow_taps=3, shadow_cull=CullFace.BACK, shadow_bias=1.0),
        Settings(exposure=0.5, albedo=0.3, sky_light=False, shadow_fit=False),
    ],
    ids=["plain", "other shadows", "albedo"],
)
def test_values_agree_all_over_a_scene(
    renderer: Renderer, garden: Scene, settings: Settings
) -> None:
    frame = frame_of(garden, looking((-150, 40, 140), (20, 0, 10)), settings)
    found = reports(renderer, frame, 40, 1)
    for report in found:
        check(report, frame)
    seen = {report.surface.material if report.surface else None for report in found}
    assert {"white", "ball", "lamp"} <= seen
    for report in found:
        shines = report.surface is not None and report.surface.material == "lamp"
        is_lamp = shines and frame.settings.albedo is None
        assert report.emitted.any() == is_lamp
        if is_lamp and not report.in_front:
            share = np.linalg.norm(report.emitted) / np.linalg.norm(report.radiance)
            assert 0 < share <= 1
    lit = [lookup for report in found for lookup in report.shadows if lookup.is_lit]
    doubtful = sum(is_close_call(lookup) for lookup in lit)
    assert doubtful < 0.7 * len(lit)
    assert {round(lookup.arrives) for lookup in lit} == {0, 1}


def test_fog_is_told_apart(renderer: Renderer, garden: Scene) -> None:
    """It is as bright as half of the sky, which is as bright all over."""
    fog = Fog(vec3((-200, -20, -50)), vec3((200, 300, 300)), vec3((0.5, 0.5, 0.5)), 0.004)
    foggy = replace(garden, level=replace(garden.level, fogs=(fog,)))
    frame = frame_of(foggy, looking((-150, 40, 140), (20, 0, 80)))
    found = reports(renderer, frame, 60, 2)
    for report in found:
        check(report, frame, glow=0.1)
        if report.surface is None and not report.in_front:
            sky = 0.2 + report.fog * (0.1 - 0.2)
            np.testing.assert_allclose(report.radiance, sky, rtol=1e-3)
    shares: dict[bool, set[float]] = {True: set(), False: set()}
    for report in found:
        shares[report.surface is None].add(round(report.fog, 1))
    assert min(map(len, shares.values())) > 2
    clear = frame_of(foggy, frame.camera, Settings(exposure=0.5, fog=False))
    assert {report.fog for report in reports(renderer, clear, 9, 2)} == {0.0}


def test_a_surface_that_has_moved_is_found_where_it_is_drawn(renderer: Renderer) -> None:
    """And its shadow is looked up where it rests."""
    raised = Deforms((Move((0, 0, 60), Wave(Shape.SIN, 1, 0, 0, 0)),))
    banner = of(Material("banner", deforms=raised), quad((0, 0, 0), (60, 0, 0), (0, 60, 0)))
    # Above the banner at rest, below where it is drawn: it throws a shadow, and hides nothing.
    slab, lamp = box((-10, -10, 20), (10, 10, 30)), point((3, 2, 200), 900)
    scene = make_scene([floor(400, -80), *banner, *slab], lamp)
    frame = frame_of(scene, camera((0, 0, 300), 0, 90, 60))
    renderer.open(scene)
    width, height = renderer.size
    found = [inspect_pixel(renderer, frame, width // 2 + k, height // 2) for k in range(-20, 21, 4)]
    for report in found:
        assert report.surface is not None and report.surface.material == "banner"
        assert report.position is not None and abs(report.position[2] - 60) < 0.01
        key = report.shadows[0]
        assert abs(report.visibility - key.arrives * key.is_lit) < 0.02
    assert {round(report.visibility) for report in found} == {0, 1}


def test_values_agree_in_the_courtyard(renderer: Renderer) -> None:
    scene = load("courtyard")
    with scene.archive:
        for number, name in enumerate(("title", "fountain")):
            frame = frame_of(scene, scene.camera(name), scene.settings)
            found = reports(renderer, frame, 12, number)
            for report in found:
                check(report, frame)
            named = [report.surface for report in found if report.surface]
            assert len(named) > 6
            assert all(each.material.startswith("textures/courtyard/") for each in named)
            assert all(each.texture in scene.images for each in named)


def test_shares_of_the_filter_are_the_shaders(renderer: Renderer, garden: Scene) -> None:
    """Also along shadow edges, where comparisons are partly one way and partly the other."""
    settings = Settings(exposure=0.5, shadow_map_size=64)
    frame = frame_of(garden, looking((-50, 40, 240), (20, 0, 10)), settings)
    renderer.open(garden)
    picture = renderer.render(
        garden, frame.camera, ["shadow"], settings=frame.settings, linear=True
    )
    rows, columns = np.nonzero((picture["shadow"] > 0.02) & (picture["shadow"] < 0.98))
    chosen = np.random.default_rng(3).choice(len(rows), 15, replace=False)
    apart = []
    for x, y in zip(columns[chosen].tolist(), rows[chosen].tolist(), strict=True):
        report = inspect_pixel(renderer, frame, x, y)
        assert report.shadows[0].is_lit
        assert abs(report.visibility - picture["shadow"][y, x]) < 1e-6
        apart.append(abs(report.visibility - report.shadows[0].arrives))
    assert np.median(apart) < 0.01
    assert np.mean(np.array(apart) < 0.03) > 0.85


def pixel_of(view: Camera, place: tuple[float, float, float], size: tuple[int, int]) -> list[int]:
    """(x, y) of the pixel that shows a place."""
    towards = rays(view, size)
    away = np.asarray(place) - view.position
    cosine = towards @ away / np.linalg.norm(towards, axis=2) / np.linalg.norm(away)
    y, x = np.unravel_index(cosine.argmax(), cosine.shape)
    return [int(x), int(y)]


def test_surfaces_by_name(renderer: Renderer, garden: Scene) -> None:
    """Walls, characters, what is behind glass and behind holes in leaves."""
    renderer.open(garden)
    size = renderer.size
    view = camera((100, -40, 15), yaw=90, fov=40)
    report = inspect_pixel(renderer, frame_of(garden, view), *pixel_of(view, (100, 90, 15), size))
    assert report.surface is not None
    assert (report.surface.character, report.surface.face) == ("cube", None)
    assert report.position is not None and np.linalg.norm(report.position - (100, 90, 15)) < 16

    view = camera((0, -170, 40), yaw=90, fov=60)
    for x, behind in ((20, "leaf"), (-20, None)):
        through_glass = pixel_of(view, (x, -70, 55), size)
        report = inspect_pixel(renderer, frame_of(garden, view), *through_glass)
        assert (report.surface and report.surface.material) == behind
        assert [each.material for each in report.in_front] == ["pane"]
        assert report.in_front[0].texture == "leaf.png"

    view = camera((0, 170, 40), yaw=-90, fov=60)
    for x, seen in ((25, "leaf"), (-25, None)):
        report = inspect_pixel(renderer, frame_of(garden, view), *pixel_of(view, (x, 60, 60), size))
        assert (report.surface and report.surface.material) == seen
        assert report.in_front == (), "the pane's back is not drawn"


def test_pixels_that_are_not_there(renderer: Renderer, garden: Scene) -> None:
    renderer.open(garden)
    for x, y in ((-1, 0), (0, -1), (renderer.size[0], 0), (0, renderer.size[1])):
        with pytest.raises(UsageError, match="is not in a picture of"):
            inspect_pixel(renderer, frame_of(garden, camera((0, 0, 50))), x, y)


def test_maps_are_shown_and_read_as_they_are(renderer: Renderer, garden: Scene) -> None:
    """The preview's greys and single depths against the whole map read back."""
    frame = frame_of(garden, looking((-150, 40, 140), (20, 0, 10)))
    gpu_scene = renderer.open(garden)
    before = shown_shadow(renderer, frame)
    shadow = renderer.pipeline.shadow
    size = shadow.size
    preview = ShadowPreview(gpu_scene.context)
    for number in (0, 1):
        distance = read_distance(shadow, number)
        wide, *near = shadow.tiles_of(number)
        whole = 0, 0, size, size
        depths = shadow.read_depths(wide, whole)
        np.testing.assert_array_equal(
            shadow.read_depths(wide, (300, 200, 40, 30)), depths[200:230, 300:340]
        )
        expected = wide.frustum.distances(depths).astype(np.float32)
        for tile in near:  # finer depths, where it holds the texels' middles
            scale, shift = wide.finer_from_here
            x, y = np.meshgrid((np.arange(size) + 0.5) / size, 1 - (np.arange(size) + 0.5) / size)
            x, y = x * scale[0] + shift[0], y * scale[1] + shift[1]
            inside = (np.minimum(x, y) >= 0) & (np.maximum(x, y) < 1)
            finer = tile.frustum.distances(shadow.read_depths(tile, whole)).astype(np.float32)
            column, row = (x[inside] * size).astype(int), (y[inside] * size).astype(int)
            expected[inside] = finer[size - 1 - row, column]
            assert inside.sum() > 100
        np.testing.assert_array_equal(distance, expected)
        hit = np.isfinite(distance)
        assert hit.mean() > 0.05
        nearest, farthest = distance[hit].min(), distance[hit].max()
        share = (np.where(hit, distance, nearest) - nearest) / (farthest - nearest)
        grey = np.where(hit, 0.05 + 0.85 * share, 1) * 255
        texture = preview.draw(shadow, number)
        drawn = np.frombuffer(texture.read(), np.uint8).reshape(size, size, 4)
        np.testing.assert_allclose(drawn[..., 0], grey, atol=0.6)
        texture.write(bytes(size * size * 4))
        assert preview.draw(shadow, number) is texture
        assert not any(texture.read()), "the same map is not drawn again"
    np.testing.assert_array_equal(shown_shadow(renderer, frame), before)
    preview.release()


def shown_shadow(renderer: Renderer, frame: FrameInput) -> NDArray[np.uint8]:
    renderer.draw(replace(frame, view=View.SHADOW))
    return renderer.target().read()
