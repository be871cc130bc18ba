"""Light between walls: what physics says of rooms, and that none gets through their walls."""

import math
from dataclasses import replace
from pathlib import Path

import msgspec
import numpy as np
import pytest

from followspot.assets.surface_flags import Surface
from followspot.errors import UsageError
from followspot.levelbuilder import Brush, Level, Material, box, material_files, room, write_pk3
from followspot.levelbuilder.compiler import compile_level
from followspot.scene import bounce
from followspot.scene.baked import LightGrid
from followspot.scene.light import Light, PointLight, SpotLight
from followspot.scene.load import load
from followspot.scene.luxels import SurfelLight
from followspot.scene.scene import Scene
from followspot.scene.surfels import NOTHING, SKY, Surfels
from followspot.scene.triangle_tree import TriangleTree
from synthetic import floor, make_scene

HALF = 256.0
ALBEDO = 0.5
STONE = Material("textures/stone", (64, 64), 1.0, image=np.full((8, 8, 3), 255, np.uint8))
CLOUDS = Material("textures/sky", surface=Surface.SKY | Surface.NOLIGHTMAP)


def built(folder: Path, *parts: Brush, sky: bool = False, lights: tuple[Light, ...] = ()) -> Scene:
    """A cube of a room, of one reflectance, with parts in it; its ceiling is dark sky or none."""
    level = Level()
    size = (-HALF, -HALF, 0), (HALF, HALF, 2 * HALF)
    level.add(room(*size, STONE, faces={"+z": CLOUDS} if sky else {}), parts)
    level.spawn(-200, -200, 0)
    files = material_files("box", [STONE, CLOUDS]) | {"maps/box.bsp": compile_level(level)}
    write_pk3(folder / "box.pk3", files)
    scene = load(str(folder / "box.pk3"))
    settings = msgspec.structs.replace(scene.settings, albedo=ALBEDO)
    dark = replace(scene, lights=lights, ambient=0.0, environment_constant=0.0)
    return replace(dark, lights_chosen=False, settings=settings)


def test_a_room_absorbs_what_its_lamp_gives(tmp_path: Path) -> None:
    """All light ends in the walls: those throw rho of it back, then rho of that, and so on."""
    power, unit = np.array([300.0, 200.0, 100.0]), 0.025
    lamp = PointLight(np.array([0.0, 0.0, HALF]), power)
    scene = built(tmp_path, lights=(lamp,))
    with scene.archive:
        scene = replace(scene, metres_per_unit=unit)
        surfels = bounce._surfels(scene.level)
        area = 6 * (2 * HALF * unit) ** 2
        assert surfels.areas.sum() * unit**2 == pytest.approx(area, rel=1e-5)
        shares = surfels.areas[:, np.newaxis] / surfels.areas.sum()
        direct = bounce._arriving(lamp, surfels, unit)
        np.testing.assert_allclose((direct * shares).sum(axis=0), power / area / math.pi, rtol=0.01)
        thrown = sum(ALBEDO**k for k in range(1, bounce.BOUNCES + 1))
        expected = power / area / math.pi * thrown
        light = bounce.trace(scene)
        np.testing.assert_allclose((light.light * shares).sum(axis=0), expected, rtol=0.02)
        # Evenly, nearly, and in the lamp's colour.
        assert (0.5 * expected < light.light).all() and (light.light < 1.25 * expected).all()
        in_the_open = light.grid.around(np.array([[100.0, -100.0, 200.0]]))
        lit = (direct + light.light) * ALBEDO
        np.testing.assert_allclose(in_the_open[0], (lit * shares).sum(axis=0), rtol=0.15)


MIDDLE = np.array([[0.0, 0.0, 0.0]]), np.array([[0.0, 0.0, 1.0]])


def test_a_floor_sees_as_much_sky_as_its_ceiling_takes(tmp_path: Path) -> None:
    """The middle of a cube's floor: four rectangles of a by a at a height of 2 a, each of which it
    sees by 1 / pi a / b atan(a / b) with b^2 = a^2 + (2 a)^2 (Howell's catalogue, B-4).
    """
    scene = built(tmp_path, sky=True)
    with scene.archive:
        white = replace(scene.sky, faces=np.full_like(scene.sky.faces, 255))
        scene = replace(scene, sky=white, environment_constant=2.0)
        factor = 4 / math.pi / math.sqrt(5) * math.atan(1 / math.sqrt(5))
        black = bounce.trace(of_albedo(scene, 0.0)).at(*MIDDLE)
        np.testing.assert_allclose(black, np.full((1, 3), 2.0 * factor), rtol=0.08)
        bright = bounce.trace(of_albedo(scene, 0.9)).at(*MIDDLE)
        assert (1.5 * black < bright).all() and (bright < 2.0).all()


def of_albedo(scene: Scene, albedo: float) -> Scene:
    return replace(scene, settings=msgspec.structs.replace(scene.settings, albedo=albedo))


def test_no_light_gets_through_a_wall(tmp_path: Path) -> None:
    """Of more than a cell; of half a cell hardly any, and some over one that leaves a gap."""
    lamp = PointLight(np.array([-128.0, 0.0, 100.0]), np.full(3, 1000.0))
    behind = np.array([[x, y, 0.0] for x in (40.0, 128.0, 240.0) for y in (-200.0, 0.0, 200.0)])
    up = np.tile([[0.0, 0.0, 1.0]], (len(behind), 1))
    for half, height, most in ((10, 2 * HALF, 0.0), (4, 2 * HALF, 0.02), (10, 1.5 * HALF, 0.5)):
        wall = box((-half, -HALF, 0), (half, HALF, height), STONE, detail=True)
        scene = built(tmp_path, wall, lights=(lamp,))
        with scene.archive:
            light = bounce.trace(scene)
            above = behind + 128 * up
            for lit, found in (
                (light.at(-behind, up), light.at(behind, up)),
                (light.grid.around(above * [-1, 1, 1]), light.grid.around(above)),
            ):
                assert (lit > 0).all() and (found <= most * lit.mean()).all()
                assert (found > 0.005 * lit.mean()).all() == (most == 0.5)


def test_lines_meet_what_they_meet_among_triangles() -> None:
    """To a cell's edge or two. Small things are as large as a cell; nothing is passed through."""
    courtyard = load("courtyard")
    surfels = bounce._surfels(courtyard.level)
    solid = np.array([m.casts and m.alpha_test is None for m in courtyard.materials])
    tree = TriangleTree(courtyard.mesh, solid[courtyard.mesh.material_of_triangle])
    rng = np.random.default_rng(3)
    start = rng.uniform((-300, -250, 40), (300, 200, 200), (3000, 3))
    way = rng.standard_normal((3000, 3))
    way *= 4096 / np.linalg.norm(way, axis=1, keepdims=True)
    fraction = tree.first_hits(start, start + way)
    met = surfels.met(start, way)
    hits = (met >= 0) & (fraction < 1)
    assert ((met >= 0) == (fraction < 1)).mean() > 0.97
    beyond = np.einsum("ij,ij->i", surfels.places[met] - start, way) / 4096 - fraction * 4096
    assert abs(np.median(beyond[hits])) < surfels.edge / 2
    assert (beyond[hits] < 2 * surfels.edge).mean() > 0.995
    assert (beyond[hits] > -2 * surfels.edge).mean() > 0.85
    courtyard.archive.close()
    # What ends before it is met, is not.
    near = surfels.met(start, way * fraction[:, np.newaxis] * 0.5, ends=True)
    assert (near < 0).mean() > 0.9


def test_a_surfel_is_met_from_its_front_and_lines_end() -> None:
    square = np.array([[[0, 0, 0], [0, 64, 0], [64, 0, 0]], [[64, 64, 0], [64, 0, 0], [0, 64, 0]]])
    above = square + np.array([0.0, 0.0, 200.0])
    surfels = Surfels.of(square.astype(float), np.zeros(2, np.int64), above)
    start = np.array([[20.0, 30.0, 50.0]] * 3 + [[20.0, 30.0, -50.0]])
    way = np.array([[0, 0, -100], [0, 0, -40], [0, 0, 300], [0, 0, 100]], float)
    np.testing.assert_allclose(surfels.normals, np.tile([0.0, 0.0, 1.0], (len(surfels.places), 1)))
    down, short, up, from_behind = surfels.met(start, way, ends=True)
    assert np.abs(surfels.places[down] - (24, 24, 0)).max() <= surfels.edge
    assert (short, up, from_behind) == (NOTHING, SKY, NOTHING)


def test_of_nothing_and_of_one_surfel() -> None:
    """A level may have no solid surface, or hardly any."""
    nothing = np.zeros((0, 3, 3))
    one = np.array([[[1.0, 1, 0], [1, 2, 0], [2, 1, 0]]])
    for triangles in (nothing, one):
        surfels = Surfels.of(triangles, np.zeros(len(triangles), np.int64), nothing)
        assert len(surfels.places) == len(triangles)
        assert (surfels.met(np.full((2, 3), 50.0), np.ones((2, 3))) == NOTHING).all()
        assert all((neighbour == NOTHING).all() for neighbour in surfels.beside())
        grid = LightGrid(
            np.zeros(3), np.ones(3), np.ones(3, np.int64), np.full((1, 3), 5, np.float32)
        )
        light = SurfelLight(surfels, np.full((len(triangles), 3), 2.0), grid)
        found = light.at(np.array([[1.3, 1.3, 0], [500, 500, 500]]), np.tile([0.0, 0, 1], (2, 1)))
        expected = 2.0 if len(triangles) else 5.0  # else what there is in the open
        np.testing.assert_allclose(found, [[expected] * 3, [5.0] * 3])


def test_neighbours_are_of_one_surface_and_see_each_other(tmp_path: Path) -> None:
    wall = box((-10, -HALF, 0), (10, HALF, HALF), STONE, detail=True)
    scene = built(tmp_path, wall)
    with scene.archive:
        surfels = bounce._surfels(scene.level)
        side = np.sign(surfels.places[:, 0]) * (surfels.places[:, 2] < HALF - surfels.edge)
        count = np.zeros(len(side))
        for neighbour in surfels.beside():
            has = neighbour >= 0
            to = neighbour[has]
            np.testing.assert_allclose(surfels.normals[to], surfels.normals[has], atol=1e-6)
            away = np.abs(surfels.places[to] - surfels.places[has]).max(axis=1)
            assert (away <= 2 * surfels.edge).all()
            assert (side[to] * side[has] >= 0).all()  # none beyond the wall
            count += has
        # In the middle of a wall all eight.
        floor = (surfels.normals[:, 2] > 0.9) & (surfels.places[:, 2] < 1)
        within = (np.abs(surfels.places[:, :2]) < 200).all(axis=1) & (surfels.places[:, 0] > 64)
        assert (count[floor & within] == 8).all() and (floor & within).sum() > 50


def test_light_is_shown_in_place_of_the_skys(tmp_path: Path) -> None:
    """In luxels, at vertices without, and in the open, by one unit; and it can be traced anew."""
    lamp = SpotLight(np.array([0.0, 0.0, 400.0]), np.array([0.0, 0, -1]), 0.6, np.full(3, 500.0))
    scene = built(tmp_path, lights=(lamp,))
    with scene.archive:
        light, baked = bounce.trace(scene), bounce.bake(scene)
        level = baked.level
        assert level.traced is not None and level.baked is not None and level.mesh.baked is not None
        unit = level.traced.unit
        image = level.traced.image()
        assert image.shape == level.baked.image().shape
        x, y = np.rint(level.baked.white * image.shape[1::-1]).astype(int)
        assert (image[y - 1 : y + 1, x - 1 : x + 1] == 1).all()  # all that are mixed there
        vertices = level.mesh.vertices
        place = (level.mesh.baked[:, :2] * image.shape[1::-1]).astype(int)
        shown = image[place[:, 1], place[:, 0]] * level.mesh.baked[:, 2:] * unit
        expected = light.at(vertices["position"].astype(float), vertices["normal"].astype(float))
        assert np.median(np.abs(shown - expected) / expected) < 0.05
        points = np.array([[0.0, 0.0, 100.0]])
        np.testing.assert_allclose(
            level.traced.around(points) * unit, light.grid.around(points), rtol=1e-5
        )
        again = bounce.bake(baked)
        assert again.level.traced is not None and again.level.traced.unit == unit
        np.testing.assert_array_equal(again.level.mesh.baked, level.mesh.baked)


def test_what_cannot_be_baked_is_told(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="--bake: expected a level, found"):
        bounce.bake(make_scene([floor()]))
    scene = built(tmp_path)
    with scene.archive:
        settings = msgspec.structs.replace(scene.settings, baked_light=1.0)
        with pytest.raises(UsageError, match="--bake: expected no setting baked_light beside it"):
            bounce.bake(replace(scene, settings=settings))
        dark = bounce.bake(scene)  # nothing lights it
        assert dark.level.traced is not None and (bounce.trace(scene).light == 0).all()
