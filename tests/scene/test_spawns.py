"""Where a level lets players begin, as cameras."""

from dataclasses import replace

import numpy as np
import pytest

from followspot.assets.bsp import LUMPS
from followspot.assets.entities import target_of
from followspot.game import EYE_HEIGHT
from followspot.scene.camera import Camera
from followspot.scene.scene import spawn_cameras
from synthetic import open_bsp


def cameras(*entities: dict[str, str]) -> dict[str, Camera]:
    models = np.zeros(1, LUMPS["models"])
    models["mins"], models["maxs"] = (-10, 0, 20), (30, 40, 60)
    return spawn_cameras(replace(open_bsp(), models=models, entities=entities))


@pytest.mark.parametrize(
    "kind",
    [
        "info_player_deathmatch",
        "INFO_player_start",
        "team_CTF_redspawn",
        "team_CTF_blueplayer",
    ],
)
def test_players_look_from_their_spawn_points_at_eye_height(kind: str) -> None:
    found = cameras(
        {"classname": "worldspawn"},
        {"classname": kind, "origin": "1 2 3", "angle": "90"},
        {"classname": kind},
        {"classname": "light", "origin": "9 9 9"},
        {"classname": kind, "origin": "4 5 6"},
    )
    assert list(found) == ["spawn0", "spawn1"]
    assert found["spawn0"].position.tolist() == [1, 2, 3 + EYE_HEIGHT]
    assert (found["spawn0"].yaw, found["spawn0"].pitch) == (90, 0)
    assert found["spawn1"].position.tolist() == [4, 5, 6 + EYE_HEIGHT]


def test_between_matches_the_camera_stands_at_its_entity_and_looks_at_its_target() -> None:
    entity = {"classname": "info_player_intermission", "origin": "0 0 0", "angles": "20 30 0"}
    look = {"classname": "info_notnull", "targetname": "Look", "origin": "0 100 100"}
    spawn = {"classname": "info_player_deathmatch", "origin": "1 2 3"}
    plain = cameras(entity, spawn, look)
    assert list(plain) == ["spawn0", "intermission"]
    assert plain["intermission"].position.tolist() == [0, 0, 0]
    assert (plain["intermission"].yaw, plain["intermission"].pitch) == (30, 20)
    aimed = cameras(entity | {"target": "lOOK"}, look, look | {"origin": "100 0 0"})
    assert aimed["intermission"].yaw == pytest.approx(90)
    assert aimed["intermission"].pitch == pytest.approx(-45)
    for odd in ({"target": "nobody"}, {"target": "here"}):
        here = {"targetname": "here", "origin": "0 0 0"}
        assert cameras(entity | odd, here)["intermission"].yaw == 30


@pytest.mark.parametrize(
    ("written", "pitch"), [("340", -20), ("-370", -10), ("100", 90), ("-100", -90), ("260", -90)]
)
def test_angles_of_a_level_are_turns_of_which_the_game_bends_no_farther_than_upright(
    written: str, pitch: float
) -> None:
    at = {"origin": "0 0 0", "angles": f"{written} 30 0"}
    kinds = "info_player_deathmatch", "info_player_intermission"
    found = cameras(*({"classname": kind, **at} for kind in kinds))
    assert [(c.yaw, c.pitch) for c in found.values()] == [(30, pitch)] * 2


def test_a_level_without_any_is_seen_from_its_middle() -> None:
    (only,) = cameras({"classname": "worldspawn"}).values()
    assert only.position.tolist() == [10, 20, 40]


def test_a_target_is_the_first_of_its_name_in_any_case() -> None:
    one, two = {"targetname": "Door", "k": "1"}, {"targetname": "door", "k": "2"}
    bsp = replace(open_bsp(), entities=({"target": "DOOR"}, {"targetname": ""}, one, two))
    assert target_of(bsp, {"target": "dOOr"}) == one
    assert target_of(bsp, {"target": ""}) == target_of(bsp, {}) == {}
    assert target_of(bsp, {"target": "gate"}) == {}
