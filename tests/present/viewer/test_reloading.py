"""Shaders that change while the viewer runs."""

from pathlib import Path

import pytest
from driver import display, play


@pytest.mark.gl
def test_a_broken_shader_is_told_and_the_last_good_one_stays(tmp_path: Path) -> None:
    with display() as screen:
        play("reloading", screen, tmp_path)
