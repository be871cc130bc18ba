import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from PIL import Image

from followspot.errors import AssetError
from followspot.present import tell as told
from followspot.present.inspect_model import inspect, tell
from followspot.scene.figure_file import is_model
from mesh_fixtures import cube, gltf_cube, obj, ply
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
        ("b.GLB", True),
        ("b.gltf", True),
        ("b.obj", True),
        ("b.ply", True),
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


CUBE_SURFACE = {
    "triangles": 12,
    "vertices": 24,
    "image": "wood.png",
    "tinted": False,
    "drawn": "solid",
    "sides": "front",
}


@pytest.mark.parametrize(
    ("file", "surface"),
    [("cube.glb", "meshes[0].primitives[0]"), ("cube.obj", "geometry"), ("cube.ply", "mesh")],
)
def test_a_mesh_is_told_of_itself_not_of_a_floor_that_it_might_stand_on(
    tmp_path: Path, file: str, surface: str
) -> None:
    document = gltf_cube(
        cube(),
        images=[{"uri": "wood.png"}],
        textures=[{"source": 0}],
        materials=[{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
    )
    document.primitive["material"] = 0
    (tmp_path / "cube.glb").write_bytes(document.glb())
    (tmp_path / "cube.obj").write_bytes(obj(cube(), "cube.mtl", "wood"))
    (tmp_path / "cube.mtl").write_text("newmtl wood\nmap_Kd wood.png\n")
    (tmp_path / "cube.ply").write_bytes(ply(cube(), "wood.png"))
    Image.new("RGB", (4, 4)).save(tmp_path / "wood.png")
    found = inspect(str(tmp_path / file), ())
    assert found["file"] == str(tmp_path / file)
    assert found["counts"] == {"surfaces": 1, "triangles": 12, "vertices": 24, "images": 1}
    bounds = {"mins": [-16] * 3, "maxs": [16] * 3, "unit": "Quake units"}
    assert found["bounds"] == bounds
    assert found["surfaces"] == [{"name": surface, **CUBE_SURFACE}]
    assert found["missing"] == found["problems"] == found["animations"] == []
    (tmp_path / "wood.png").unlink()
    (tmp_path / "cube.mtl").unlink()
    bare = inspect(str(tmp_path / file), ())
    assert bare["surfaces"][0]["image"] is None and bare["counts"]["images"] == 0
    if file == "cube.obj":
        assert bare["missing"] == [] and "found cube.mtl" in bare["problems"][0]
    else:
        assert names(bare["missing"]) == ["wood.png"]


def test_a_meshs_own_colours_are_not_a_missing_image(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    look = {"pbrMetallicRoughness": {"baseColorFactor": [1, 0, 0, 0.5]}, "alphaMode": "BLEND"}
    document = gltf_cube(cube(), materials=[{**look, "doubleSided": True}])
    document.primitive["material"] = 0
    (tmp_path / "glass.glb").write_bytes(document.glb())
    told.inspect(str(tmp_path / "glass.glb"), (), as_json=True)
    (surface,) = json.loads(capsys.readouterr().out)["surfaces"]
    assert surface["image"] is None and surface["tinted"]
    assert (surface["drawn"], surface["sides"]) == ("blended", "both")
    told.inspect(str(tmp_path / "glass.glb"), (), as_json=False)
    shown = capsys.readouterr().out
    for word in ("coloured", "blended", "both", "12 triangles", "bounds [-16.0, -16.0, -16.0] to"):
        assert word in shown
    for word in ("white", "frames", "floor", "lightmaps"):
        assert word not in shown


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
