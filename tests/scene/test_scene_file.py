"""Scene files: what good ones mean, and one clear error for every way to get one wrong."""

import math
import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from followspot.errors import AssetError
from followspot.scene import scene_file
from followspot.scene.light import PointLight, SpotLight
from followspot.scene.settings import CullFace, Settings

WHOLE = """
level = "oa_dm5"
sky = "env/hills"
metres_per_unit = 0.0254
environment_constant = 2

[[lights]]
name = "sun"
type = "spot"
position = [0, 10, 400]
target = [0, 10, 0]
half_angle_degrees = 30
power = 5000
softness = 0.2
casts_shadow = false

[[lights]]
type = "spot"
position = [1, 2, 3]
direction = [0, 3, 4]
half_angle_degrees = 45
power = [1, 2.5, 3]

[[lights]]
type = "point"
position = [4, 5, 6]
power = 7

[cameras.start]
position = [0, -200, 60]
yaw = 90
pitch = 5
fov = 75

[cameras."from above"]
position = [0, 0, 900]

[settings]
shadow_map_size = 2048
shadow_cull = "none"
albedo = 0.5
exposure = 1.5
shadows = false
"""


def test_every_key() -> None:
    file = scene_file.parse(WHOLE, "whole.toml")
    assert (file.level, file.sky) == ("oa_dm5", "env/hills")
    assert (file.metres_per_unit, file.environment_constant) == (0.0254, 2)
    assert file.lights is not None
    sun, lamp, bulb = (entry.light() for entry in file.lights)
    assert isinstance(sun, SpotLight) and isinstance(lamp, SpotLight)
    assert (sun.name, sun.softness, sun.casts_shadow) == ("sun", 0.2, False)
    assert sun.direction.tolist() == [0, 0, -1] and sun.power.tolist() == [5000] * 3
    assert sun.half_angle == pytest.approx(math.radians(30))
    np.testing.assert_allclose(lamp.direction, (0, 0.6, 0.8))
    assert lamp.power.tolist() == [1, 2.5, 3] and lamp.casts_shadow and lamp.softness == 0
    assert isinstance(bulb, PointLight)
    assert bulb.position.tolist() == [4, 5, 6] and bulb.power.tolist() == [7] * 3
    start, above = (file.cameras[name].camera(name) for name in ("start", "from above"))
    assert (start.name, start.yaw, start.pitch, start.fov) == ("start", 90, 5, 75)
    assert start.position.tolist() == [0, -200, 60]
    assert (above.yaw, above.pitch, above.fov) == (0, 0, 90)
    assert file.settings == Settings(
        shadow_map_size=2048,
        shadow_cull=CullFace.NONE,
        albedo=0.5,
        exposure=1.5,
        shadows=False,
    )


def test_level_alone_is_enough() -> None:
    file = scene_file.parse('level = "q3dm1"', "short.toml")
    assert file.metres_per_unit == 0.03 and file.environment_constant == 1
    assert file.lights is None and file.cameras == {} and file.settings == Settings()


@pytest.mark.parametrize("word", ["auto", "AUTO", "none"])
def test_settings_that_are_left_open_may_be_said_to_be(word: str) -> None:
    """As with ``--set``, and as README's table has them."""
    text = f'level = "a"\n[settings]\nexposure = "{word}"\nenvironment_mip = "{word}"\nemission = 2'
    assert scene_file.parse(text, "auto.toml").settings == Settings(emission=2)


POINT = '[[lights]]\ntype = "point"\nposition = [0, 0, 0]\n'
SPOT = '[[lights]]\ntype = "spot"\nposition = [0, 0, 9]\npower = 5\n'
AIMED = SPOT + "target = [0, 0, 0]\n"
CAMERA = "[cameras.door]\nposition = [0, 0, 0]\n"

WRONG = {
    # text behind `level = "a"`: (place, in expected, in found)
    "levels = 3": ("", "known keys (level, sky, metres_per_unit", "levels"),
    "metres_per_unit = 0": ("metres_per_unit", ">= 1e-06", "0"),
    "metres_per_unit = 1e300": ("metres_per_unit", "<= 1000000.0", "1e+300"),
    "metres_per_unit = 1e-300": ("metres_per_unit", ">= 1e-06", "1e-300"),
    f"metres_per_unit = {'9' * 5000}": ("", "TOML", "an integer of thousands of digits"),
    f"{'.'.join('a' * 3000)} = 1": ("", "TOML", "too deep"),
    'metres_per_unit = "long"': ("metres_per_unit", "a number", "'long'"),
    "metres_per_unit = inf": ("metres_per_unit", "finite", "inf"),
    "environment_constant = -1.5": ("environment_constant", ">= 0", "-1.5"),
    "environment_constant = 1e300": ("environment_constant", "<= 1000000.0", "1e+300"),
    "ambient = 1e300": ("ambient", "<= 1000000.0", "1e+300"),
    "environment_constant = nan": ("environment_constant", "finite", "nan"),
    "sky = 3": ("sky", "text", "3"),
    "sky = 1979-05-27": ("sky", "text", "1979-05-27"),
    "lights = 3": ("lights", "a list", "3"),
    "lights = [[1]]": ("lights[0]", "a table", "[1]"),
    '[[lights]]\ntype = "sun"': ("lights[0].type", "spot", "sun"),
    "[[lights]]\nposition = [0, 0, 0]\npower = 1": ("lights[0]", "type", ""),
    POINT: ("lights[0]", "power", ""),
    POINT + "power = -1": ("lights[0].power", "from 0 to 1e+15", "-1"),
    POINT + "power = [1, -2, 3]": ("lights[0].power", "from 0 to 1e+15", "[1, -2, 3]"),
    POINT + "power = [1, 2]": ("lights[0].power", "one number or three", "[1, 2]"),
    POINT + "power = []": ("lights[0].power", "one number or three", "[]"),
    POINT + 'power = "bright"': ("lights[0].power", "a number or a list", "'bright'"),
    POINT + "power = 1e999": ("lights[0].power", "finite", "inf"),
    POINT + f"power = {'9' * 400}": ("lights[0].power", "", ""),
    POINT + "power = 1\ndirection = [0, 0, 1]": (
        "lights[0]",
        "(type, position, power, casts_shadow, name)",
        "direction",
    ),
    POINT.replace("[0, 0, 0]", "[0, 0]") + "power = 1": ("lights[0].position", "3", "2"),
    POINT.replace("[0, 0, 0]", "[0, 0, true]") + "power = 1": (
        "lights[0].position[2]",
        "a number",
        "true",
    ),
    SPOT + "angle = 30": ("lights[0]", "half_angle_degrees, direction", "angle"),
    SPOT + "half_angle_degrees = 30": (
        "lights[0]",
        "one of `direction` and `target`",
        "neither",
    ),
    AIMED: ("lights[0]", "half_angle_degrees", ""),
    AIMED + "half_angle_degrees = 90": ("lights[0].half_angle_degrees", "< 90", "90"),
    AIMED + "half_angle_degrees = 0": ("lights[0].half_angle_degrees", ">= 0.01", "0"),
    AIMED + "half_angle_degrees = 30\nsoftness = 2": ("lights[0].softness", "<= 1", "2"),
    AIMED + "half_angle_degrees = 30\ndirection = [0, 0, 1]": ("lights[0]", "one of", "both"),
    SPOT + "half_angle_degrees = 30\ntarget = [0, 0, 9]": ("lights[0]", "direction", ""),
    SPOT + "half_angle_degrees = 30\ndirection = [0, 0, 0]": ("lights[0]", "direction", ""),
    SPOT + "half_angle_degrees = 30\ndirection = [1e-200, 0, 0]": ("lights[0]", "direction", ""),
    SPOT + "half_angle_degrees = 30\ndirection = [1e308, 1e308, 0]": (
        "lights[0].direction[0]",
        "<=",
        "1e+308",
    ),
    "cameras = [1]": ("cameras", "a table", "[1]"),
    "[cameras]\ndoor = 3": ("cameras.door", "a table", "3"),
    "[cameras.door]\nyaw = 3": ("cameras.door", "position", ""),
    CAMERA + "pitch = 91": ("cameras.door.pitch", "<= 90", "91"),
    CAMERA + "fov = 0": ("cameras.door.fov", ">= 1", "0"),
    CAMERA + "roll = 3": ("cameras.door", "(position, yaw, pitch, fov)", "roll"),
    CAMERA + "yaw = 1e308": ("cameras.door.yaw", "<=", "1e+308"),
    CAMERA + "yaw = nan": ("cameras.door.yaw", "finite", "nan"),
    "settings = 1": ("settings", "a table", "1"),
    "[settings]\nbrightness = 1": ("settings", "(shadows, sky_light, albedo", "brightness"),
    "[settings]\nexposure = 1e300": ("settings.exposure", "<= 1000000.0", "1e+300"),
    "[paths.a]\nkeys = [{position = [0, 0, 0], roll = 1}]": ("paths.a.keys[0]", "look_at", "roll"),
    "[paths.a]\nkeys = [{position = [0, 0, 0], yaw = 1e308}]": ("paths.a.keys[0].yaw", "<=", "308"),
    "[settings]\nshadow_map_size = 4": ("settings.shadow_map_size", ">= 16", "4"),
    "[settings]\nshadow_map_size = 64.5": ("settings.shadow_map_size", "a whole number", "64.5"),
    '[settings]\nshadow_cull = "left"': ("settings.shadow_cull", "front", "left"),
    "[settings]\nalbedo = 1.5": ("settings.albedo", "<= 1", "1.5"),
    '[settings]\nshadows = "yes"': ("settings.shadows", "true or false", "'yes'"),
    "[settings]\nexposure = -1": ("settings.exposure", "> 0", "-1"),
    '[settings]\nexposure = "bright"': ("settings.exposure", "a number", "'bright'"),
    '[settings]\nculling = "auto"': ("settings.culling", "true or false", "'auto'"),
    "[paths.a]\nseconds = 5": ("paths.a", "either `keys` or `auto = true`", "neither"),
    "[paths.a]\nauto = true\nkeys = [{position = [0, 0, 0]}]": (
        "paths.a",
        "either `keys` or `auto = true`",
        "both",
    ),
    '[[characters]]\nmodel = "a"': (
        "characters[0]",
        "one of `position` and `path`",
        "neither",
    ),
    '[[characters]]\nmodel = "a"\npath = [[1, 2, 3]]\nposition = [1, 2, 3]': (
        "characters[0]",
        "one of `position` and `path`",
        "both",
    ),
    '[[characters]]\nmodel = "a"\nposition = [1, 2, 3]\nskin = ""': (
        "characters[0].skin",
        "text of length >= 1",
        "''",
    ),
    "exposure =": ("end of document", "TOML", ""),
    "x": ("", "TOML", ""),
    'level = "b"': ("", "TOML", ""),
    "[[lights]\n": ("line 2", "TOML", ""),
    "a = " + "[" * 5000: ("", "TOML", ""),
}


@pytest.mark.parametrize("text", WRONG, ids=lambda text: text[-60:].replace("\n", "; "))
def test_one_error_names_file_key_expected_and_found(text: str) -> None:
    place, expected, found = WRONG[text]
    with pytest.raises(AssetError) as caught:
        scene_file.parse(f'level = "a"\n{text}', "wrong.toml")
        raise AssertionError("it is accepted")
    error = caught.value
    assert error.source == "wrong.toml"
    assert error.place.startswith(place)
    assert place == error.place or not place.endswith(("door", "]"))
    assert "neither" not in error.found or error.found == "neither"
    if error.expected != "TOML":
        assert not re.search(r"\b(str|int|float|bool|array|object|null)\b", str(error))
    assert expected in error.expected and found in error.found
    assert error.expected != "a valid value" and error.found not in ("another value", "")
    assert "\n" not in str(error) and len(str(error)) < 300


@pytest.mark.parametrize("text", ["", "sky = 'env/hills'", "level = 5"])
def test_a_scene_needs_a_level(text: str) -> None:
    with pytest.raises(AssetError, match="level"):
        scene_file.parse(text, "wrong.toml")


@given(st.text(max_size=60))
def test_any_text_gives_a_scene_or_the_one_error(text: str) -> None:
    try:
        file = scene_file.parse(f'level = "a"\n{text}', "any.toml")
    except AssetError as error:
        assert error.source == "any.toml"
    else:
        assert file.level == "a"


anything = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=4),
    max_leaves=6,
)


@given(anything, st.sampled_from(["position", "power", "half_angle_degrees", "target", "softness"]))
def test_any_value_of_a_lights_key_gives_a_light_or_the_one_error(value: object, key: str) -> None:
    good = {"position": "[0, 0, 9]", "target": "[0, 0, 0]", "power": "5", "half_angle_degrees": "9"}
    lines = "\n".join(f"{name} = {text}" for name, text in (good | {key: toml(value)}).items())
    try:
        file = scene_file.parse(f'level = "a"\n[[lights]]\ntype = "spot"\n{lines}', "any.toml")
    except AssetError as error:
        assert error.source == "any.toml"
    else:
        assert file.lights is not None
        light = file.lights[0].light()
        assert np.isfinite([*light.position, *light.power, *light.intensity]).all()


def toml(value: object) -> str:
    if isinstance(value, list):
        return "[" + ", ".join(map(toml, value)) + "]"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return '"' + "".join(f"\\U{ord(c):08x}" if c not in "\ud800" else "?" for c in value) + '"'
    return str(value) if value is not None else '""'


def test_missing_and_unreadable_files(tmp_path: Path) -> None:
    with pytest.raises(AssetError, match=r"nowhere\.toml: expected a scene file, found No such"):
        scene_file.read(tmp_path / "nowhere.toml")
    with pytest.raises(AssetError, match="a scene file, found Is a directory"):
        scene_file.read(tmp_path)
    bad = tmp_path / "latin1.toml"
    bad.write_bytes(b'level = "caf\xe9"')
    with pytest.raises(AssetError, match=r"latin1\.toml: byte 12: expected UTF-8 text"):
        scene_file.read(bad)


def test_windows_line_ends_are_fine(tmp_path: Path) -> None:
    path = tmp_path / "dos.toml"
    path.write_bytes(WHOLE.replace("\n", "\r\n").encode())
    assert scene_file.read(path).level == "oa_dm5"


def test_a_byte_order_mark_is_no_part_of_the_text(tmp_path: Path) -> None:
    path = tmp_path / "scene.toml"
    path.write_bytes(b"\xef\xbb\xbflevel = 'oa_dm1'\n")
    assert scene_file.read(path) == scene_file.parse("level = 'oa_dm1'", str(path))
