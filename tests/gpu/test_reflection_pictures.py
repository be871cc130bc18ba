"""Images looked up by where a surface mirrors the eye's ray to; coordinates are worked out here.

Formula: ``RB_CalcEnvironmentTexCoords`` of ioquake3's ``code/renderergl1/tr_shade_calc.c``.
"""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from conftest import Draw
from figures import at, figure, placed, with_characters
from followspot.arrays import Floats
from followspot.assets.archive import Archive
from followspot.assets.shader_motion import Rotate, Scroll
from followspot.passes.view import View
from followspot.scene.material import Laid, Layer, Material
from followspot.scene.motion import STILL, Motion
from synthetic import Piece, floor, image_archive, looking, make_scene, of, rotation, sphere

pytestmark = pytest.mark.gl

EYE = (-90.0, 30.0, 60.0)
VIEW = looking(EYE, (0, 0, 10), 50)
PLACE, YAW, TIME = (8.0, -4.0, 12.0), 70.0, 0.7
MIRROR = Material("metal", "noise.png", mirrors=True)
COVERAGE = 100  # of 255: the layer's alpha


@pytest.fixture
def archive(tmp_path: Path) -> Archive:
    noise = np.random.default_rng(2).integers(0, 256, (32, 32, 4), np.uint8)
    noise[..., 3] = 255
    half = np.roll(noise, 5, axis=0)
    half[..., 3] = COVERAGE
    return image_archive(tmp_path, {"noise.png": noise, "half.png": half})


def ball(material: Material) -> list[Piece]:
    """Longer than high, so that its axes can be told apart."""
    (round_,) = of(material, sphere((0, 0, 0), 30))
    vertices = round_.vertices.copy()
    vertices["position"] *= np.array([1.0, 0.5, 0.75], np.float32)
    vertices["texcoord"] = vertices["position"][:, :2] / 20
    return [replace(round_, vertices=vertices)]


def mirroring(pieces: Sequence[Piece], axes: Floats, seconds: float = 0.0) -> list[Piece]:
    """Pieces in the world that do not mirror, with the coordinates that mirrors would have."""
    made = []
    for piece in pieces:
        vertices = piece.vertices.copy()
        to_eye = np.array(EYE) - vertices["position"]
        to_eye /= np.linalg.norm(to_eye, axis=1, keepdims=True)
        normal = vertices["normal"].astype(np.float64)
        away = 2 * (normal * to_eye).sum(axis=1, keepdims=True) * normal - to_eye
        _, y, z = axes.T @ away.T  # in the model's axes
        s_t = np.stack([0.5 + y / 2, 0.5 - z / 2, np.ones_like(y)], axis=1)
        terms = np.array(piece.material.motion.terms(seconds))
        vertices["texcoord"] = s_t @ terms[:3]
        still = replace(piece.material, mirrors=False, motion=STILL)
        made.append(replace(piece, vertices=vertices, material=still))
    return made


@pytest.mark.parametrize("motion", [STILL, Motion((Scroll(0.3, 0.1), Rotate(40)))])
def test_a_level_mirrors_in_the_worlds_axes(draw: Draw, archive: Archive, motion: Motion) -> None:
    pieces = placed(ball(replace(MIRROR, motion=motion)), PLACE, YAW)
    mirrors, plain = (
        draw(make_scene([floor(200), *each], archive=archive), VIEW, View.LAMBERTIAN, time=TIME)
        for each in (pieces, mirroring(pieces, np.eye(3), TIME))
    )
    assert (np.abs(mirrors - 1) > 0.1).mean() > 0.05, "the ball is seen"
    assert np.abs(mirrors - plain).max() < 0.02 and np.abs(mirrors - plain).mean() < 1e-4


def test_a_figure_mirrors_in_its_own_axes(draw: Draw, archive: Archive) -> None:
    room = make_scene([floor(200)], archive=archive)
    shown = draw(
        with_characters(room, at(figure([ball(MIRROR)]), PLACE, YAW)), VIEW, View.LAMBERTIAN
    )
    axes = rotation((0, 0, 1), YAW)
    pieces = mirroring(placed(ball(MIRROR), PLACE, YAW), axes)
    level = draw(make_scene([floor(200), *pieces], archive=archive), VIEW, View.LAMBERTIAN)
    assert (np.abs(shown - level) > 0.02).mean() < 1e-3, "but for pixels along its outline"
    assert (np.abs(shown - 1) > 0.1).mean() > 0.05


def test_what_lies_over_a_mirror_stays_where_it_is(draw: Draw, archive: Archive) -> None:
    over = replace(MIRROR, image="half.png", mirrors=False)
    both, mirror, layer = (
        draw(make_scene(placed(ball(m), PLACE), archive=archive), VIEW, View.LAMBERTIAN)
        for m in (replace(MIRROR, layer=Layer("half.png")), MIRROR, over)
    )
    expected = mirror + (layer - mirror) * COVERAGE / 255
    assert np.abs(layer - mirror).mean() > 0.02
    np.testing.assert_allclose(both, expected, atol=2e-3)


@pytest.mark.parametrize("motion", [STILL, Motion((Scroll(0.3, 0.1), Rotate(40)))])
def test_a_mirrored_layer_adds_what_a_mirror_shows(
    draw: Draw, archive: Archive, motion: Motion
) -> None:
    layer = Layer("noise.png", Laid.SHEEN, mirrors=True, motion=motion)
    base = replace(MIRROR, image="half.png", mirrors=False)
    both, mirror, alone = (
        draw(make_scene(placed(ball(m), PLACE), archive=archive), VIEW, View.LAMBERTIAN, time=TIME)
        for m in (replace(base, layer=layer), replace(MIRROR, motion=motion), base)
    )
    assert np.abs(mirror - alone).mean() > 0.02
    np.testing.assert_allclose(both, np.minimum(mirror + alone, 1), atol=2e-3)
