"""The study of biases on scenes of which the theory says what must come out."""

from pathlib import Path

import html5lib
import numpy as np
import pytest

from followspot.assets.shader_values import Sides
from followspot.present.renderer import Renderer
from followspot.present.report import bias_answer
from followspot.present.report.bias_study import OFFSETS, BiasStudy, study
from followspot.present.report.material import Material as Wanted
from followspot.scene.load import load
from followspot.scene.material import Material
from followspot.scene.scene import Scene
from followspot.scene.settings import CullFace, Settings
from synthetic import SIZE, Piece, box, floor, looking, make_scene, of, point, quad, spot

VIEW = looking((-180, -160, 150), (20, 0, 10))
LIGHT = spot((-100, 130, 190), (10, 0, 0), 35)
SLAB = box((-300, -300, -40), (300, 300, 0))
BLOCK = box((-20, -20, 0), (20, 20, 60))
ROOF = quad((0, 0, 80), (40, 0, 0), (0, 40, 0))  # looks up, at the light
ZERO = OFFSETS.index(0.0)


def of_scene(scene: Scene) -> BiasStudy:
    found = study(scene, VIEW, SIZE, lambda share, what: None)
    assert found is not None
    return found


def of_pieces(*pieces: Piece, **settings: object) -> BiasStudy:
    return of_scene(make_scene(pieces, LIGHT, settings=Settings(**settings)))  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def solids() -> BiasStudy:
    return of_pieces(*SLAB, *BLOCK, *box((40, -60, 30), (80, 60, 40)))


@pytest.mark.gl
def test_solids_throw_the_same_shadow_whatever_is_left_out(solids: BiasStudy) -> None:
    assert 0.05 < solids.samples.lit.mean() < 0.95
    for culling in CullFace:
        assert solids.without_map(culling) == (0, 0)
    samples = solids.samples
    np.testing.assert_array_equal(samples.entries, samples.exits)


@pytest.mark.gl
def test_only_without_front_faces_no_bias_is_enough(solids: BiasStudy) -> None:
    front, back, both = (solids.rates[culling] for culling in CullFace)
    assert front.acne[ZERO] == 0
    assert back.acne[ZERO] > 0.1
    np.testing.assert_allclose(both.acne, back.acne, atol=2e-3)
    assert front.least < 0 < back.least <= 1
    assert front.wrong[ZERO] < 0.02
    for rates in solids.rates.values():
        np.testing.assert_array_less(rates.acne, rates.false_shadow + 1e-9)
        np.testing.assert_array_less(rates.leak, rates.false_light + 1e-9)
        assert rates.false_light[-1] > 2 * rates.false_light[OFFSETS.index(1.0)]  # edges move


@pytest.mark.gl
def test_what_is_next_is_told() -> None:
    told: list[tuple[float, str]] = []
    scene = make_scene([*SLAB, *BLOCK], LIGHT)
    study(scene, VIEW, (32, 24), lambda share, what: told.append((share, what)))
    shares, texts = zip(*told, strict=True)
    assert list(shares) == sorted(shares) and shares[0] >= 0 and shares[-1] < 1
    assert texts[-len(CullFace) :] == (
        "shadow maps without front faces",
        "shadow maps without back faces",
        "shadow maps with all faces",
    )


@pytest.mark.gl
def test_thickness_and_gap_are_along_the_ray(solids: BiasStudy) -> None:
    samples, light = solids.samples, LIGHT.position
    on_slab = np.abs(samples.places.position[:, 2]) < 1e-6
    way = samples.places.position - light
    reach = np.linalg.norm(way, axis=1)
    through = 40 * reach / -way[:, 2]
    lit = on_slab & samples.lit & (through < 60)
    assert lit.any()
    np.testing.assert_allclose(samples.thickness[lit], through[lit], atol=0.2)
    assert np.isinf(samples.gap[samples.lit]).all()
    # Under the board, the first back is its lower face, 30 above the floor.
    height = samples.gap * -way[:, 2] / reach
    board = on_slab & ~samples.lit & (np.abs(height - 30) < 0.2)
    assert board.sum() > 30


@pytest.mark.gl
def test_a_shell_that_looks_at_the_light_needs_its_front() -> None:
    found = of_pieces(*SLAB, ROOF)
    shaded = float((~found.samples.lit).mean())
    assert shaded > 0.05
    assert found.without_map(CullFace.FRONT) == pytest.approx((shaded, 0))
    assert found.without_map(CullFace.BACK) == (0, 0)
    assert found.rates[CullFace.FRONT].false_light[ZERO] == pytest.approx(shaded, abs=2e-3)
    assert found.rates[CullFace.NONE].false_light[ZERO] < 0.02


@pytest.mark.gl
def test_a_level_without_an_outside_needs_its_backs() -> None:
    """A ceiling that looks down, lit from above: what the hull of a level is to the sun."""
    found = of_pieces(*SLAB, quad((0, 0, 80), (0, 40, 0), (40, 0, 0)))
    shaded = float((~found.samples.lit).mean())
    assert found.without_map(CullFace.BACK) == pytest.approx((shaded, 0))
    assert found.without_map(CullFace.FRONT) == (0, 0)
    assert found.rates[CullFace.BACK].false_light[2 * len(OFFSETS) // 3] > shaded / 2


@pytest.mark.gl
def test_a_two_sided_sheet_is_in_every_map() -> None:
    sheet = of(Material("sheet", sides=Sides.BOTH), ROOF)
    found = of_pieces(*SLAB, *sheet)
    for culling in CullFace:
        assert found.without_map(culling) == (0, 0)
    rates = found.rates[CullFace.FRONT]
    assert rates.sheets[ZERO] > 0.005
    assert rates.sheets[OFFSETS.index(0.3)] < rates.sheets[ZERO] / 5


@pytest.mark.gl
def test_walls_thinner_than_a_texel_have_acne_all_the_same() -> None:
    """Acne comes back without a bias, and goes with one."""
    thin = of_pieces(*box((-300, -300, -0.02), (300, 300, 0)), *BLOCK)
    rates = thin.rates[CullFace.FRONT]
    assert rates.acne[ZERO] > 0.05
    assert rates.acne[OFFSETS.index(1.0)] < 1e-3


@pytest.mark.gl
def test_lifting_places_closes_the_gap_at_the_foot_of_walls() -> None:
    """As in levels, there is neither an outside of the room nor a face below the block."""
    room = box((-200, -200, 0), (200, 200, 300), inward=True)
    settings = Settings(shadow_map_size=64, shadow_fit=False)
    scene = make_scene([*room, *BLOCK[:-1]], LIGHT, settings=settings)
    close = looking((25, -70, 30), (0, -22, 0), 50)
    found = study(scene, close, SIZE, lambda share, what: None)
    assert found is not None
    contact = found.rates[CullFace.FRONT].contact
    assert contact[ZERO] > 0
    assert contact[OFFSETS.index(0.3)] < contact[ZERO] < contact[OFFSETS.index(-0.5)]


def material(scene: Scene, renderer: Renderer, folder: Path) -> Wanted:
    return Wanted("a scene", scene, VIEW, SIZE, (), renderer, folder, lambda share, what: None)


@pytest.mark.gl
def test_the_section_is_html_with_its_pictures(renderer: Renderer, tmp_path: Path) -> None:
    scene = make_scene([*SLAB, *BLOCK], LIGHT)
    section = bias_answer.section(material(scene, renderer, tmp_path))
    html5lib.HTMLParser(strict=True).parseFragment(section.html)
    assert "$" not in section.html
    assert section.html.count('role="img"') == 4
    assert len(section.files) == 4
    assert all(f'src="{name}"' in section.html for name in section.files)
    assert section.figures["front_unbiased_false_light"] < 0.02
    assert all(np.isfinite(value) for value in section.figures.values())


@pytest.mark.gl
@pytest.mark.parametrize("lights", [(), (point((0, 0, 90)),), (spot((0, 0, 90), (0, 0, 900), 20),)])
def test_without_shadows_the_section_has_the_theory_alone(
    renderer: Renderer, tmp_path: Path, lights: tuple[object, ...]
) -> None:
    scene = make_scene([floor()], *lights)  # type: ignore[arg-type]
    section = bias_answer.section(material(scene, renderer, tmp_path))
    html5lib.HTMLParser(strict=True).parseFragment(section.html)
    assert "nothing to measure" in section.html
    assert not section.files
    assert not section.figures


@pytest.mark.gl
@pytest.mark.openarena
def test_the_sun_shines_through_a_levels_roof_without_its_backs() -> None:
    scene = load("oa_dm5")
    with scene.archive:
        found = study(scene, scene.camera(), SIZE, lambda share, what: None)
    assert found is not None
    assert found.without_map(CullFace.BACK)[0] > 0.5
    assert found.without_map(CullFace.FRONT) == (0, 0)
    assert found.chosen.wrong[0] < 0.01
