"""Pictures of odd sizes, and files that cannot be written."""

from pathlib import Path
from typing import Any
from unittest.mock import MagicMock

import moderngl
import numpy as np
import pytest
from PIL import Image

from followspot.errors import UsageError
from followspot.gpu.targets import Target
from followspot.passes.view import View
from followspot.present import pictures, still, tell
from followspot.present.figures import contact_sheet
from followspot.present.renderer import Renderer
from followspot.present.still import Wish
from followspot.scene.load import load


@pytest.mark.parametrize("size", [(1, 16384), (16384, 1), (1000, 1), (1, 1), (640, 480)])
def test_a_contact_sheet_of_any_size(size: tuple[int, int]) -> None:
    drawn = [np.full((*size[::-1], 3), 200, np.uint8)] * 3
    sheet = contact_sheet(drawn, ["one", "two", "three"], columns=2, width=100)
    assert sheet.shape[1] == 2 * 112 + 12 and sheet.shape[0] < 2 * 300


@pytest.mark.parametrize("is_linear", [False, True])
def test_a_size_that_gl_refuses(is_linear: bool) -> None:
    context = MagicMock()
    context.framebuffer.side_effect = moderngl.Error("the framebuffer is not complete")
    with pytest.raises(UsageError, match="a size of 16384x8192 cannot be drawn here"):
        Target(context, (16384, 8192), is_linear=is_linear)
    context.texture.return_value.release.assert_called_once()


def test_a_disk_that_is_full(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def write(*_: object) -> None:
        raise RuntimeError("Failed to write pixel data")

    monkeypatch.setattr("OpenEXR.File.write", write)
    with pytest.raises(UsageError, match=r"q\.exr: cannot be written: Failed to write"):
        pictures.save(tmp_path / "q.exr", np.zeros((2, 2, 3), np.float32))
    assert list(tmp_path.iterdir()) == []


@pytest.mark.gl
def test_one_view_alone_and_closing_twice() -> None:
    renderer = Renderer((16, 12))
    scene = load(Path("courtyard"))
    with scene.archive:
        drawn = renderer.render(scene, views="normals")
        assert drawn.keys() == {View.NORMALS} and drawn["normals"].shape == (12, 16, 3)
        renderer.close()
        renderer.close()


def test_names_in_brackets_are_told_as_they_are(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """What prints in colours must not take them for colours."""
    path = tmp_path / "[b]" / "q.toml"
    path.parent.mkdir()
    path.write_text('level = "courtyard"\n[cameras."[/x]"]\nposition = [0, 0, 0]\n')
    tell.inspect(str(path), (), as_json=False)
    out = capsys.readouterr().out.replace("\n", "")
    assert "[b]/q.toml" in out and "[/x]" in out


def test_squares_of_pixels_become_their_means() -> None:
    random = np.random.default_rng(1)
    light = random.uniform(0, 9, (6, 4, 3)).astype(np.float32)
    mean = pictures.averaged(light, 2, encoded=False)
    assert mean.shape == (3, 2, 3) and mean.dtype == np.float32
    np.testing.assert_allclose(mean[2, 1], light[4:6, 2:4].mean(axis=(0, 1)), rtol=1e-6)
    depth = np.array([[1, 3], [5, np.inf]], np.float32)
    assert pictures.averaged(depth, 2, encoded=False).tolist() == [[np.inf]]
    assert pictures.averaged(depth, 1, encoded=False).tolist() == depth.tolist()
    bars = np.zeros((2, 2, 3), np.uint8)
    bars[:, 1] = 255
    assert (pictures.averaged(bars, 2, encoded=False) == 128).all()
    assert (pictures.averaged(bars, 2, encoded=True) == 188).all()  # half of the light
    flat = np.arange(256, dtype=np.uint8).repeat(9).reshape(-1, 3, 3)[..., np.newaxis]
    same = pictures.averaged(flat.repeat(3, axis=3).reshape(-1, 3, 3), 3, encoded=True)
    assert same[:, 0, 0].tolist() == list(range(256))


@pytest.mark.gl
def test_a_picture_is_smoothed_in_light(tmp_path: Path) -> None:
    smooth = Wish(size="64x48", supersample=3)
    still.render("courtyard", tmp_path / "fine.npy", Wish(size="192x144"))
    still.render("courtyard", tmp_path / "mean.npy", smooth)
    fine, mean = (np.load(tmp_path / name) for name in ("fine.npy", "mean.npy"))
    np.testing.assert_allclose(
        mean, fine.reshape(48, 3, 64, 3, 3).mean(axis=(1, 3)), rtol=1e-5, atol=1e-7
    )
    still.render("courtyard", tmp_path / "plain.png", Wish(size="64x48"))
    still.render("courtyard", tmp_path / "smooth.png", smooth)
    plain, shown = (
        np.asarray(Image.open(tmp_path / name), np.float64) for name in ("plain.png", "smooth.png")
    )
    steps = [np.abs(np.diff(each, axis=1)).mean() for each in (plain, shown)]
    assert shown.shape == plain.shape and steps[1] < 0.9 * steps[0]


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"size": "2000x2", "supersample": 9}, "--supersample: expected at most 16384 .*2000 x 9"),
        ({"view": "shadow-map", "supersample": 2}, "--supersample: expected 1 for a shadow map"),
    ],
)
def test_what_cannot_be_smoothed(tmp_path: Path, changes: dict[str, Any], told: str) -> None:
    with pytest.raises(UsageError, match=told):
        still.render("courtyard", tmp_path / "x.png", Wish(**changes))
