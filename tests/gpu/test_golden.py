"""A few whole pictures, for what numbers do not say: that things look right together.

Physics and geometry have tests of their own; each picture here is named for what it protects.
``pytest --update-golden`` writes them anew: look at them before they are kept.
"""

from pathlib import Path

import msgspec
import numpy as np
import pytest
from numpy.typing import NDArray
from test_pixel_geometry import quake_sky

import golden
from followspot.assets.shader_values import AlphaTest, BlendFactor, Sides
from followspot.passes.view import View
from followspot.present.renderer import Renderer
from followspot.scene.load import load, load_figure
from followspot.scene.material import Material, Shade
from followspot.scene.scene import Scene
from followspot.scene.settings import Settings
from synthetic import (
    box,
    camera,
    floor,
    image_archive,
    make_scene,
    of,
    point,
    quad,
    rotation,
    sphere,
    spot,
    turned,
)

pytestmark = pytest.mark.gl

Array = golden.Picture
VIEW = camera((-230, -60, 120), yaw=14, pitch=20, fov=75)


def dusk(towards: NDArray[np.float64]) -> NDArray[np.float64]:
    """A sky that is blue above, warm towards +X, and dark below."""
    up, ahead = towards[..., 2:], towards[..., :1]
    blue, warm = np.array([0.15, 0.3, 0.7]), np.array([0.9, 0.5, 0.2])
    sky = blue * (0.4 + 0.6 * up.clip(0)) + warm * (ahead.clip(0) ** 4) * (1 - np.abs(up))
    return np.asarray(np.where(up < 0, 0.05 + 0 * sky, sky))


def textures() -> dict[str, Array]:
    row, column = np.mgrid[:64, :64]
    checks = np.where(
        ((row // 16 + column // 16) % 2)[..., np.newaxis], (190, 170, 140), (120, 60, 50)
    )
    leaf = np.full((64, 64, 4), (70, 120, 40, 255))
    leaf[..., 3] = np.where((row // 8 + column // 8) % 3 == 0, 0, 255)
    glow = np.zeros((64, 64, 3))
    glow[...] = np.exp(-((row - 32) ** 2 + (column - 32) ** 2) / 200)[..., np.newaxis] * (
        255,
        120,
        30,
    )
    pane = np.full((4, 4, 4), (90, 150, 200, 110))
    images = {"checks.png": checks, "leaf.png": leaf, "glow.png": glow, "pane.png": pane}
    return {name: pixels.astype(np.uint8) for name, pixels in images.items()}


@pytest.fixture
def still_life(tmp_path: Path) -> Scene:
    """Boxes, a ball, a grate, glass and a flame on a checked floor under two lights at dusk."""
    checks = Material("checks", "checks.png")
    leaf = Material("leaf", "leaf.png", sides=Sides.BOTH, alpha_test=AlphaTest.GE128)
    glass = Material(
        "glass", "pane.png", blend=(BlendFactor.SRC_ALPHA, BlendFactor.ONE_MINUS_SRC_ALPHA)
    )
    flame = Material(
        "flame", "glow.png", blend=(BlendFactor.ONE, BlendFactor.ONE), shade=Shade.EMISSIVE
    )
    ground = floor(400)
    ground.vertices["texcoord"] *= 12
    pieces = [
        *of(checks, ground),
        *turned(box((-30, -30, 0), (30, 30, 60)), rotation((0, 0, 1), 30), (20, 80, 0)),
        *of(checks, *box((60, -120, 0), (110, -60, 110))),
        sphere((0, -20, 35), 35, rings=32),
        *of(leaf, quad((-80, 60, 40), (0, -40, 0), (0, 0, 40))),
        *of(glass, quad((-60, -80, 45), (0, -35, 0), (0, 0, 45))),
        *of(flame, quad((-60, 10, 30), (0, -25, 0), (0, 0, 30))),
    ]
    return make_scene(
        pieces,
        spot((-160, 160, 330), (10, -10, 0), 35, (320, 280, 220), 0.3),
        point((-60, 10, 40), (12, 6, 2)),
        sky=quake_sky(dusk, 64),
        archive=image_archive(tmp_path, textures()),
        environment_constant=0.6,
    )


PICTURES = {
    "everything-together": (View.FINAL, Settings(exposure=0.9)),
    "light-without-texture": (View.SHADING, Settings(exposure=0.7)),
    "no-shadows-no-sky-light": (
        View.FINAL,
        Settings(exposure=0.9, shadows=False, sky_light=False),
    ),
    "normals-of-curved-and-flat": (View.NORMALS, Settings(exposure=1.0)),
    "shadow-of-cut-outs": (View.SHADOW, Settings(exposure=1.0)),
    "textures-with-blended-surfaces": (View.LAMBERTIAN, Settings(exposure=1.0)),
}


@pytest.mark.parametrize("name", PICTURES)
def test_golden(
    renderer: Renderer, still_life: Scene, name: str, request: pytest.FixtureRequest
) -> None:
    view, settings = PICTURES[name]
    picture = renderer.render(still_life, VIEW, [view], settings=settings)[view]
    golden.check(name, picture, update=request.config.getoption("--update-golden"))


COURTYARD = {
    "courtyard-sun-through-leaves": ("title", View.FINAL),
    "courtyard-vaults-in-shadow": ("arcade", View.SHADING),
    "courtyard-water-before-the-gate": ("gate", View.FINAL),
}


@pytest.mark.parametrize("name", COURTYARD)
def test_golden_courtyard(renderer: Renderer, name: str, request: pytest.FixtureRequest) -> None:
    scene = load("courtyard")
    camera_name, view = COURTYARD[name]
    settings = msgspec.structs.replace(scene.settings, exposure=0.8)
    with scene.archive:
        picture = renderer.render(scene, camera_name, [view], settings=settings)[view]
    golden.check(name, picture, update=request.config.getoption("--update-golden"))


def test_golden_robot(renderer: Renderer, request: pytest.FixtureRequest) -> None:
    """A character in the middle of a step, on the stage."""
    scene = load_figure("models/robot/robot.md2", animation="run")
    settings = msgspec.structs.replace(scene.settings, exposure=0.22)
    with scene.archive:
        picture = renderer.render(scene, settings=settings, time=0.27)["final"]
    golden.check("robot-running", picture, update=request.config.getoption("--update-golden"))


def test_a_difference_is_noticed_and_shown(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(golden, "GOLDEN", tmp_path / "golden")
    monkeypatch.setattr(golden, "FAILURES", tmp_path / "failures")
    picture = np.full((12, 16, 3), 100, np.uint8)
    with pytest.raises(AssertionError, match="--update-golden"):
        golden.check("grey", picture, update=False)
    golden.check("grey", picture, update=True)
    golden.check("grey", picture + np.uint8(golden.MAX_DIFFERENCE), update=False)
    with pytest.raises(AssertionError, match="grey differs"):
        golden.check("grey", picture + np.uint8(20), update=False)
    left = sorted(path.name for path in (tmp_path / "failures").iterdir())
    assert left == ["grey-difference-x4.png", "grey.png", "grey.txt"]
    assert "above  16: 100" in (tmp_path / "failures" / "grey.txt").read_text()
