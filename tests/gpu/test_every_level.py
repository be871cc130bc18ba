"""All of OpenArena's levels: each loads, draws a frame that is not black, and culls rightly."""

from dataclasses import replace

import numpy as np
import pytest
from gl_calls import DebugLog, live_objects

from conftest import Draw
from followspot.assets.archive import Archive
from followspot.assets.locate import list_levels, search_path
from followspot.passes.view import View
from followspot.present.renderer import Renderer
from followspot.scene import bsp_tree
from followspot.scene.character import Character, Crowd
from followspot.scene.load import load, load_figure
from followspot.scene.walk import standing
from followspot.spaces import vec3
from synthetic import camera, floor, looking, make_scene, rays

pytestmark = [pytest.mark.gl, pytest.mark.openarena]

DARK = 24
"""A display value (of 255) that can hardly be told from black."""


def installed_levels() -> list[str]:
    with Archive.open(search_path()) as archive:
        return list_levels(archive)


def test_openarena_is_installed() -> None:
    assert len(installed_levels()) >= 80


@pytest.mark.parametrize("name", installed_levels())
def test_level_loads_and_draws(renderer: Renderer, name: str) -> None:
    """Without scene file or light: no error, no GL message, and something to see."""
    for linear in (False, True):  # makes the targets, which outlive scenes
        renderer.render(make_scene([floor()]), camera((0, 0, 20)), linear=linear)
    renderer._drop_scene()
    before = live_objects()
    with DebugLog() as log:
        scene = load(name)
        with scene.archive:
            picture = renderer.render(scene)[View.FINAL]
            depth = renderer.render(scene, views=[View.DEPTH], linear=True)[View.DEPTH]
            gpu_scene = renderer.open(scene)
        assert gpu_scene.context.error == "GL_NO_ERROR"
        assert log.messages() == []
    assert gpu_scene.problems == []
    surface, visible = np.isfinite(depth), picture.max(axis=2) > DARK
    assert surface.mean() > 0.05 and visible.mean() > 0.05
    assert visible[surface].mean() > 0.6, "of what is not sky, too much is dark"
    assert 30 < picture[surface].mean() < 180
    assert (picture[surface] == 255).all(axis=1).mean() < 0.05
    renderer._drop_scene()
    after = live_objects()
    # A program that is still current goes only when another one is.
    assert all(after[kind] <= before[kind] for kind in before), (before, after)


LEVELS = ["oa_dm1", "oa_dm5", "am_thornish", "ctf_inyard", "oa_rpg3dm2", "delta", "islandctf"]


@pytest.mark.parametrize("name", LEVELS)
def test_culling_hides_nothing_that_can_be_seen(draw: Draw, name: str) -> None:
    """From spawn points: what the level's own visibility hides lies behind solid walls.

    Without culling such things show, for walls of sky are solid but not drawn. Where surfaces
    coincide, the order in which they are drawn decides, and that may differ a little.
    """
    scene = load(name)
    spawns = [view for key, view in scene.cameras.items() if key.startswith("spawn")]
    with scene.archive:
        for spawn in spawns[:: max(1, len(spawns) // 5)]:
            for turn in (0, 120, 240):
                view = replace(spawn, yaw=spawn.yaw + turn)
                every = draw(scene, view, View.DEPTH, culling=False)
                left = draw(scene, view, View.DEPTH)
                hidden = left > every * 1.001
                assert not (left < every * 0.999).any(), view
                there = view.position + rays(view)[hidden] * every[hidden][:, np.newaxis]
                here = np.broadcast_to(view.position, there.shape)
                free = bsp_tree.trace(scene.level.bsp, here, there) > 0.99
                assert free.sum() <= 1, f"{free.sum()} pixels are gone from {view}"


@pytest.mark.parametrize(
    ("name", "place", "eye"),
    [
        ("oa_dm5", (720.2, -702.39, 127.0), (710.15, -712.48, 239.67)),
        ("oa_dm4", (738.43, -528.5, -145.0), (730.8, -909.3, -124.62)),
        ("oa_dm4", (761.12, -523.45, -145.0), (730.8, -909.3, -124.62)),
    ],
)
def test_a_limb_in_another_room_shows_its_character(
    draw: Draw, name: str, place: tuple[float, ...], eye: tuple[float, ...]
) -> None:
    """Where the eye sees but a sliver of the space that characters reach into."""
    scene, players = load(name), load_figure("player:angelyss")
    figure = players.crowd.characters[0].figure
    with scene.archive, players.archive:
        with_one = replace(scene, crowd=Crowd([Character(figure, standing(vec3(place), 0.0))]))
        view = looking(eye, (*place[:2], place[2] + 25))
        without = draw(scene, view, View.DEPTH, culling=False)
        every = draw(with_one, view, View.DEPTH, culling=False)
        is_there = every < without
        assert is_there.any()
        np.testing.assert_array_equal(draw(with_one, view, View.DEPTH)[is_there], every[is_there])


def test_culling_changes_no_picture(draw: Draw) -> None:
    """Also light, shadows, and blended surfaces are the same with and without."""
    scene = load("oa_dm1")
    with scene.archive:
        for spawn in list(scene.cameras.values())[:3]:
            every = draw(scene, spawn, View.FINAL, culling=False)
            np.testing.assert_array_equal(draw(scene, spawn, View.FINAL), every)


def test_camera_outside_of_the_level_sees_all_of_it(draw: Draw) -> None:
    scene = load("oa_dm1")
    with scene.archive:
        low, high = (np.asarray(b, np.float64) for b in scene.mesh.bounds)
        outside = replace(
            scene.camera(), position=vec3(high + (high - low) * 0.3), yaw=225, pitch=35
        )
        every = draw(scene, outside, View.DEPTH, culling=False)
        np.testing.assert_array_equal(draw(scene, outside, View.DEPTH), every)
        assert np.isfinite(every).mean() > 0.05
