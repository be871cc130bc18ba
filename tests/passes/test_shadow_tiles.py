"""What shadow maps cover and what casts into them, as it is kept from frame to frame."""

import msgspec
import numpy as np

from followspot.passes.shadow_fit import Boxes
from followspot.passes.shadow_tiles import ShadowTiles
from followspot.scene.settings import CullFace, Settings
from synthetic import box, floor, make_scene, spot

SETTINGS = Settings()
HIGH = spot((0, 0, 500), (0, 0, 0), 40)
LOW = spot((-300, 0, 200), (0, 0, 0), 30)
SCENE = make_scene([floor(), *box((-20, -20, 10), (20, 20, 60))], HIGH, LOW)


def receivers(half: float) -> Boxes:
    """Of a square on the floor."""
    corner = np.array([[half, half, 0]], np.float32)
    return Boxes(-corner, corner)


def test_what_comes_out_alike_is_kept() -> None:
    tiles = ShadowTiles(SCENE)
    assert tiles.fit((HIGH, LOW), SETTINGS, receivers(100))
    frusta, casters = tiles.frusta, tiles.casters
    assert all(each.triangle_count > 0 for each in casters)
    assert not tiles.fit((HIGH, LOW), SETTINGS, receivers(100)), "other boxes of the same extent"
    assert tiles.frusta == frusta and tiles.casters == casters
    assert tiles.fit((LOW, HIGH), SETTINGS, receivers(100)), "another order"
    assert tiles.frusta == frusta[::-1] and tiles.casters == casters[::-1]
    assert tiles.fit((LOW, HIGH), SETTINGS, receivers(10))
    assert not set(tiles.frusta) & set(frusta)
    front = msgspec.structs.replace(SETTINGS, shadow_cull=CullFace.BACK)
    before = tiles.frusta
    assert tiles.fit((LOW, HIGH), front, receivers(10)), "other faces cast"
    assert not set(tiles.frusta) & set(before)


def test_a_light_that_is_there_twice_has_two_tiles() -> None:
    tiles = ShadowTiles(SCENE)
    for half in (100, 101):
        tiles.fit((HIGH, HIGH), SETTINGS, receivers(half))
        assert len(tiles.frusta) == len(tiles.casters) == 2
    places = [tiles.shadow_from_world(number) @ (0, 0, 0, 1) for number in (0, 1)]
    x = [place[0] / place[3] for place in places]
    np.testing.assert_allclose(np.diff(x), 0.5)
