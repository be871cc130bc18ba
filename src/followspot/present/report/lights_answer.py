"""How many lights could be handled: a design, its cost model, and counts on the level at hand."""

import math

import numpy as np

from followspot.gpu.blocks import MAX_LIGHTS, MAX_SHADOWS
from followspot.gpu.context import is_software
from followspot.present.report import lamps, plot
from followspot.present.report.clusters import SLICES, TILES
from followspot.present.report.lights_study import LightsStudy, study
from followspot.present.report.material import Material
from followspot.present.report.plot import Line
from followspot.present.report.plot_frame import Mark
from followspot.present.report.prose import prose
from followspot.present.report.section import Section
from followspot.present.report.ticks import Axis

BUDGET = 8
"""Lamps that a frame or a pixel might keep, for which the loss is told."""


def section(material: Material) -> Section:
    """The answer, with lamps put into the scene's level and counted from its camera."""
    found = study(material.scene, material.camera, material.renderer, material.on_progress)
    metres = material.scene.metres_per_unit
    values = {} if found is None else _values(found, material)
    html = prose(
        "lights.html",
        study=found,
        metres=metres,
        most=(MAX_LIGHTS, MAX_SHADOWS),
        reach=lamps.REACH * metres,
        grey_at=lamps.GREY_AT * metres,
        tiles=TILES,
        software=is_software(material.renderer.gl_renderer),
        slices=SLICES,
        **values,
    )
    return Section(
        "lights",
        "Handling many lights",
        html,
        {} if found is None else _figures(found),
    )


def _values(found: LightsStudy, material: Material) -> dict[str, object]:
    count = len(found.placed.position)
    size = material.scene.settings.shadow_map_size
    tiles = found.tiles.astype(np.float64)
    return {
        "count": count,
        "cost": _costs(found),
        "budget": min(BUDGET, count),
        "map_size": size,
        "tile_texels": float((tiles**2).sum()),
        "equal_texels": 6.0 * count * size**2,
        "atlas": 2 ** math.ceil(math.log2(max(math.sqrt((tiles**2).sum()), 1.0))),
        "lit_lamps": int((tiles > 0).sum()),
        "pixel_plot": _pixel_plot(found),
        "cluster_plot": _cluster_plot(found),
        "cut_off_plot": _cut_off_plot(found),
        "bounds_plot": _bounds_plot(found),
        "kept_plot": _kept_plot(found),
    }


def _costs(found: LightsStudy) -> dict[str, float]:
    """Milliseconds that the lamps' shading takes by the model, by how lamps are chosen."""
    per_lamp = found.light_ns * 1e-6 * found.pixels
    return {way: mean * per_lamp for way, mean in found.per_pixel.items()}


def _pixel_plot(found: LightsStudy) -> str:
    return plot.bars(
        "Lamps that a pixel adds up, by how they are chosen",
        list(found.per_pixel),
        {"lamps": list(found.per_pixel.values())},
        Axis("lamps per pixel, mean"),
        description="From all lamps down to those whose light arrives.",
    )


def _cluster_plot(found: LightsStudy) -> str:
    lamps_held = np.arange(len(found.cluster_sizes))
    last = int(np.flatnonzero(found.cluster_sizes + found.fitted_sizes).max()) + 2
    series = [
        Line(label, lamps_held[:last], sizes[:last] * 100, markers=True)
        for label, sizes in (("spheres", found.cluster_sizes), ("boxes", found.fitted_sizes))
    ]
    return plot.lines(
        "Occupancy of the clusters",
        series,
        Axis("lamps in the pixel's cluster"),
        Axis("% of the pixels"),
        description="Distributions over the pixels, with spheres and with fitted boxes.",
    )


def _cut_off_plot(found: LightsStudy) -> str:
    cut_offs, counts = found.over_cut_off
    return plot.lines(
        "Lamps that arrive at a pixel, by the cut-off",
        [Line("arrive", cut_offs, counts)],
        Axis("cut-off, linear display value", log=True),
        Axis("lamps per pixel, mean"),
        marks=[
            Mark(lamps.CUT_OFF, "1/255", across=False),
            Mark(lamps.CUT_OFF / 12.92, "a step on black", across=False),
        ],
        description="The lower the cut-off, the more lamps count.",
    )


def _bounds_plot(found: LightsStudy) -> str:
    return plot.dots(
        "Volume of what bounds a lamp",
        list(found.bounds),
        {"volume": list(found.bounds.values())},
        Axis("cubic metres, median of the lamps", log=True),
        description="From no bounds to what the lamp's light really fills.",
    )


def _kept_plot(found: LightsStudy) -> str:
    kept = np.arange(len(found.kept_of_frame))
    return plot.lines(
        "Share of the lamps' light that the strongest ones give",
        [
            Line("strongest of the frame", kept, found.kept_of_frame * 100, markers=True),
            Line("strongest of each pixel", kept, found.kept_of_pixel * 100, markers=True),
        ],
        Axis("lamps that are kept", limits=(0, len(kept) - 1)),
        Axis("% of the light", limits=(0, 100)),
        description="How much light is lost where only so many lamps are drawn.",
    )


def _figures(found: LightsStudy) -> dict[str, float]:
    figures = {f"pixel_{_key(way)}": mean for way, mean in found.per_pixel.items()}
    figures |= {f"face_{_key(way)}": mean for way, mean in found.per_face.items()}
    figures |= {f"bounds_m3_{_key(way)}": volume for way, volume in found.bounds.items()}
    figures["light_ns"] = found.light_ns
    if found.map_ms is not None:
        figures["map_ms"] = found.map_ms
    return figures


def _key(words: str) -> str:
    return "".join(c if c.isalnum() else "_" for c in words).replace("__", "_")
