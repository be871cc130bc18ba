"""The stages of one picture, all from one viewpoint, each with a number measured in it."""

from functools import partial

import msgspec

from followspot.passes import lighting, shadow_tiles
from followspot.present import figures
from followspot.present.renderer import Renderer
from followspot.present.report.material import Material
from followspot.present.report.page import Picture, fill
from followspot.present.report.pixels import Pixels, at_most, jpeg
from followspot.present.report.section import Section
from followspot.present.report.stage_numbers import measure
from followspot.scene.light import casting

DETAIL = 2
"""Pictures have so many times the report's size along an edge, for screens of fine pixels."""

MAP_SIZE = 1024
"""Texels along an edge of the shadow map's picture, at most."""

_STAGES = {stage.name.partition("-")[2]: stage for stage in figures.SEQUENCE}


def title(material: Material) -> Section:
    """The final picture, above everything else."""
    with _fine_renderer(material) as renderer:
        drawn = figures.draw(renderer, material.scene, material.camera, _STAGES["shadows"])
    size = drawn.shape[1], drawn.shape[0]
    picture = Picture("title.jpg", size, f"{material.name} as followspot draws it")
    html = fill("title.html", picture=picture)
    return Section("title", "The title picture", html, files={picture.file: jpeg(drawn)})


def stages(material: Material) -> Section:
    """Every stage from normals to shadows, the debugging view and the shadow map."""
    has_map = bool(lighting.shadowed(material.scene.lights, material.scene.settings))
    names = [name for name in _STAGES if has_map or name != "shadow-map"]
    drawn: dict[str, Pixels] = {}
    with _fine_renderer(material) as renderer:
        for number, name in enumerate(names):
            material.on_progress(number / (len(names) + 1), name)
            drawn[name] = figures.draw(renderer, material.scene, material.camera, _STAGES[name])
    map_size = shadow_tiles.tile_size(material.scene.settings)
    if has_map:
        drawn["shadow-map"] = at_most(MAP_SIZE, drawn["shadow-map"])
    material.on_progress(len(names) / (len(names) + 1), "measuring")
    numbers = measure(material)
    html = fill(
        "stages.html",
        numbers=numbers,
        has_map=has_map,
        map_size=map_size,
        is_cube=has_map and not casting(material.scene.lights),
        settings=material.scene.settings,
        picture=partial(_picture, drawn),
    )
    files = {_file(name): jpeg(picture) for name, picture in drawn.items()}
    return Section(
        "stages", "One picture, stage by stage", html, msgspec.structs.asdict(numbers), files
    )


def _fine_renderer(material: Material) -> Renderer:
    return Renderer((material.size[0] * DETAIL, material.size[1] * DETAIL))


def _file(name: str) -> str:
    return f"stage-{name}.jpg"


def _picture(drawn: dict[str, Pixels], name: str, alt: str, label: str = "") -> Picture:
    height, width = drawn[name].shape[:2]
    return Picture(_file(name), (width, height), alt, label)
