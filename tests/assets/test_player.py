from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from followspot.assets.animation import Animation
from followspot.assets.archive import Archive
from followspot.assets.player import (
    PARTS,
    Player,
    list_players,
    load_player,
    parse_skin,
)
from followspot.errors import AssetError
from model_fixtures import OPENARENA, animation_config, openarena_files, write_player


def load(game: Path, name: str = "bot") -> Player:
    with Archive.open([game]) as archive:
        return load_player(archive, name)


def told(player: Player) -> list[tuple[str, str]]:
    """File's last name and place of each problem."""
    return [(p.source.rpartition("/")[2], p.place) for p in player.problems]


def test_a_whole_player(tmp_path: Path) -> None:
    write_player(tmp_path)
    player = load(tmp_path, "BOT")
    assert (player.name, player.skin, player.problems) == ("bot", "default", ())
    assert tuple(player.parts) == PARTS
    assert player.parts["upper"].textures == ("models/players/bot/upper", "belt.tga")
    assert list(player.parts["upper"].model.tags) == ["tag_head", "tag_weapon"]
    assert player.config.sex == "m"
    assert player.config.animations["legs_turn"] == Animation(17, 1, 1, 34.0)


def test_another_skin(tmp_path: Path) -> None:
    folder = write_player(tmp_path)
    for part in PARTS:
        (folder / f"{part}_red.skin").write_text("l_legs,red.tga\nbelt,red.tga")
    player = load(tmp_path, "bot/Red")
    assert player.skin == "red"
    assert player.parts["head"].textures == ("red.tga", "red.tga")
    assert player.problems == ()


def test_a_player_without_a_default_skin_wears_the_first_that_all_parts_have(
    tmp_path: Path,
) -> None:
    folder = write_player(tmp_path)
    for part in PARTS:
        (folder / f"{part}_default.skin").unlink()
        (folder / f"{part}_red.skin").write_text("l_legs,red.tga\nbelt,red.tga")
        (folder / f"{part}_gold.skin").write_text("l_legs,gold.tga\nbelt,gold.tga")
    (folder / "head_gold.skin").unlink()
    player = load(tmp_path)
    assert player.skin == "red"
    assert player.parts["lower"].textures == ("red.tga", "red.tga")
    (problem,) = player.problems
    assert (problem.expected, problem.found) == ("*_default.skin", "none; it wears red")


def test_missing_and_broken_files_are_listed_and_the_rest_stands(tmp_path: Path) -> None:
    folder = write_player(tmp_path)
    (folder / "upper.md3").unlink()
    (folder / "head.md3").write_bytes(b"IDP3")
    (folder / "lower_default.skin").unlink()
    (folder / "animation.cfg").unlink()
    player = load(tmp_path)
    assert list(player.parts) == ["lower"]
    assert player.parts["lower"].textures == (None, None)
    assert player.config.animations == {}
    assert told(player) == [
        ("upper.md3", ""),
        ("head.md3", "header"),
        ("lower_default.skin", ""),
        ("animation.cfg", ""),
    ]


def test_broken_texts_surfaces_without_skin_and_missing_tags_are_listed(tmp_path: Path) -> None:
    folder = write_player(tmp_path)
    (folder / "lower_default.skin").write_text("l_legs,a.tga\nnonsense\n")
    (folder / "upper_default.skin").write_text("l_legs,a.tga\nbelt,\n")
    (folder / "animation.cfg").write_text(animation_config("headoffset x"))
    (folder / "head.md3").rename(folder / "upper.md3")
    player = load(tmp_path)
    assert player.parts["lower"].textures == (None, None)
    assert player.parts["upper"].textures == ("a.tga", None)
    assert told(player) == [
        ("head.md3", ""),
        ("lower_default.skin", "line 2"),
        ("upper_default.skin", "belt"),
        ("animation.cfg", "line 1"),
    ]
    write_player(tmp_path, "other")
    (folder / "lower.md3").write_bytes((folder / "upper.md3").read_bytes())
    assert ("lower.md3", "tag_torso") in told(load(tmp_path))


def test_animations_are_cut_to_the_frames_of_the_parts_that_play_them(tmp_path: Path) -> None:
    folder = write_player(tmp_path)
    rows = animation_config().replace("0\t1\t1\t10", "20\t6\t0\t10", 1)  # of both
    rows = rows.replace("11\t1\t1\t21", "40\t3\t3\t21")  # torso_stand
    (folder / "animation.cfg").write_text(rows)
    player = load(tmp_path)
    assert player.config.animations["both_death1"] == Animation(20, 5, 0, 10.0)
    assert player.config.animations["torso_stand"] == Animation(24, 1, 1, 21.0)
    assert told(player) == [("animation.cfg", "both_death1"), ("animation.cfg", "torso_stand")]
    assert "frames below 25, found 20 to 25" in str(player.problems[0])


def test_players_that_are_not_there(tmp_path: Path) -> None:
    folder = write_player(tmp_path)
    for name in ("robot", "", "..", "bot.md3"):
        with pytest.raises(AssetError) as error:
            load(tmp_path, name)
        assert "there are bot" in str(error.value)
    for part in PARTS:
        (folder / f"{part}.md3").write_bytes(b"")
    with pytest.raises(AssetError, match=r"lower.md3: byte 0: expected the letters IDP3"):
        load(tmp_path)
    (tmp_path / "empty").mkdir()
    with pytest.raises(AssetError, match=r"upper.md3 and head.md3, found none$"):
        load(tmp_path / "empty")


def test_skins_that_are_not_there(tmp_path: Path) -> None:
    folder = write_player(tmp_path)
    with pytest.raises(AssetError, match="bot/: skin: expected a skin: default, found nope"):
        load(tmp_path, "bot/nope")
    (folder / "head_nope.skin").write_text("")  # one part's will do
    assert load(tmp_path, "bot/nope").skin == "nope"


def test_list_players(tmp_path: Path) -> None:
    write_player(tmp_path)
    (write_player(tmp_path, "Headless") / "head.md3").unlink()
    (tmp_path / "models" / "players" / "stuff").mkdir()
    (tmp_path / "models" / "players" / "stuff" / "gun.md3").write_bytes(b"")
    with Archive.open([tmp_path]) as archive:
        assert list_players(archive) == ["bot", "headless"]


def test_skin() -> None:
    text = (
        'H_Head,Models\\Players/a.TGA\r\ntag_torso,\n\r\ntag_head\n  "hat" , "b c" // d,e\r'
        "// only, a comment\nh_head,second.tga\nbare,\n\0\n"
    )
    assert parse_skin(text, "x.skin") == {"h_head": "models/players/a.tga", "hat": "b c"}


@pytest.mark.parametrize(
    ("text", "place"),
    [("nonsense", "line 1"), ("a,b\r\n\r\n,c", "line 3"), ("a,b\n,", "line 2")],
)
def test_skins_that_lie(text: str, place: str) -> None:
    with pytest.raises(AssetError) as error:
        parse_skin(text, "x.skin")
    assert error.value.place == place
    assert error.value.expected == "surface,texture"


@given(st.text(alphabet='ab,"\r\n\t\0 /\\tag_', max_size=40))
def test_any_skin_parses_or_is_an_asset_error(text: str) -> None:
    try:
        textures = parse_skin(text, "x.skin")
    except AssetError as error:
        assert error.place.startswith("line ")
    else:
        assert all(textures)


@pytest.fixture(scope="module")
def openarena() -> Iterator[Archive]:
    assert OPENARENA.is_dir(), f"OpenArena's data is not installed in {OPENARENA}"
    with Archive.open([OPENARENA]) as archive:
        yield archive


@pytest.mark.openarena
def test_all_skins_of_openarena_parse() -> None:
    skins = dict(openarena_files(".skin"))
    assert len(skins) > 250
    for source, data in skins.items():
        parse_skin(data.decode("latin-1"), source)


@pytest.mark.openarena
def test_all_players_of_openarena_move_through_all_their_frames(openarena: Archive) -> None:
    """Each animation meets frames that its parts have."""
    players = list_players(openarena)
    assert len(players) >= 18
    for name in players:
        player = load_player(openarena, name)
        assert tuple(player.parts) == PARTS
        assert len(player.config.animations) >= 25
        # The sorceress really has no default skin.
        assert [p.found for p in player.problems] == ["none; it wears blue"] * (name == "sorceress")
        for animation in player.config.animations.values():
            steps = np.arange(2 * animation.count + 1) / 2 / animation.fps
            pose = animation.pose(steps)
            reach = animation.first + animation.count
            assert pose.frame.min() >= animation.first
            assert max(pose.frame.max(), pose.next_frame.max()) < reach
