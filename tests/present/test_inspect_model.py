import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from followspot.errors import AssetError
from followspot.present.inspect_model import inspect, is_model, tell
from model_fixtures import (
    md2_models,
    openarena_files,
    small_md2,
    small_md3,
    write_md2,
    write_md3,
    write_player,
)


def names(rows: list[dict[str, Any]]) -> list[str]:
    return [row["name"] for row in rows]


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("player:sarge", True),
        ("a/b.MD2", True),
        ("b.md3", True),
        ("courtyard", False),
        ("x.pk3:md2", False),
        ("oa_dm5.bsp", False),
    ],
)
def test_models_are_told_from_levels(name: str, expected: bool) -> None:
    assert is_model(name) is expected


def test_md2(tmp_path: Path) -> None:
    (tmp_path / "bot.md2").write_bytes(write_md2(small_md2()))
    (tmp_path / "skin.png").write_bytes(b"")
    found = inspect(str(tmp_path / "bot.md2"), ())
    assert found["file"] == str(tmp_path / "bot.md2")
    assert found["counts"] == {"frames": 3, "triangles": 2, "vertices": 5, "skins": 1}
    assert found["bounds"]["mins"] == [-1, -1, -1]
    assert found["bounds"]["maxs"] == [2, 4, 5]
    assert found["skins"] == [{"name": "players/bot/skin.pcx", "image": "skin.png"}]
    run = {"name": "run", "first": 0, "frames": 2, "looping": 2, "fps": 10.0}
    assert found["animations"][0] == run
    assert names(found["animations"]) == ["run", "stand"]
    assert found["missing"] == []


def test_md2_without_its_skins(tmp_path: Path) -> None:
    """Then images that are called as the model will do; where there are none, that is told."""
    path = tmp_path / "bot.md2"
    path.write_bytes(write_md2(small_md2()))
    assert names(inspect(str(path), ())["missing"]) == ["players/bot/skin.pcx"]
    (tmp_path / "bot_blue.tga").write_bytes(b"")
    found = inspect(str(path), ())
    assert found["skins"][1] == {"name": "bot_blue.tga", "image": "bot_blue.tga"}
    path = path.rename(tmp_path / "other.md2")
    path.write_bytes(write_md2(small_md2(), skins_count=0))
    found = inspect(str(path), ())
    assert found["skins"] == [{"name": "other", "image": None}]
    assert names(found["missing"]) == ["other"]


def test_md3(tmp_path: Path) -> None:
    for name in ("scripts/a.shader", "models/bot.md3"):
        (tmp_path / name).parent.mkdir()
    (tmp_path / "scripts" / "a.shader").write_text("models/bot { { map plain.tga } }")
    (tmp_path / "plain.jpg").write_bytes(b"")
    model = small_md3()
    model["surfaces"][1]["shaders"]["name"] = b"none.tga"
    (tmp_path / "models" / "bot.md3").write_bytes(write_md3(model))
    found = inspect(str(tmp_path / "models" / "bot.md3"), ())
    counts = {"frames": 2, "surfaces": 2, "triangles": 2, "vertices": 6, "tags": 2}
    assert found["counts"] == counts
    assert found["tags"] == ["tag_torso", "tag_flash"]
    assert [(s["name"], s["texture"], s["image"]) for s in found["surfaces"]] == [
        ("l_legs", "models/bot.tga", "plain.jpg"),  # through the script
        ("belt", "none.tga", None),
    ]
    assert names(found["missing"]) == ["none.tga"]
    assert found["bounds"]["maxs"] == [11, 11, 10.5]


def test_player(tmp_path: Path) -> None:
    folder = write_player(tmp_path)
    (folder / "head.md3").unlink()
    (folder / "lower.tga").write_bytes(b"")
    found = inspect("player:bot", [tmp_path])
    assert names(found["parts"]) == ["lower", "upper"]
    assert found["surfaces"][0]["image"] == "models/players/bot/lower.tga"
    assert len(found["animations"]) == 25
    assert set(names(found["missing"])) == {"belt.tga", "models/players/bot/upper"}
    assert len(found["problems"]) == 1
    assert found["problems"][0].startswith("models/players/bot/head.md3: expected a file")


def test_models_that_come_with_the_package() -> None:
    found = inspect("models/robot/robot.md2", ())
    skin = "models/robot/skin.jpg"
    assert found["skins"] == [{"name": skin, "image": skin}]
    assert found["missing"] == []


def test_what_is_not_there_is_an_error(tmp_path: Path) -> None:
    write_player(tmp_path)
    with pytest.raises(AssetError, match=r"there are .*bot"):
        inspect("player:bat", [tmp_path])
    with pytest.raises(AssetError, match=r"nothing\.md2: expected a file"):
        inspect("nothing.md2", [tmp_path])


def test_the_command_prints_tables_or_json(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_player(tmp_path)
    tell("player:bot", [tmp_path], as_json=True)
    assert json.loads(capsys.readouterr().out)["counts"]["surfaces"] == 6
    tell("player:bot", [tmp_path], as_json=False)
    shown = capsys.readouterr().out
    for word in ("l_legs", "tag_weapon", "legs_run", "missing: belt.tga"):
        assert word in shown
    run = [sys.executable, "-m", "followspot", "inspect", "player:bot", "--json"]
    done = subprocess.run([*run, "--assets", str(tmp_path)], capture_output=True, check=True)
    assert json.loads(done.stdout)["name"] == "player:bot"


@pytest.mark.openarena
def test_real_models_and_players(capsys: pytest.CaptureFixture[str]) -> None:
    for path, skin in zip(md2_models(), ("faerie2.bmp", "sydney.bmp"), strict=True):
        assert inspect(str(path), ())["skins"] == [{"name": skin, "image": skin}]
    assert dict(openarena_files("sarge/animation.cfg"))
    found = inspect("player:sarge", ())
    assert found["missing"] == found["problems"] == []
    assert {s["image"] for s in found["surfaces"]} == {"models/players/grism/enkiskin.tga"}
    tell("player:sorceress", (), as_json=False)
    assert "expected *_default.skin" in capsys.readouterr().out
