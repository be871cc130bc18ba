"""Lamps, clusters and counts, on scenes and in levels."""

import math
from pathlib import Path

import html5lib
import numpy as np
import pytest

from followspot.assets.shader_deform import Sprite
from followspot.assets.shader_values import BlendFactor
from followspot.present.renderer import Renderer
from followspot.present.report import lamps, lights_answer, lights_study
from followspot.present.report.clusters import FIRST_SLICE, SLICES, TILES, Clusters
from followspot.present.report.lamps import CUT_OFF, GREY, GREY_AT, LAMPS, REACH, place_lamps
from followspot.present.report.lights_study import LightsStudy, study
from followspot.present.report.material import Material as Wanted
from followspot.scene import bsp_tree
from followspot.scene.deform import Deforms
from followspot.scene.load import load
from followspot.scene.material import Material
from followspot.scene.scene import Scene
from synthetic import SIZE, box, camera, floor, make_scene, of, rays

VIEW = camera((10, -20, 30), yaw=40, pitch=12, fov=80)


def test_a_lamp_shows_middle_grey_where_it_says_and_ends_at_its_reach() -> None:
    places = np.array([[0, 0, 0], [0, 0, GREY_AT - REACH]])
    normal = np.array([[0, 0, -1.0]])
    shown = lamps.shown_at(places, np.array([[0, 0, GREY_AT]]), normal)
    np.testing.assert_allclose(shown[:, 0], [GREY, CUT_OFF])
    slanted = np.array([[0, math.sin(1), -math.cos(1)]])
    np.testing.assert_allclose(
        lamps.shown_at(places, np.array([[0, 0, GREY_AT]]), slanted), shown * math.cos(1)
    )
    assert not lamps.shown_at(places, np.array([[0, 0, GREY_AT]]), -normal).any()


def test_pixels_lie_in_the_clusters_that_say_so() -> None:
    """A small sphere or box around what a pixel shows meets the cluster of the pixel."""
    rng = np.random.default_rng(1)
    clusters = Clusters(VIEW, SIZE, 900.0)
    pixel = rng.integers(0, SIZE[0] * SIZE[1], 300)
    depth = rng.uniform(FIRST_SLICE + 1, 900, 300)  # at the eye itself many clusters meet
    place = VIEW.position + rays(VIEW).reshape(-1, 3)[pixel] * depth[:, np.newaxis]
    own = clusters.of_pixels(pixel, depth)
    assert (own >= 0).all() and (own < TILES[0] * TILES[1] * SLICES).all()
    each = np.arange(300)
    assert clusters.in_spheres(place, 1e-3)[each, own].all()
    assert clusters.in_boxes(place - 1e-3, place + 1e-3)[each, own].all()
    assert clusters.in_spheres(place, 1e-3).sum(axis=1).max() <= 8  # itself and its neighbours


def test_a_sphere_is_in_clusters_exactly_where_a_point_of_them_is_in_the_sphere() -> None:
    """Points of every cluster, by their pixels and depths, are never in a sphere not listed."""
    rng = np.random.default_rng(2)
    clusters = Clusters(VIEW, SIZE, 500.0)
    centre, radius = VIEW.position + VIEW.forward * 150 + (40, -30, 20), 90.0
    pixel = rng.integers(0, SIZE[0] * SIZE[1], 200_000)
    depth = rng.uniform(1, 500, 200_000)
    place = VIEW.position + rays(VIEW).reshape(-1, 3)[pixel] * depth[:, np.newaxis]
    inside = np.linalg.norm(place - centre, axis=1) < radius
    touched = np.zeros(TILES[0] * TILES[1] * SLICES, bool)
    touched[clusters.of_pixels(pixel[inside], depth[inside])] = True
    listed = clusters.in_spheres(centre[np.newaxis], radius)[0]
    assert not (touched & ~listed).any()
    assert listed.sum() < 3 * touched.sum()  # clusters' boxes in view space are a little larger


@pytest.mark.parametrize(
    "level", ["courtyard", pytest.param("oa_dm1", marks=pytest.mark.openarena)]
)
def test_lamps_hang_in_the_open_apart_from_each_other(level: str) -> None:
    scene = load(level)
    with scene.archive:
        placed = place_lamps(scene)
    assert len(placed.position) == sum(placed.sources) == LAMPS
    leaf = bsp_tree.point_leafs(scene.level.bsp, placed.position)
    assert not bsp_tree.leaf_is_solid(scene.level.bsp)[leaf].any()
    between = np.linalg.norm(placed.position[:, np.newaxis] - placed.position, axis=2)
    assert between[~np.eye(LAMPS, dtype=bool)].min() >= 64
    assert (placed.sources[0] > 0) == (level == "courtyard")


def test_light_ends_at_walls_or_at_its_reach() -> None:
    scene = load("courtyard")
    with scene.archive:
        places = place_lamps(scene).position[:3]
    ends = lamps.traced_ends(scene, places)
    length = np.linalg.norm(ends - places[:, np.newaxis], axis=2)
    assert (length <= REACH * (1 + 1e-9)).all()
    assert (length < REACH / 2).mean() > 0.3
    way = (ends - places[:, np.newaxis])[length > 1] / length[length > 1][:, np.newaxis]
    assert np.abs(way.mean(axis=0)).max() < 0.05  # spread evenly


def test_only_what_is_drawn_into_a_map_counts_as_a_caster() -> None:
    sprite = Material("sprite", deforms=Deforms(sprite=Sprite.WHOLE))
    glass = Material("glass", blend=(BlendFactor.ONE, BlendFactor.ONE))
    scene = make_scene([floor(), *of(sprite, floor(z=10)), *of(glass, floor(z=20)), floor(z=30)])
    near = scene.mesh.faces["mins"][:, 2] < 25  # all but the last
    reached = {"every lamp": np.ones((1, len(near)), bool), "its reach": np.array([near])}
    assert lights_study._casters(scene, reached) == {"every lamp": 4, "its reach": 2}


def check(found: LightsStudy) -> None:
    """What holds of every level: each way of choosing keeps what a stricter one keeps."""
    pixel, face = found.per_pixel, found.per_face
    names = "every lamp", "within its reach", "and leafs see each other"
    assert pixel[names[0]] >= pixel[names[1]] >= pixel[names[2]] >= pixel["arrives"] > 0
    assert pixel["within its reach"] <= pixel["in cluster, by spheres"] + 0.1  # of samples
    assert pixel["in cluster, by spheres"] >= pixel["in cluster, by boxes"]
    assert pixel["within its reach"] >= pixel["facing it, above the cut-off"] >= pixel["arrives"]
    assert pixel["in cluster, by boxes"] >= pixel["arrives"] - 0.1
    assert face[names[0]] >= face[names[1]] >= face[names[2]] >= face["facing it"]
    counts = list(found.in_frame.values())
    assert counts == sorted(counts, reverse=True)
    sizes = np.arange(len(found.cluster_sizes))
    assert found.cluster_sizes.sum() == pytest.approx(1)
    assert sizes @ found.cluster_sizes == pytest.approx(pixel["in cluster, by spheres"])
    assert (np.diff(found.over_cut_off[1]) <= 0).all()
    for kept in (found.kept_of_frame, found.kept_of_pixel):
        assert kept[0] == 0
        assert kept[-1] == pytest.approx(1)
    assert (found.kept_of_pixel >= found.kept_of_frame - 1e-9).all()
    bounds = found.bounds
    assert bounds["what its rays fill"] < bounds["sphere of its reach"]
    assert bounds["both boxes"] <= bounds["box of where its rays end"]
    assert bounds["both boxes"] <= bounds["box of faces it may light"]
    assert (found.tiles > 0).sum() == counts[-1]


def count(renderer: Renderer, level: str) -> LightsStudy:
    scene = load(level)
    with scene.archive:
        found = study(scene, scene.camera(), renderer, lambda share, what: None)
    assert found is not None
    return found


@pytest.fixture(scope="module")
def courtyard(renderer: Renderer) -> LightsStudy:
    return count(renderer, "courtyard")


@pytest.mark.gl
def test_the_courtyards_counts_agree_with_each_other(courtyard: LightsStudy) -> None:
    check(courtyard)
    assert courtyard.map_ms is not None
    assert courtyard.window is not None
    assert courtyard.window < 1


@pytest.mark.gl
@pytest.mark.openarena
def test_a_levels_counts_agree_and_its_walls_matter(renderer: Renderer) -> None:
    found = count(renderer, "oa_dm1")
    check(found)
    assert found.bounds["box of where its rays end"] < found.bounds["sphere of its reach"] / 3
    assert found.per_pixel["arrives"] < found.per_pixel["within its reach"] / 3


def material(scene: Scene, renderer: Renderer, folder: Path) -> Wanted:
    return Wanted("a", scene, VIEW, SIZE, (), renderer, folder, lambda share, what: None)


@pytest.mark.gl
def test_the_section_is_html(
    renderer: Renderer, tmp_path: Path, courtyard: LightsStudy, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(lights_answer, "study", lambda *_: courtyard)
    section = lights_answer.section(material(make_scene([]), renderer, tmp_path))
    html5lib.HTMLParser(strict=True).parseFragment(section.html)
    assert "$" not in section.html
    assert section.html.count('role="img"') == 5
    assert all(np.isfinite(value) for value in section.figures.values())


@pytest.mark.gl
@pytest.mark.parametrize("pieces", [[], [floor(), *box((-20, -20, 0), (20, 20, 60))]])
def test_a_scene_without_open_leafs_has_the_design_alone(
    renderer: Renderer, tmp_path: Path, pieces: list[object]
) -> None:
    section = lights_answer.section(material(make_scene(pieces), renderer, tmp_path))  # type: ignore[arg-type]
    html5lib.HTMLParser(strict=True).parseFragment(section.html)
    assert "nothing to count" in section.html
    assert not section.figures
