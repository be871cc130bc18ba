"""Pick-ups in pictures: real models where the level has them, turning."""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from conftest import Draw
from followspot import cli
from followspot.assets.archive import Archive
from followspot.passes.view import View
from followspot.scene import bsp_tree
from followspot.scene.character import Crowd
from followspot.scene.figure_file import FigureFiles
from followspot.scene.ground import Ground
from followspot.scene.items import items
from followspot.scene.load import load
from model_fixtures import small_md3, write_md3
from synthetic import floor, looking, make_scene, open_bsp

pytestmark = pytest.mark.gl

TURN = 2.048
"""Seconds in which armour and weapons turn once."""


def test_a_model_is_drawn_where_its_item_is_and_turns(draw: Draw, tmp_path: Path) -> None:
    model = small_md3()
    # An upright triangle from its axis outwards, seen from either side.
    corners = np.array([(0, 0, 0), (0, 0, 20), (20, 0, 10)]) * 64
    for surface, order in zip(model["surfaces"], (1, -1), strict=True):
        surface["vertices"]["position"] = corners[::order]
    path = tmp_path / "models/powerups/armor/armor_red.md3"
    path.parent.mkdir(parents=True)
    path.write_bytes(write_md3(model))
    entity = {"classname": "item_armor_body", "origin": "0 0 40"}
    scene = make_scene([floor(400)])
    with Archive.open([tmp_path]) as archive:
        files = FigureFiles(archive, lambda _: None)
        bsp = replace(open_bsp(), entities=(entity,))
        shown = items(bsp, files, Ground(scene.level))
    with_item = replace(scene, crowd=Crowd(shown))
    view = looking((-120, 0, 30), (0, 0, 25), 40)
    empty = draw(scene, view, View.DEPTH)

    def places(time: float) -> NDArray[np.float64]:
        """(n, 2) pixels that show it; the columns from the middle, to the right."""
        rows, columns = np.nonzero(draw(with_item, view, View.DEPTH, time=time) < empty - 0.5)
        return np.stack([rows, columns - empty.shape[1] / 2], axis=1)

    for quarter, side in ((1, -1), (3, 1)):  # to the left of who looks along +x, then right
        pixels = places(quarter * TURN / 4 - 1)  # the clock of items is a second ahead
        assert len(pixels) > 50
        assert side * pixels[:, 1].mean() > 3 and (side * pixels[:, 1] > -2).all()
    edge_on = places(TURN - 1)
    assert len(edge_on) < len(pixels) / 4


@pytest.mark.openarena
def test_openarenas_rocket_launcher(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """`--items` draws it where the level has it; without that, there is nothing."""
    scene = load("oa_dm5", with_items=True)
    with scene.archive:
        launcher = next(c for c in scene.crowd.characters if "rocketl" in c.figure.name)
    place = launcher.walk.places[0, :3]
    ways = np.radians(np.arange(0, 360, 15))
    away = np.stack([60 * np.cos(ways), 60 * np.sin(ways), np.full(len(ways), 15.0)], axis=1)
    free = bsp_tree.trace(scene.level.bsp, np.tile(place, (len(away), 1)), place + 1.3 * away) == 1
    eye = looking(place + away[free.argmax()], place)

    def depth(time: float, *flags: str) -> NDArray[np.float32]:
        camera = ",".join(f"{n:.3f}" for n in (*eye.position, eye.yaw, eye.pitch))
        output = tmp_path / "depth.npy"
        typed = ["oa_dm5", f"--camera={camera}", "--view", "depth", "--size", "96x72"]
        typed += ["--time", f"{time}", "-o", str(output), *flags]
        monkeypatch.setattr(sys, "argv", ["followspot", "render", *typed])
        with pytest.raises(SystemExit) as done:
            cli.main()
        assert not done.value.code
        return np.asarray(np.load(output))

    empty, first, turned = depth(0), depth(0, "--items"), depth(TURN / 4, "--items")
    np.testing.assert_array_equal(empty, depth(TURN / 4))
    masks = [seen < empty - 1 for seen in (first, turned)]
    for mask, seen in zip(masks, (first, turned), strict=True):
        assert mask[30:42, 42:54].any() and 0.01 < mask.mean() < 0.6
        assert abs(np.median(seen[mask]) - 60) < 25
    assert (masks[0] != masks[1]).mean() > 0.01
