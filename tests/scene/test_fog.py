"""A level's fog: which boxes there are, and how much of them lies on a way."""

from dataclasses import replace

import numpy as np
import pytest

from followspot.arrays import Floats
from followspot.assets.archive import Archive
from followspot.assets.bsp import LUMPS, BspFile
from followspot.assets.bsp_reader import read_bsp
from followspot.assets.locate import list_levels, search_path
from followspot.assets.script_files import load_scripts
from followspot.assets.shader_parser import find_entries
from followspot.assets.shader_script import ShaderScript
from followspot.scene.fog import Fog, optical_depths, volumes
from synthetic import open_bsp

SCRIPTS = {
    "textures/sfx/mist": "surfaceparm fog\nFogParms ( 1 0.5 0 ) 300",
    "textures/sfx/thin": "fogparms (2 -1 .5) 0.001",
    "textures/sfx/wrong": "fogparms ( 1 1 )",
    "textures/base/wall": "surfaceparm fog",
}


def find(name: str) -> ShaderScript | None:
    text = "\n".join(f"{name}\n{{\n{body}\n}}" for name, body in SCRIPTS.items())
    entries, _ = find_entries(text, "test")
    return next((each.read() for each in entries if each.name == name), None)


def level(*effects: tuple[bytes, int]) -> BspFile:
    """Two brushes in a world 100 units wide: a box with a cut corner, and one open to the top."""
    planes = np.zeros(12, LUMPS["planes"])
    normals = [(-1, 0, 0), (1, 0, 0), (0, -1, 0), (0, 1, 0), (0, 0, -1), (0, 0, 1)]
    planes["normal"] = [*normals, (0.6, 0, 0.8), *normals[:5]]
    planes["distance"] = [20, 10, 5, 15, 40, -8, 3, 1, 2, 3, 4, 5]
    sides = np.zeros(12, LUMPS["brush_sides"])
    sides["plane"] = np.arange(12)
    brushes = np.array([(0, 7, 0), (7, 5, 0)], LUMPS["brushes"])
    models = np.zeros(1, LUMPS["models"])
    models["mins"], models["maxs"] = -50, 50
    records = np.array([(*effect, -1) for effect in effects], LUMPS["effects"])
    made = replace(open_bsp(), planes=planes, brush_sides=sides, brushes=brushes, models=models)
    return replace(made, effects=records)


def test_a_volume_is_the_box_of_its_brush_inside_the_world() -> None:
    cut, high = volumes(level((b"textures/sfx/mist", 0), (b"textures/sfx/mist", 1)), find)
    assert cut.mins.tolist() == [-20, -5, -40] and cut.maxs.tolist() == [10, 15, -8]
    assert high.mins.tolist() == [-1, -3, -5] and high.maxs.tolist() == [2, 4, 50]


def test_a_twentieth_of_the_light_comes_through_the_depth_that_the_script_tells() -> None:
    (fog,) = volumes(level((b"textures/sfx/mist", 0)), find)
    assert np.exp(-300 * fog.extinction) == pytest.approx(0.05)
    np.testing.assert_allclose(fog.albedo, [1, 0.21404114, 0])


def test_colours_and_depths_are_bounded() -> None:
    (fog,) = volumes(level((b"textures/sfx/thin", 0)), find)
    np.testing.assert_allclose(fog.albedo, [1, 0, 0.21404114])
    assert np.exp(-fog.extinction) == pytest.approx(0.05)


def test_what_no_script_calls_fog_is_none() -> None:
    names = (b"textures/sfx/wrong", b"textures/base/wall", b"textures/none", b"")
    assert volumes(level(*((name, 0) for name in names)), find) == ()


def test_optical_depth_is_what_adds_up_step_by_step() -> None:
    random = np.random.default_rng(4)
    corners = [(random.uniform(-20, 0, 3), random.uniform(0, 20, 3)) for _ in range(5)]
    fogs = [Fog(low, high, np.ones(3), 0.1 * (n + 1)) for n, (low, high) in enumerate(corners)]
    eye, places = random.uniform(-20, 20, 3), random.uniform(-30, 30, (200, 3))
    steps = (np.arange(4000) + 0.5) / 4000
    found = optical_depths(fogs, eye, places)
    for fog, depths in zip(fogs, found.T, strict=True):
        at = eye + (places - eye)[:, np.newaxis] * steps[:, np.newaxis]
        share = ((at > fog.mins) & (at < fog.maxs)).all(axis=2).mean(axis=1)
        summed = share * np.linalg.norm(places - eye, axis=1) * fog.extinction
        np.testing.assert_allclose(depths, summed, atol=0.02)
    assert (found > 0.5).any(axis=0).all()


def test_ways_along_the_axes_are_divided_by_nothing() -> None:
    fog = Fog(np.zeros(3), np.full(3, 10.0), np.ones(3), 1.0)
    eye = np.array([-5.0, 5.0, 5.0])
    places: Floats = np.array([[20.0, 5.0, 5.0], [-9.0, 5.0, 5.0], [-5.0, 5.0, 5.0]])
    assert optical_depths([fog], eye, places)[:, 0].tolist() == [10, 0, 0]
    up = np.array([0, 6, 0])
    assert optical_depths([fog], eye + up, places + up)[:, 0].tolist() == [0, 0, 0]
    down = np.array([0, -5, 0])
    on_a_plane = optical_depths([fog], eye + down, places + down)
    assert np.isfinite(on_a_plane).all()


@pytest.mark.openarena
def test_every_volume_of_openarena_is_understood() -> None:
    levels = 0
    with Archive.open(search_path()) as archive:
        scripts = load_scripts(archive)
        for name in list_levels(archive):
            entry = f"maps/{name}.bsp"
            bsp = read_bsp(archive.read(entry), entry)
            fogs = volumes(bsp, scripts.find)
            assert len(fogs) == len(bsp.effects)
            assert all((fog.maxs > fog.mins).all() for fog in fogs)
            levels += bool(fogs)
    assert levels == 28
