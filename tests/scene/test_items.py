"""Pick-ups where a level's entities say, and how they move."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from figures import figure, key
from followspot.assets.archive import Archive
from followspot.scene.character import Character, Crowd
from followspot.scene.figure import transformed
from followspot.scene.figure_file import FigureFiles
from followspot.scene.ground import Ground
from followspot.scene.items import MODELS, items
from followspot.scene.load import load
from model_fixtures import small_md3, write_md3
from synthetic import box, floor, make_scene, open_bsp, rotation

GROUND = Ground(make_scene([floor(1000, z=-16)]).level)


def game(tmp_path: Path, *models: str) -> FigureFiles:
    for model in models:
        path = tmp_path / f"models/{model}.md3"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(write_md3(small_md3()))
    tmp_path.mkdir(exist_ok=True)
    return FigureFiles(Archive.open([tmp_path]), lambda _: None)


def found(files: FigureFiles, *entities: dict[str, str]) -> list[Character]:
    return items(replace(open_bsp(), entities=entities), files, GROUND)


def test_items_fall_and_those_that_hang_do_not(tmp_path: Path) -> None:
    files = game(tmp_path, "powerups/armor/armor_red")
    entity = {"classname": "Item_Armor_Body", "origin": "8 4 200"}
    flags = "0", "1", " 1", "-x"
    fallen, hanging, also_hanging, broken = found(
        files, *(entity | {"spawnflags": text} for text in flags)
    )
    np.testing.assert_allclose(fallen.walk.places, [[8, 4, -16 + 15, 0]])
    np.testing.assert_allclose(hanging.walk.places, [[8, 4, 200, 0]])
    np.testing.assert_allclose(also_hanging.walk.places, hanging.walk.places)
    np.testing.assert_allclose(broken.walk.places, fallen.walk.places)
    assert fallen.figure is hanging.figure


def test_they_bob_by_eight_units_and_turn_once_in_two_seconds(tmp_path: Path) -> None:
    files = game(tmp_path, "powerups/armor/armor_red", "powerups/health/medium_cross")
    origin = {"origin": "0 0 0"}
    crowd = Crowd(
        found(
            files,
            {"classname": "worldspawn"},
            {"classname": "item_armor_body"} | origin,
            {"classname": "item_health"} | origin,
        )
    )
    times = np.linspace(0, 3, 301)
    places = np.stack([crowd.places(t) for t in times.tolist()])
    height = places[..., 2]
    np.testing.assert_allclose(height.min(axis=0), -1, atol=0.01)
    np.testing.assert_allclose(height.max(axis=0), 7, atol=0.01)
    np.testing.assert_allclose(height[:, 0], 3 + 4 * np.cos(5.01 * (times + 1)), atol=1e-9)
    turned = (places[-1, :, 3] - places[0, :, 3]) / 3
    np.testing.assert_allclose(turned, [360 / 2.048, 360 / 1.024])


def test_weapons_lie_round_their_middle_one_and_a_half_times_as_large(tmp_path: Path) -> None:
    files = game(tmp_path, "weapons2/rocketl/rocketl")
    (weapon,) = found(files, {"classname": "weapon_rocketlauncher", "origin": "0 0 0"})
    own = files.open("models/weapons2/rocketl/rocketl.md3").parts[0].positions[0]
    lies = weapon.figure.parts[0].positions[0]
    np.testing.assert_allclose(lies.min(axis=0), -lies.max(axis=0), atol=1e-5)
    np.testing.assert_allclose(np.ptp(lies, axis=0), 1.5 * np.ptp(own, axis=0), rtol=1e-6)
    assert weapon.walk.places[0, 2] == pytest.approx(-1 + 8)


def test_a_weapon_that_has_tags_alone_is_not_there_to_see(tmp_path: Path) -> None:
    model = small_md3() | {"surfaces": []}
    path = tmp_path / f"models/{MODELS['weapon_shotgun'][0]}.md3"
    path.parent.mkdir(parents=True)
    path.write_bytes(write_md3(model))
    with Archive.open([tmp_path]) as archive:
        files = FigureFiles(archive, lambda _: None)
        entity = {"classname": "weapon_shotgun", "origin": "0 0 30"}
        bsp = replace(open_bsp(), entities=(entity,))
        (weapon,) = items(bsp, files, Ground(make_scene([floor()]).level))
    assert weapon.figure.triangle_count == 0


def test_a_power_ups_ring_goes_the_other_way(tmp_path: Path) -> None:
    files = game(tmp_path, "powerups/instant/quad", "powerups/instant/quad_ring")
    quad, ring = found(files, {"classname": "item_quad", "origin": "0 0 0"})
    assert quad.spin > 0 > ring.spin
    assert ring.walk.places[0, 2] - quad.walk.places[0, 2] == 12


def test_second_models_that_the_game_never_draws_are_not_there(tmp_path: Path) -> None:
    both = "powerups/armor/shard", "powerups/holdable/medkit"
    files = game(tmp_path, *both, *(f"{model}_sphere" for model in both))
    kinds = "item_armor_shard", "holdable_medkit"
    shown = found(files, *({"classname": kind, "origin": "0 0 0"} for kind in kinds))
    assert [item.figure.name for item in shown] == [f"models/{model}.md3" for model in both]


def test_what_is_missing_is_listed_once_and_left_out(tmp_path: Path) -> None:
    files = game(tmp_path, "powerups/health/small_cross")
    entities = [
        {"classname": "item_health_small", "origin": "0 0 0"},
        {"classname": "item_haste", "origin": "0 0 0"},
        {"classname": "item_haste", "origin": "9 0 0"},
        {"classname": "item_health_small", "origin": "nowhere"},
        {"classname": "item_unknown", "origin": "0 0 0"},
    ]
    (cross,) = found(files, *entities)
    assert cross.figure.name == "models/powerups/health/small_cross.md3"
    told = [str(problem) for problem in files.problems]
    assert len(told) == 1 and "models/powerups/instant/haste.md3" in told[0]
    assert found(files) == []


def test_transformed_figures() -> None:
    """Turned, moved and scaled: positions all that, normals only turned."""
    ball = figure([box((-1, -2, -3), (1, 2, 3))])
    matrix = key((5, 0, 0), 2 * rotation((0, 0, 1), 90))
    part, moved = ball.parts[0], transformed(ball, matrix).parts[0]
    expected = part.positions @ matrix[:3, :3].T + (5, 0, 0)
    np.testing.assert_allclose(moved.positions, expected, atol=1e-5)
    np.testing.assert_allclose(moved.normals, part.normals @ rotation((0, 0, 1), 90).T, atol=1e-6)
    np.testing.assert_allclose(np.linalg.norm(moved.normals, axis=-1), 1, atol=1e-6)


@pytest.mark.openarena
def test_openarenas_items() -> None:
    """Every item of a level of OpenArena is there, near where it was told."""
    scene = load("oa_dm5", with_items=True)
    with scene.archive:
        wanted = [e for e in scene.level.bsp.entities if e.get("classname", "").lower() in MODELS]
        assert len(scene.crowd) >= len(wanted) > 20
        assert not any(".md3" in str(problem) for problem in scene.problems)
        for name in ("weapon_rocketlauncher", "item_health_mega"):
            assert scene.archive.exists(f"models/{MODELS[name][0]}.md3")
