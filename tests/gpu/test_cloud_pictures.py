"""Moving clouds in pictures, against NumPy's of the same layers at a time, pixel by pixel."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image as PillowImage

from conftest import Draw
from followspot.arrays import Floats
from followspot.assets.image import Image
from followspot.assets.shader_parser import find_entries
from followspot.passes.view import View
from followspot.scene import clouds
from followspot.scene.camera import Camera
from followspot.scene.clouds import MAX_LAYERS, Clouds, Layer
from followspot.scene.scene import Scene
from followspot.scene.sky import CubeMap
from synthetic import SIZE, camera, cube_map, floor, make_scene, rays, srgb_encoded

pytestmark = pytest.mark.gl

BOX = cube_map((90, 30, 200), size=256)
SCROLLS = "tcMod scroll 0.03 -0.07"


def puffs(seed: int) -> Image:
    """Soft noise that repeats, in all four channels."""
    noise = np.random.default_rng(seed).integers(0, 256, (4, 4, 4), np.uint8)
    tiled = PillowImage.fromarray(np.tile(noise, (3, 3, 1)))
    soft = tiled.resize((192, 192), PillowImage.Resampling.BICUBIC)
    return Image(np.asarray(soft)[64:128, 64:128].copy(), True, "puffs")


def layer(text: str, seed: int) -> Layer:
    (entry,), wrong = find_entries(f"sky\n{{\n{{\nmap a\n{text}\n}}\n}}", "test.shader")
    assert not wrong
    return Layer(entry.read().stages[0], puffs(seed))


def under(made: Clouds) -> Scene:
    return replace(make_scene([floor(20)]), clouds=made)


COVER = "blendFunc blend"
LAYERS = {
    "one": [SCROLLS],
    "sum": ["tcMod scale 2 3", f"blendFunc add\n{SCROLLS}"],
    "product": [SCROLLS, "blendFunc filter\ntcMod scale 3 2\ntcMod scroll 0.05 0.03"],
    "cover": [SCROLLS, f"{COVER}\ntcMod rotate 9"],
    "three": [SCROLLS, "blendFunc filter", f"{COVER}\ntcMod scale 2 2\n{SCROLLS}"],
    "four": [SCROLLS, "blendFunc filter", COVER, "blendFunc gl_one gl_one_minus_src_color"],
    "colour": [
        f"rgbGen const ( 0.4 0.9 0.7 )\n{SCROLLS}",
        "blendFunc add\nrgbGen const ( 0.1 0.3 0.9 )",
    ],
    "wave": ["rgbGen wave sin 0.5 0.4 0 0.3\ntcMod scale 2 2"],
    "before": ["blendFunc add\n" + SCROLLS, "blendFunc gl_one_minus_dst_color gl_one"],
}


def expected(made: Clouds, view: Camera, seconds: float) -> Floats:
    """(h, w, 3) what is displayed of a sky that is seen above its lower face."""
    behind = (0, 0, 0) if made.box is None else made.box.faces[0, 0, 0, :3]
    shown: NDArray[Any] = np.broadcast_to(np.asarray(behind) / 255, (*SIZE[::-1], 3))
    places = clouds.coordinates(rays(view).astype(np.float32), made.height)
    for each in made.layers:
        s, t, one = np.array(each.motion.terms(seconds))[:3]
        found = bilinear(each.image, places[..., :1] * s + places[..., 1:] * t + one)
        color = found[..., :3] * each.color_at(seconds)
        shown = clouds._blended(
            each.stage.blend, *(v.astype(np.float32) for v in (color, found[..., 3:], shown))
        )
    return shown


def bilinear(image: Image, places: Floats) -> Floats:
    """(h, w, 4) colour as displayed and alpha, as GL filters texels that repeat."""
    size = len(image.pixels)
    texels = image.pixels / 255
    at = places * size - 0.5
    low = np.floor(at).astype(int)
    column, row = np.moveaxis(low, -1, 0)
    right, down = np.moveaxis(at - low, -1, 0)[..., np.newaxis]
    near, far = (
        texels[r % size, column % size] * (1 - right)
        + texels[r % size, (column + 1) % size] * right
        for r in (row, row + 1)
    )
    return np.asarray(near * (1 - down) + far * down)


@pytest.mark.parametrize("name", LAYERS)
@pytest.mark.parametrize("box", [None, BOX], ids=["no box", "box"])
def test_clouds_are_where_they_have_moved_to(draw: Draw, name: str, box: CubeMap | None) -> None:
    layers = tuple(layer(text, seed) for seed, text in enumerate(LAYERS[name]))
    made = Clouds(box, layers, 700.0)
    assert made.moves
    for seconds, (yaw, pitch) in ((0.0, (20, -60)), (3.3, (200, -75)), (11.7, (110, -45))):
        view = camera((0, 0, 40), yaw=yaw, pitch=pitch, fov=40)
        shown = draw(under(made), view, View.FINAL, time=seconds)
        wanted = expected(made, view, seconds)
        np.testing.assert_allclose(srgb_encoded(shown), wanted, atol=0.008)
        assert np.ptp(wanted) > 0.02


def test_straight_below_is_the_box_alone(draw: Draw) -> None:
    scene = replace(make_scene([]), clouds=Clouds(BOX, (layer(SCROLLS, 1),), 700.0))
    view = camera((0, 0, 40), pitch=89, fov=60)
    without = replace(scene, sky=BOX, clouds=None)
    np.testing.assert_array_equal(
        draw(scene, view, View.FINAL, time=5.0), draw(without, view, View.FINAL)
    )


def test_what_moves_is_told_from_what_does_not() -> None:
    still = layer("tcMod scale 2 2", 1)
    assert not Clouds(None, (still,), 9.0).moves
    assert not under(Clouds(None, (still,), 9.0)).moves
    assert under(Clouds(None, (still, layer(SCROLLS, 2)), 9.0)).moves
    assert under(Clouds(None, (layer("rgbGen wave sin 0.5 0.4 0 0.3", 2),), 9.0)).moves
    assert not Clouds(None, (still,) * MAX_LAYERS + (layer(SCROLLS, 2),), 9.0).moves
