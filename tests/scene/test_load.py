"""From a name to a scene."""

import gc
import shutil
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from figures import at, figure, with_characters
from followspot.errors import AssetError, UsageError
from followspot.levelbuilder import (
    Level,
    Material,
    Surface,
    compile_level,
    image_file,
    material_files,
    room,
    write_pk3,
)
from followspot.scene.light import PointLight
from followspot.scene.load import load, with_chosen_light
from followspot.scene.scene import Scene
from followspot.scene.search import BUILTIN, builtin_scenes
from followspot.scene.sky_files import BUILTIN_SKY
from synthetic import box, floor, make_scene


@pytest.fixture(scope="module")
def courtyard() -> Iterator[Scene]:
    scene = load("courtyard")
    with scene.archive:
        yield scene


@pytest.fixture
def opened(tmp_path: Path) -> Iterator[Callable[[str], Scene]]:
    """Load a scene file of this text; closed again behind the test."""
    scenes: list[Scene] = []

    def load_text(text: str) -> Scene:
        scenes.append(load(write(tmp_path / "mine.toml", text)))
        return scenes[-1]

    yield load_text
    for scene in scenes:
        scene.archive.close()


def test_builtin_scene_needs_no_data(courtyard: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    assert "courtyard" in builtin_scenes()
    assert courtyard.name == "courtyard" and courtyard.problems == ()
    assert courtyard.missing == ()
    assert courtyard.mesh.triangle_count > 500 and len(courtyard.cameras) >= 2
    assert all(courtyard.archive.exists(name) for name in courtyard.images)
    assert courtyard.camera() is next(iter(courtyard.cameras.values()))
    low, high = courtyard.mesh.bounds
    assert (high - low > 100).all()


def test_mesh_of_a_real_level_is_well_formed(courtyard: Scene) -> None:
    mesh = courtyard.mesh
    np.testing.assert_allclose(np.linalg.norm(mesh.vertices["normal"], axis=1), 1, atol=1e-5)
    assert np.isfinite(mesh.vertices["position"]).all()
    assert mesh.indices.max() < len(mesh.vertices)
    assert (np.diff(mesh.faces["material"]) >= 0).all()
    ends = mesh.faces["first_index"] + mesh.faces["index_count"]
    assert mesh.faces["first_index"].tolist() == [0, *ends[:-1]] and ends[-1] == len(mesh.indices)
    assert mesh.faces["material"].max() < len(courtyard.materials)


def test_front_faces_are_clockwise_and_agree_with_their_normals(courtyard: Scene) -> None:
    mesh = courtyard.mesh
    a, b, c = (mesh.vertices["position"][mesh.indices[k::3]].astype(np.float64) for k in range(3))
    normal = np.cross(c - a, b - a)
    large = np.linalg.norm(normal, axis=1) > 1e-3
    shading = mesh.vertices["normal"][mesh.indices].reshape(-1, 3, 3).mean(axis=1)
    assert (np.einsum("ij,ij->i", normal, shading)[large] > 0).mean() > 0.99


def test_steps_are_told_in_order() -> None:
    steps: list[str] = []
    load("courtyard", on_step=steps.append).archive.close()
    assert steps[0] == "search" and len(steps) == len(set(steps)) >= 5


def write(path: Path, text: str) -> str:
    path.write_text(text, encoding="utf-8")
    return str(path)


Open = Callable[[str], Scene]


def test_scene_file_names_a_level_beside_it(opened: Open, tmp_path: Path) -> None:
    shutil.copy(BUILTIN / "courtyard.pk3", tmp_path / "yard.pk3")
    for level in ("yard.pk3", "yard.pk3:courtyard"):
        scene = opened(f'level = "{level}"')
        assert scene.mesh.triangle_count > 500 and scene.lights_chosen


def test_a_bad_pak_in_a_game_folder_stops_no_scene_and_is_listed(tmp_path: Path) -> None:
    bad = tmp_path / "download.pk3"
    bad.touch()
    scene = load("courtyard", [tmp_path])
    with scene.archive:
        assert [problem.source for problem in scene.problems] == [str(bad)]


def test_a_sky_that_is_not_whole_is_listed_and_the_brought_along_one_stands_in(
    tmp_path: Path,
) -> None:
    white = np.full((8, 8, 3), 255, np.uint8)
    stone = Material("textures/stone", (64, 64), 1.0, image=white)
    script = "skyParms env/half 512 -"
    sky = Material("textures/sky", surface=Surface.SKY | Surface.NOLIGHTMAP, script=script)
    level = Level()
    level.add(room((-64, -64, 0), (64, 64, 128), stone, faces={"+z": sky}))
    level.spawn(0, 0, 0)
    files = material_files("yard", [stone, sky]) | {"maps/yard.bsp": compile_level(level)}
    for suffix in ("rt", "bk"):
        files[f"env/half_{suffix}.jpg"] = image_file(white)[1]
    write_pk3(tmp_path / "yard.pk3", files)
    scene = load(str(tmp_path / "yard.pk3"))
    with scene.archive:
        assert scene.sky.name == BUILTIN_SKY
        (problem,) = scene.problems
        assert problem.source == "env/half_lf" and problem.expected == "a sky image"


def test_a_chosen_light_leaves_a_files_light_from_all_around(opened: Open) -> None:
    plain, given = (opened(f'level = "courtyard"\n{text}') for text in ("", "ambient = 0.7"))
    assert given.lights_chosen and given.ambient == 0.7 != plain.ambient
    for _ in range(2):  # as films do for their path
        given = with_chosen_light(given, [given.camera()])
        assert given.ambient == 0.7
    light = PointLight(np.zeros(3), np.ones(3))
    assert given.with_lights(light).ambient == 0.7
    assert plain.with_lights(light).ambient == 0.0


def test_patches_are_cut_as_finely_as_asked(courtyard: Scene) -> None:
    coarse = load("courtyard", patch_tolerance=16.0)
    with coarse.archive:
        assert coarse.mesh.triangle_count < 0.7 * courtyard.mesh.triangle_count
        assert coarse.materials == courtyard.materials


def test_bounds_hold_the_level_and_where_characters_go() -> None:
    scene = make_scene([floor(100)])
    assert [corner.tolist() for corner in scene.bounds] == [[-100, -100, 0], [100, 100, 0]]
    ball = figure([box((-1, -1, -1), (1, 1, 1))])
    mins, maxs = with_characters(scene, at(ball, (300, 0, 50)), at(ball, (0, 0, -70))).bounds
    np.testing.assert_allclose(mins, (-100, -100, -70 - ball.radius), rtol=1e-6)
    np.testing.assert_allclose(maxs, (300 + ball.radius, 100, 50 + ball.radius), rtol=1e-6)


def test_scene_file_gives_lights_cameras_units_and_settings(opened: Open) -> None:
    text = """
        level = "courtyard"
        metres_per_unit = 0.05
        environment_constant = 0.25
        [[lights]]
        type = "point"
        position = [0, 0, 100]
        power = 3
        [cameras.corner]
        position = [1, 2, 3]
        [settings]
        shadow_map_size = 64
    """
    scene = opened(text)
    assert not scene.lights_chosen and len(scene.lights) == 1
    assert next(iter(scene.cameras)) == "corner" and len(scene.cameras) > 1
    assert scene.camera().position.tolist() == [1, 2, 3]
    assert (scene.metres_per_unit, scene.environment_constant) == (0.05, 0.25)
    assert scene.settings.shadow_map_size == 64


def test_a_scene_files_cameras_win_over_spawn_points(opened: Open) -> None:
    text = 'level = "courtyard"\n[cameras.spawn0]\nposition = [1, 2, 3]'
    scene = opened(text)
    assert scene.camera("spawn0").position.tolist() == [1, 2, 3]


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ('level = "no_such_level"', r"mine.toml: level: no_such_level: expected .*found none"),
        ('level = "bad.bsp"', r"mine.toml: level: .*bad.bsp: .*expected .*, found"),
        ('level = "../../etc/passwd"', "passwd"),
        (f'level = "{"x" * 5000}"', "xxx"),
        ('level = "a\\u0000b"', "level"),
        ('level = ""', "mine.toml: level: '': expected a bsp"),
        ('level = "courtyard"\nsky = "env/nowhere"', "mine.toml: sky: env/nowhere_rt: expected a"),
        ('level = "courtyard"\n[[characters]]\nmodel = ""\nposition = [0, 0, 0]', "model: '': exp"),
    ],
)
def test_what_a_scene_names_and_is_not_there(tmp_path: Path, text: str, told: str) -> None:
    (tmp_path / "bad.bsp").write_bytes(b"IBSP")
    with pytest.raises(AssetError, match=told) as caught:
        load(write(tmp_path / "mine.toml", text))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("name", ["", "no_such_level", "nowhere.toml", "x" * 5000, "a\0b", "/"])
def test_names_of_nothing(name: str) -> None:
    with pytest.raises(AssetError):
        load(name)


@pytest.mark.parametrize(
    ("name", "told"), [("robbots", "robots"), ("castel", "castle"), ("Castle", "castle")]
)
def test_built_in_scenes_are_proposed(name: str, told: str) -> None:
    with pytest.raises(AssetError, match=f"{name}: expected .*close names are {told}"):
        load(name)


def test_missing_assets_folder(tmp_path: Path) -> None:
    with pytest.raises(AssetError, match="nothing there"):
        load("courtyard", [tmp_path / "nowhere"])


def test_unknown_camera(courtyard: Scene) -> None:
    with pytest.raises(UsageError, match="no camera is named 'roof'; there are "):
        courtyard.camera("roof")


def test_a_scene_that_is_let_go_closes_its_files() -> None:
    """Nobody has to know that a scene holds paks open: no warning when it is collected."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", ResourceWarning)
        load("courtyard")
        gc.collect()
    assert [str(warning.message) for warning in caught] == []
