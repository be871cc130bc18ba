"""What the tiles of shadow maps cover and what casts into them, kept from frame to frame."""

import msgspec
import numpy as np
import pytest

from followspot.passes import shadow_extent
from followspot.passes.shadow_fit import Receivers
from followspot.passes.shadow_tiles import ShadowTiles, Tile, map_size, tile_size
from followspot.scene.settings import CullFace, Settings
from synthetic import box, floor, make_scene, point, spot

SETTINGS = Settings()
HIGH = spot((0, 0, 500), (0, 0, 0), 40)
LOW = spot((-300, 0, 200), (0, 0, 0), 30)
SCENE = make_scene([floor(), *box((-20, -20, 10), (20, 20, 60))], HIGH, LOW)


def receivers(*halves: float) -> Receivers:
    """Of squares on the floor around the middle, one behind the other before the camera."""
    corner = np.array([(half, half, 0) for half in halves], np.float32)
    ends = [[(x * half, y * half, z) for x in (-1, 1) for y in (-1, 1) for z in (-9, 9)]
            for half in halves]  # fmt: skip
    start = np.arange(len(halves), dtype=float) * 50
    return Receivers(-corner, corner, np.array(ends, float), start, start + 50)


def parts(tiles: ShadowTiles) -> list[tuple[object, object]]:
    return [(tile.frustum, tile.casters) for tile in tiles.tiles]


def test_what_comes_out_alike_is_kept() -> None:
    tiles = ShadowTiles(SCENE)
    assert tiles.fit((HIGH, LOW), SETTINGS, receivers(100))
    before = parts(tiles)
    assert len(before) == 2 and all(tile.casters.triangle_count > 0 for tile in tiles.tiles)
    assert not tiles.fit((HIGH, LOW), SETTINGS, receivers(100)), "other boxes of the same extent"
    assert parts(tiles) == before
    assert tiles.fit((LOW, HIGH), SETTINGS, receivers(100)), "another order"
    assert parts(tiles) == before[::-1]
    assert tiles.fit((LOW, HIGH), SETTINGS, receivers(10))
    assert not set(parts(tiles)) & set(before)
    before = parts(tiles)
    back = msgspec.structs.replace(SETTINGS, shadow_cull=CullFace.BACK)
    assert tiles.fit((LOW, HIGH), back, receivers(10)), "other faces cast"
    assert not set(parts(tiles)) & set(before)


def test_a_light_that_is_there_twice_has_two_rows() -> None:
    tiles = ShadowTiles(SCENE)
    for half in (100, 101):
        tiles.fit((HIGH, HIGH), SETTINGS, receivers(half))
        assert [tile.place for tile in tiles.tiles] == [(0, 0), (0, 1)]
    places = [tiles.atlas_from_world(tile) @ (0, 0, 0, 1) for tile in tiles.tiles]
    y = [place[1] / place[3] for place in places]
    np.testing.assert_allclose(np.diff(y), 0.5)


def near_and_wide(tiles: ShadowTiles) -> tuple[Tile, Tile]:
    wide, near = tiles.tiles
    assert near.is_near and not wide.is_near and wide.finer is near.frustum and near.finer is None
    return near, wide


def test_what_is_near_the_camera_gets_a_tile_of_its_own() -> None:
    tiles = ShadowTiles(SCENE)
    assert tiles.fit((HIGH,), SETTINGS, receivers(20, 300))
    near, wide = near_and_wide(tiles)
    assert near.frustum.texel < wide.frustum.texel / 4
    assert (near.frustum.near, near.frustum.far) == (wide.frustum.near, wide.frustum.far)
    # The near squares' shadows are looked up there, so that it holds their corners with a margin.
    clip = near.frustum.clip_from_world @ np.array([(20, 20, 0, 1), (-20, -20, 0, 1)]).T
    margin = 1 - 6 / tile_size(SETTINGS)
    assert (np.abs(clip[:2]) < clip[3] * margin).all()
    assert len(near.casters.indices) and len(near.casters.indices) <= len(wide.casters.indices)

    assert tiles.fit((HIGH,), SETTINGS, receivers(20, 310))
    assert near_and_wide(tiles)[0].frustum is near.frustum, "kept while the wide one changes"
    assert tiles.fit((HIGH,), SETTINGS, receivers(300, 20)), "far away, where none is needed"
    assert len(tiles.tiles) == 1


def test_whole_cones_have_one_tile_of_all_the_texels() -> None:
    tiles, whole = ShadowTiles(SCENE), msgspec.structs.replace(SETTINGS, shadow_fit=False)
    tiles.fit((HIGH, LOW), whole, None)
    assert [tile.place for tile in tiles.tiles] == [(0, 0), (0, 1)]
    assert tile_size(whole) == 1024
    assert 2 * tile_size(SETTINGS) ** 2 == pytest.approx(1024**2, rel=1e-3)


def test_from_the_wide_tile_to_the_near_one() -> None:
    """Scale and shift against the two projections, of the atlas and of the tiles alone."""
    tiles = ShadowTiles(SCENE)
    tiles.fit((LOW, HIGH), SETTINGS, receivers(15, 250))
    points = np.random.default_rng(1).uniform((-20, -20, 0), (20, 20, 60), (50, 3))
    points = np.c_[points, np.ones(50)]
    assert len(tiles.tiles) == 4
    for light, (scale_x, scale_y, shift_x, shift_y) in enumerate(tiles.near_from_wide()):
        wide, near = (tile for tile in tiles.tiles if tile.light == light)
        a, b = (points @ tiles.atlas_from_world(tile).T for tile in (wide, near))
        np.testing.assert_allclose(a[:, 0] * scale_x + a[:, 3] * shift_x, b[:, 0], rtol=1e-9)
        np.testing.assert_allclose(a[:, 1] * scale_y + a[:, 3] * shift_y, b[:, 1], rtol=1e-9)
        np.testing.assert_allclose(a[:, 2:], b[:, 2:], err_msg="depths are compared with both")
        a, b = (points @ tile.frustum.clip_from_world.T for tile in (wide, near))
        a, b = ((at[:, :2] / at[:, 3:] + 1) / 2 for at in (a, b))
        scale, shift = wide.finer_from_here
        np.testing.assert_allclose(a * scale + shift, b, rtol=1e-9)


def test_without_a_near_tile_nothing_comes_to_lie_in_the_atlas() -> None:
    tiles = ShadowTiles(SCENE)
    tiles.fit((HIGH, LOW), SETTINGS, receivers(100))
    scale, shift = np.split(tiles.near_from_wide(), 2, axis=1)
    for corner in ((0, 0), (0, 1), (1, 0), (1, 1)):
        assert (corner * scale + shift > 1).any(axis=1).all()


def test_only_what_is_well_within_the_near_tile_is_left_to_it() -> None:
    tiles = ShadowTiles(SCENE)
    tiles.fit((HIGH,), SETTINGS, receivers(20, 300))
    near, wide = near_and_wide(tiles)
    edge = near.frustum.window[1] * 500  # units on the floor, under the light
    least = np.array([(-5, -5, 0), (edge - 4, -5, 0), (edge + 4, -5, 0), (-5, -5, 495)], np.float32)
    found = shadow_extent.extents(near.frustum, least, least + np.float32(10))
    assert shadow_extent.within(found, wide.seam).tolist() == [True, False, False, False]
    assert shadow_extent.meets(found).tolist() == [True, True, False, True]
    # A filter of four taps around a place that is just looked up in the wide one.
    in_wide_texels = wide.seam * 2 * near.frustum.window[1] / wide.frustum.texel
    assert in_wide_texels > 2.5


def test_rectangles_hold_whole_texels_of_the_tile() -> None:
    found = np.array([(-1.0, 0.26, 0.49, 2.0), (-np.inf, -np.inf, np.inf, np.inf)])
    np.testing.assert_allclose(shadow_extent.texels(found, 4), [(-1, -0.5, 0, 1), (-1, -1, 1, 1)])


@pytest.mark.parametrize("fit", [False, True])
def test_the_largest_map_for_tiles_of_a_size(fit: bool) -> None:
    """One texel more would not do."""
    for tile in range(20, 5792):
        largest = map_size(tile, Settings(shadow_fit=fit))
        sizes = [
            tile_size(Settings(shadow_fit=fit, shadow_map_size=size))
            for size in (largest, largest + 1)
        ]
        assert sizes[0] <= tile < sizes[1]


def test_every_triangle_that_a_tile_shows_casts_into_it() -> None:
    """Of boxes all around lights, against clip coordinates; those seen edge-on may be left out."""
    rng = np.random.default_rng(5)
    boxes = [piece for at in rng.uniform(-400, 400, (60, 3)) for piece in box(at - 20, at + 20)]
    around = point((10, 20, 30))
    scene = make_scene(boxes, HIGH, LOW, around)
    tiles = ShadowTiles(scene)
    both = msgspec.structs.replace(SETTINGS, shadow_cull=CullFace.NONE)
    triangles = scene.mesh.indices.reshape(-1, 3)
    corners = np.insert(scene.mesh.vertices["position"][triangles], 3, 1, axis=2)
    shown = np.zeros(len(triangles), bool)
    for seen in (receivers(15, 250), receivers(40), None):
        tiles.fit((HIGH, LOW, *around.sides), both, seen)
        for tile in tiles.tiles:
            x, y, z, w = np.moveaxis(corners @ tile.frustum.clip_from_world.T, 2, 0)
            inside = ((np.abs([x, y]) < w) & (z < w)).all(axis=(0, 2))
            outside = np.any([(at > w).all(axis=1) for at in (x, -x, y, -y)], axis=0)
            texels = np.ptp([x / w, y / w], axis=2) * tile_size(SETTINGS) / 2
            must = inside & (texels > 1.2).all(axis=0)
            cast = set(map(tuple, tile.casters.indices.reshape(-1, 3).tolist()))
            casts = np.array([each in cast for each in map(tuple, triangles.tolist())])
            assert casts[must].all() and not casts[outside].any()
            shown |= must
    assert shown.mean() > 0.95, "from a light in the middle nearly all are seen"
