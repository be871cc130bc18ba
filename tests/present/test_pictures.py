"""Pictures of odd sizes, and files that cannot be written."""

from pathlib import Path
from unittest.mock import MagicMock

import moderngl
import numpy as np
import pytest

from followspot.errors import UsageError
from followspot.gpu.targets import Target
from followspot.passes.view import View
from followspot.present import pictures, tell
from followspot.present.figures import contact_sheet
from followspot.present.renderer import Renderer
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
