"""Skies of clouds: where the sphere is seen, what layers make together, which sky is taken."""

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from numpy.typing import NDArray
from PIL import Image as PillowImage

from followspot.assets.archive import Archive
from followspot.assets.image import Image
from followspot.assets.shader_parser import find_entries
from followspot.assets.shader_script import ShaderScript
from followspot.scene import clouds, sky_files
from followspot.scene.clouds import GROUND_RADIUS, LIGHT_SIZE, SIZE, Clouds, Layer
from followspot.scene.sky import CubeMap
from followspot.scene.sky_files import BUILTIN_SKY
from synthetic import cube_map

RNG = np.random.default_rng(3)


def plain(*rgba: int) -> Image:
    return Image(np.full((8, 8, 4), rgba, np.uint8), rgba[3] < 255, "plain")


def script(text: str) -> ShaderScript:
    (found,), wrong = find_entries(f"sky\n{{\n{text}\n}}\n", "test.shader")
    assert not wrong
    return found.read()


def test_clouds_lie_on_a_sphere() -> None:
    """The place that coordinates tell is on the sphere and on the ray from the eye."""
    for height in (128.0, 512.0, 4000.0):
        rays = RNG.standard_normal((200, 3)).astype(np.float32)
        rays[:, 2] = abs(rays[:, 2])
        s, t = clouds.coordinates(rays, height).astype(np.float64).T
        radius = GROUND_RADIUS + height
        x, y = radius * np.cos(s), radius * np.cos(t)
        place = np.stack([x, y, np.sqrt(radius**2 - x**2 - y**2) - GROUND_RADIUS], axis=1)
        along = rays / np.linalg.norm(rays, axis=1, keepdims=True)
        seen = np.einsum("ij,ij->i", place, along)
        assert (seen > 0).all()
        assert_allclose(np.linalg.norm(place - along * seen[:, np.newaxis], axis=1), 0, atol=3)


def test_directions_are_those_of_the_faces() -> None:
    """A face's middle looks along its axis, and its texels where OpenGL looks them up."""
    for face, axis in enumerate(np.repeat(np.eye(3), 2, axis=0) * np.tile([1, -1], 3)[:, None]):
        ways = clouds.directions(face, 4)
        assert_allclose(ways.mean(axis=(0, 1)), axis, atol=1e-6)
        x, y, z = ways.reshape(-1, 3).T
        # OpenGL 3.3, table 3.10: sc, tc and ma by major axis.
        sc, tc = {0: (-z, -y), 1: (z, -y), 2: (x, z), 3: (x, -z), 4: (x, -y), 5: (-x, -y)}[face]
        column, row = np.tile(np.arange(4), 4), np.repeat(np.arange(4), 4)
        assert_allclose((sc + 1) / 2, (column + 0.5) / 4)
        assert_allclose((tc + 1) / 2, (row + 0.5) / 4)


def stage(text: str, image: Image) -> Layer:
    return Layer(script("{\n" + text + "\n}").stages[0], image)


def box() -> CubeMap:
    return cube_map((90, 30, 200))


def test_layers_are_mixed_as_they_are_displayed() -> None:
    """Before a box, which alone is seen straight below."""
    added = stage("map a\nblendFunc GL_ONE GL_ONE", plain(100, 100, 0, 255))
    mixed = stage("map b\nblendFunc GL_SRC_ALPHA GL_ONE_MINUS_SRC_ALPHA", plain(0, 200, 90, 64))
    made = Clouds(
        box(),
        (
            added,
            mixed,
        ),
        512,
    ).sky("sky")
    share = 64 / 255
    expected = np.array([190, 130, 200]) * (1 - share) + np.array([0, 200, 90]) * share
    assert np.abs(made.faces[:5, ..., :3] - expected).max() <= 1
    assert_array_equal(made.faces[5], box().faces[5])


def test_without_a_box_clouds_are_before_black() -> None:
    opaque = stage("map a", plain(10, 200, 30, 255))
    made = Clouds(None, (opaque,), 512).sky("sky")
    assert made.faces.shape == (6, SIZE, SIZE, 4)
    assert (made.faces[:5] == (10, 200, 30, 255)).all()
    assert (made.faces[5] == (0, 0, 0, 255)).all()
    dim = stage("map a\nrgbGen wave square 0.5 0 0 1", plain(255, 255, 255, 255))
    blue = stage("map a\nrgbGen const ( 0.2 0.4 1 )", plain(255, 255, 255, 255))
    for layer, shown in ((dim, (128, 128, 128)), (blue, (51, 102, 255))):
        assert (Clouds(None, (layer,), 512).sky("sky").faces[0, 0, 0, :3] == shown).all()


def test_clouds_that_move_light_the_scene_as_if_they_were_finer() -> None:
    waves = 127 + 120 * np.sin(np.arange(64) * np.pi / 16)
    soft = np.stack(np.broadcast_arrays(waves, waves[:, np.newaxis], 90, 255), axis=2)
    still, moving = (
        Clouds(None, (stage(f"map a\n{mods}", Image(soft.astype(np.uint8), False, "soft")),), 512)
        for mods in ("tcMod turb 0 1 0 1\ntcMod scale 2 2", "tcMod scale 2 2\ntcMod scroll 0.1 0.1")
    )
    assert moving.moves and not still.moves
    coarse, fine = (each.sky("sky") for each in (moving, still))
    assert coarse.faces.shape == (6, LIGHT_SIZE, LIGHT_SIZE, 4)
    assert_allclose(coarse.towards_axes(), fine.towards_axes(), rtol=0.01)
    assert np.ptp(fine.faces[:5, ..., :2]) > 200


def test_images_repeat_by_their_scale() -> None:
    """Stripes of half an image: as many edges around the horizon as the scale says."""
    stripes = np.zeros((64, 64, 4), np.uint8)
    stripes[:, 32:], stripes[..., 3] = 255, 255
    for scale in (4, 9):
        layer = stage(f"map a\ntcMod scale {scale} 1", Image(stripes, False, "stripes"))
        face = Clouds(None, (layer,), 512).sky("sky").faces[4, ..., 0] > 127
        s = clouds.coordinates(clouds.directions(4, SIZE), 512)[..., 0] * scale
        inside = np.abs(s % 0.5 - 0.25) < 0.23  # not at an edge
        assert inside.mean() > 0.8
        assert_array_equal(face[inside], (s % 1 >= 0.5)[inside])


@pytest.fixture
def archive(tmp_path: Path) -> Archive:
    def save(name: str, pixels: NDArray[np.uint8]) -> None:
        (tmp_path / "env").mkdir(exist_ok=True)
        PillowImage.fromarray(pixels).save(tmp_path / "env" / name)

    save("cloud.png", np.full((4, 4, 3), (50, 60, 70), np.uint8))
    for ending in ("rt", "lf", "bk", "ft", "up", "dn"):
        save(f"far_{ending}.png", np.full((4, 4, 3), (1, 2, 3), np.uint8))
    return Archive.open([tmp_path])


@pytest.mark.parametrize(
    ("text", "colour", "problems"),
    [
        ("skyParms - 512 -\n{\nmap env/cloud.png\n}", (50, 60, 70), []),
        ("skyParms full 200 -\n{\nmap env/cloud.png\n}", (50, 60, 70), []),
        ("skyParms env/far - -", (1, 2, 3), []),
        ("skyParms env/far 512 -\n{\nmap env/cloud.png\n}", (50, 60, 70), []),
        ("skyParms env/none - -\n{\nmap env/cloud.png\n}", (50, 60, 70), ["env/none_rt"]),
        ("skyParms env/far - -\n{\nmap env/lost.png\n}", (1, 2, 3), ["env/lost.png"]),
        ("skyParms env/far - -\n{\nmap $lightmap\n}", (1, 2, 3), []),
        (
            "skyParms full 512 -\n{\nmap $whiteimage\nrgbGen const ( .2 .4 1 )\n}",
            (51, 102, 255),
            [],
        ),
        (
            "skyParms env/far - -\n{\nmap *white\nblendFunc filter\nrgbGen const ( 1 .5 0 )\n}",
            (1, 1, 0),
            [],
        ),
    ],
)
def test_a_skys_script(
    archive: Archive, text: str, colour: tuple[int, ...], problems: list[str]
) -> None:
    with archive:
        found, _, wrong = sky_files.of_scripts(archive, [script(text)])
    assert (found.faces[0, ..., :3] == colour).all()
    assert [problem.source for problem in wrong] == problems


def test_the_sky_of_the_package_where_no_script_has_one(archive: Archive) -> None:
    with archive:
        scripts = [script(""), script("skyParms - 512 -"), script("skyParms env/none 512 -")]
        found, _, wrong = sky_files.of_scripts(archive, scripts)
        assert found.name == BUILTIN_SKY and len(wrong) == 1
        later = script("skyParms - 512 -\n{\nmap env/cloud.png\n}")
        assert sky_files.of_scripts(archive, [*scripts, later])[0].name == "sky"
