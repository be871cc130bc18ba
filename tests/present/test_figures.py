"""The classic sequence: its files, and that each shows what it says."""

import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from followspot import cli
from followspot.present.figures import SEQUENCE


@pytest.mark.gl
def test_the_files_of_the_sequence(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "out"
    typed = ["figures", "courtyard", "--size", "80x60", "-o", str(folder)]
    monkeypatch.setattr(sys, "argv", ["followspot", *typed])
    monkeypatch.setenv("COLUMNS", "300")
    with pytest.raises(SystemExit) as done:
        cli.main()
    assert done.value.code == 0
    drawn = {path.name: np.asarray(Image.open(path)) for path in folder.iterdir()}
    names = [f"{figure.name}.png" for figure in SEQUENCE]
    assert sorted(drawn) == sorted([*names, "contact-sheet.png"])
    shapes = {name: drawn[name].shape for name in names}
    side = shapes.pop("7-shadow-map.png")
    assert side[0] == side[1] and side[2] == 3
    assert set(shapes.values()) == {(60, 80, 3)}
    assert all(drawn[name].std() > 5 for name in names)
    pictures = [drawn[name].tobytes() for name in names]
    assert len(set(pictures)) == len(names), "each shows something else"
    assert drawn["contact-sheet.png"].shape == (2 * (300 + 30 + 12) + 12, 4 * (400 + 12) + 12, 3)
    printed = capsys.readouterr().out
    assert all(str(folder / name) in printed for name in drawn)
