"""Characters from scene files, figures from files, and what is said of what is missing."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from followspot.assets.archive import Archive
from followspot.errors import AssetError
from followspot.game import RUN_SPEED
from followspot.scene import scene_file, walk
from followspot.scene.camera import Camera
from followspot.scene.cast import actors, characters
from followspot.scene.figure_file import FigureFiles, is_model
from followspot.scene.ground import Ground
from followspot.scene.load import load, load_figure
from followspot.scene.search import BUILTIN
from followspot.spaces import vec3
from model_fixtures import small_md2, small_md3, write_md2, write_md3, write_player
from synthetic import box, floor, make_scene


@pytest.fixture
def game(tmp_path: Path) -> Path:
    """A game folder with a player and a model of each kind."""
    game = tmp_path / "game"
    write_player(game)
    folder = game / "models" / "things"
    folder.mkdir(parents=True)
    (folder / "bot.md2").write_bytes(write_md2(small_md2()))
    (folder / "crate.md3").write_bytes(write_md3(small_md3()))
    for name in ("models/things/bot.png", "models/bot.png", "models/players/bot/lower.png"):
        Image.new("RGB", (4, 4)).save(game / name)
    (game / "scripts").mkdir()
    return game


def files(game: Path) -> FigureFiles:
    return FigureFiles(Archive.open([game]), lambda _: None)


GROUND = Ground(make_scene([floor(1000, z=-16), *box((90, -50, -16), (300, 50, 0))]).level)


def cast(game: Path, text: str) -> Any:
    entries = scene_file.parse(f'level = "x"\n{text}', "x.toml").characters
    return characters(entries, files(game), GROUND, "x.toml")


def test_a_character_stands_on_the_floor(game: Path) -> None:
    text = '[[characters]]\nmodel = "player:bot"\nposition = [5, 6, 50]\nyaw = 30'
    (one,) = cast(game, text)
    np.testing.assert_allclose(one.walk.places, [[5, 6, -16 + 24, 30]])
    (hung,) = cast(game, f"{text}\non_ground = false\nclock = 2.5")
    np.testing.assert_allclose(hung.walk.places, [[5, 6, 50, 30]])
    assert hung.clock == 2.5
    (bot,) = cast(game, '[[characters]]\nmodel = "models/things/bot.md2"\nposition = [0, 0, 0]')
    # It stands in its last frame, whose lowest vertex is 1 below the origin.
    np.testing.assert_allclose(bot.walk.places, [[0, 0, -15, 0]])


def test_a_walker_keeps_to_the_ground_and_stops_at_the_end(game: Path) -> None:
    text = '[[characters]]\nmodel = "player:bot"\npath = [[0, 0, 4], [200, 0, 4]]\nspeed = 50'
    (round_,) = cast(game, text)
    assert round_.walk.is_closed and round_.walk.length == pytest.approx(400)
    (once,) = cast(game, f"{text}\nclosed = false")
    places = once.walk.places
    np.testing.assert_allclose(places[places[:, 0] < 89, 2], -16 + 24)
    np.testing.assert_allclose(places[places[:, 0] > 91, 2], 24)
    legs = once.figure.animations
    assert [(p[0].legs, p[1]) for p in once.plays] == [
        (legs["legs_run"], 0.0),
        (legs["legs_idle"], 4.0),
    ]
    (own,) = cast(game, text.replace("\nspeed = 50", ""))
    assert own.walk.speed == RUN_SPEED  # its legs do not step


def test_one_animation_after_another(game: Path) -> None:
    (one,) = cast(
        game,
        '[[characters]]\nmodel = "models/things/bot.md2"\nposition = [0, 0, 0]\n'
        'animation = "run"\nthen = [{at = 1, animation = "stand"}, {at = 2, animation = "run"}]',
    )
    animations = one.figure.animations
    assert [p[0].legs for p in one.plays] == [animations[n] for n in ("run", "stand", "run")]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('model = "player:bot"', "characters.0.*position. and .path"),
        ('model = "player:bot"\nposition = [0, 0]', r"characters\[0\].position"),
        (
            'model = "player:bot"\nposition = [0, 0, 0]\ncolour = 1',
            r"known keys \(model, .*found colour",
        ),
        (
            'model = "player:bot"\nposition = [0, 0, 0]\nanimation = "fly"',
            "x.toml: characters.0..animation: pl.*both_death1.*found fly",
        ),
        (
            'model = "player:no"\nposition = [0, 0, 0]',
            r"characters\[0\].model: models.players.no/: expected a folder",
        ),
        (
            'model = "player:bot/no"\nposition = [0, 0, 0]',
            r"characters\[0\].model: models.*: skin: expected a skin: default, found no",
        ),
        (
            'model = "player:bot"\nposition = [0, 0, 0]\nskin = "no"',
            r"x.toml: characters\[0\].skin: models/players/bot/: expected a skin: default, f",
        ),
        (
            'model = "models/things/crate.md3"\nposition = [0, 0, 0]\nskin = "no"',
            r"x.toml: characters\[0\].skin: .*: expected a skin: none is there, found no",
        ),
        (
            'model = "player:bot"\nposition = [0, 0, 0]\n'
            'then = [{at = 1, animation = "run"}, {at = 2, animation = "fly"}]',
            r"x.toml: characters\[0\].then\[1\].animation: player:bot: expected one of .* fly$",
        ),
        (
            'model = "crate"\nposition = [0, 0, 0]',
            "x.toml: characters.0..model: crate: expected pl",
        ),
        (
            'model = "x.md3"\nposition = [0, 0, 0]',
            r"x.toml: characters\[0\].model: x.md3: expected a file in",
        ),
        (
            'model = "player:bot"\npath = [[0, 0, 0]]',
            "path: expected a path of 1 to 1e.06 units, found 0$",
        ),
        ('model = "player:bot"\npath = []', r"x.toml: characters\[0\].path: expected a path of 1"),
        ('model = "player:bot"\npath = [[0, 0, 0], [1, 1, 1]]\nspeed = 0', "speed"),
        (
            'model = "player:bot"\nposition = [0, 0, 0]\nthen = [{at = 2, animation = "run"}, '
            '{at = 1, animation = "run"}]',
            "rising order",
        ),
        (
            'model = "models/things/bot.md2"\nposition = [0, 0, 0]\nskin = "no"',
            "skin: .*models/things/bot.md2: expected a skin: models/things/bot.png, found no",
        ),
    ],
)
def test_what_a_scene_file_gets_wrong(game: Path, text: str, message: str) -> None:
    with pytest.raises(AssetError, match=message):
        cast(game, f"[[characters]]\n{text}")


def test_actors_is_one_of_a_few_words() -> None:
    with pytest.raises(AssetError, match="actors: expected none, spawns"):
        scene_file.parse('level = "x"\nactors = "all"', "x.toml")


def test_players_at_spawn_points_take_turns(game: Path) -> None:
    write_player(game, "ace")
    (game / "models/players/broken").mkdir()
    (game / "models/players/broken/lower.md3").write_bytes(b"IDP3")
    found = files(game)
    places = [Camera(vec3((10.0 * k, 0, 40)), 15.0 * k) for k in range(5)]
    with Archive.open([game]) as archive:
        crowd = actors(archive, places, found, GROUND)
    assert [c.figure.name for c in crowd] == [
        f"player:{n}" for n in ("ace", "bot", "ace", "bot", "ace")
    ]
    np.testing.assert_allclose(crowd[3].walk.places, [[30, 0, 8, 45]])
    assert len({c.clock for c in crowd}) == 5
    assert any("broken" in str(problem) for problem in found.problems)
    assert actors(Archive.open([]), places, found, GROUND) == []


def test_what_is_missing_stands_in_white_and_is_listed(game: Path) -> None:
    (game / "models/players/bot/upper.md3").unlink()
    (game / "models/players/bot/head_default.skin").unlink()
    found = files(game)
    figure = found.open("player:bot")
    assert [part.slot for part in figure.parts] == [0, 2]
    legs = {run.material.image for run in figure.parts[0].runs}
    assert legs == {"models/players/bot/lower.png", None}
    assert [run.material.image for run in figure.parts[1].runs] == [None]
    assert list(found.missing) == ["belt.tga"]
    told = " ".join(map(str, found.problems))
    assert "upper.md3" in told and "head_default.skin" in told
    assert found.open("player:bot") is figure


def test_skins_of_models(game: Path) -> None:
    found = files(game)

    def worn(name: str, skin: str | None = None) -> list[str | None]:
        return [run.material.image for part in found.open(name, skin).parts for run in part.runs]

    assert worn("models/things/bot.md2") == ["models/things/bot.png"]
    assert worn("models/things/bot.md2", "bot") == ["models/things/bot.png"]
    assert worn("models/things/crate.md3") == ["models/bot.png"]
    skin = game / "models/things/crate_red.skin"
    skin.write_text("l_legs,models/things/bot.tga\nbelt,models/things/bot.tga\n")
    found = files(game)
    assert worn("models/things/crate.md3", "red") == ["models/things/bot.png"]


def test_names_of_models() -> None:
    assert is_model("player:sarge") and is_model("a.MD3") and not is_model("courtyard")


def test_the_robot_alone_on_the_stage() -> None:
    scene = load_figure("models/robot/robot.md2", animation="run")
    with scene.archive:
        assert scene.missing == () and scene.problems == ()
        (robot,) = scene.crowd.characters
        lowest = robot.figure.parts[0].positions[..., 2]
        run = robot.figure.animations["run"]
        feet = lowest[run.first : run.first + run.count].min()
        assert robot.walk.places[0, 2] + feet == pytest.approx(0, abs=1e-5)
        assert set(scene.cameras) == {"start", "front", "left", "back", "right"}
        assert walk.stride_speed(robot.figure, run) > 60
    with pytest.raises(AssetError, match=r"expected one of stand, run.*found fly"):
        load_figure("models/robot/robot.md2", animation="fly")


def test_a_scene_file_with_the_robot(tmp_path: Path) -> None:
    path = tmp_path / "yard.toml"
    text = (BUILTIN / "courtyard.toml").read_text(encoding="utf-8")
    path.write_text(
        f'{text}\n[[characters]]\nmodel = "models/robot/robot.md2"\nposition = [-352, -118, 40]\n',
        encoding="utf-8",
    )
    scene = load(str(path))
    with scene.archive:
        (robot,) = scene.crowd.characters
        assert "models/robot/skin.jpg" in scene.images
        floor_height = robot.walk.places[0, 2] - robot.figure.floor_below(
            robot.figure.tracks().legs
        )
        assert -8 <= floor_height <= 40


@pytest.mark.openarena
def test_openarenas_players_at_a_levels_spawn_points(tmp_path: Path) -> None:
    path = tmp_path / "crowd.toml"
    path.write_text('level = "oa_dm5"\nactors = "spawns"\n', encoding="utf-8")
    scene = load(str(path))
    with scene.archive:
        spawns = [n for n in scene.cameras if n.startswith("spawn")]
        assert len(scene.crowd) == len(spawns) > 4
        for character in scene.crowd.characters:
            near = [scene.cameras[n].position - character.walk.places[0, :3] for n in spawns]
            drop = min(near, key=lambda d: float(np.hypot(d[0], d[1])))
            assert np.hypot(drop[0], drop[1]) < 1e-6 and 0 < drop[2] < 120
