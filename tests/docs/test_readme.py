"""What the README says, done."""

import re
from pathlib import Path

import pytest
from typer.core import TyperGroup
from typer.main import get_command

from followspot.assets.mesh_file import MESH_SUFFIXES
from followspot.assets.model_file import MODEL_SUFFIXES
from followspot.cli import app
from followspot.present.arguments import parse_camera, parse_light, parse_size
from followspot.scene import cast_file, light_file, path_file, prop_file, scene_file
from followspot.scene.load import load
from followspot.scene.scene_file import parse
from followspot.scene.search import BUILTIN
from followspot.scene.settings import Settings

README = (Path(__file__).parents[2] / "README.md").read_text(encoding="utf-8")


def blocks(language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```", README, re.MULTILINE | re.DOTALL)


@pytest.mark.gl
def test_the_python_example_runs(capsys: pytest.CaptureFixture[str]) -> None:
    (example,) = blocks("python")
    assert len(example.strip().splitlines()) <= 12
    names: dict[str, object] = {}
    exec(compile(example, "README.md", "exec"), names)
    mean, nearest = map(float, capsys.readouterr().out.split())
    assert 30 < mean < 230
    assert nearest > 4  # the near plane


def test_the_scene_file_example_is_valid() -> None:
    (example,) = blocks("toml")
    scene = parse(example, "README.md")
    assert scene.level == "oa_dm5"
    assert list(scene.cameras) == ["stairs"]
    assert scene.lights is not None and len(scene.lights) == 1
    assert len(scene.characters) == 2 and len(scene.props) == 1


def test_the_five_files_have_all_keys_as_the_readme_says() -> None:
    entries = {
        light_file: (light_file.PointEntry, light_file.SpotEntry),
        path_file: (path_file.CameraEntry, path_file.KeyEntry, path_file.PathEntry),
        cast_file: (cast_file.CharacterEntry, cast_file.ThenEntry),
        prop_file: (prop_file.PropEntry,),
    }
    for module, kinds in entries.items():
        for key in (key for kind in kinds for key in kind.__struct_fields__):
            assert re.search(rf"\b{key} = ", module.__doc__ or ""), key
    told = "".join(module.__doc__ or "" for module in (scene_file, *entries))
    for key in scene_file.SceneFile.__struct_fields__:
        assert re.search(rf"^{key} = |^\[+{key}\b", told, re.MULTILINE), key


def test_all_kinds_of_props_are_named() -> None:
    for suffix in (*MESH_SUFFIXES, *MODEL_SUFFIXES):
        assert suffix in (prop_file.__doc__ or "")
        assert suffix in re.findall(r'^file = "urn.*', README, re.MULTILINE)[0]


def test_the_table_of_settings_is_complete_and_has_the_defaults() -> None:
    rows = dict(re.findall(r"^\| `(\w+)` \| (\S+) \|", README, re.MULTILINE))
    defaults = {name: getattr(Settings(), name) for name in Settings.__struct_fields__}
    del defaults["shadows"], defaults["sky_light"], defaults["albedo"]  # have options of their own
    shown = {
        name: "auto" if value is None else str(getattr(value, "value", value)).lower()
        for name, value in defaults.items()
    }
    assert set(rows) == set(shown)
    for name, text in rows.items():
        value = shown[name]
        assert text == value or float(text) == float(value), name


def test_the_lights_and_cameras_of_the_examples_parse() -> None:
    scene = load("courtyard")
    cameras = re.findall(r"--camera (\S+)", README)
    typed = [text for text in cameras if "," in text]
    assert len(typed) == 1 and sorted(set(cameras) - set(typed)) == ["overlook", "stairs"]
    for text in typed:
        parse_camera(text, None, scene)
    castle = (BUILTIN / "castle.toml").read_text(encoding="utf-8")
    assert "overlook" in parse(castle, "castle").cameras
    (example,) = blocks("toml")
    assert "stairs" in parse(example, "README.md").cameras
    lights = re.findall(r"--light ((?:spot|point):\S+)", README)
    assert len(lights) == 2
    for text in lights:
        parse_light(text)
    sizes = re.findall(r"--size (\S+)", README)
    assert len(sizes) == 1
    for text in sizes:
        parse_size(text)


def test_the_commands_that_are_named_are_those_that_there_are() -> None:
    group = get_command(app)
    assert isinstance(group, TyperGroup) and "render" in group.commands
    assert set(re.findall(r"\bfollowspot ([a-z]\w*)", README)) == set(group.commands)
