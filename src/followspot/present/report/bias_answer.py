"""Why front faces may be left out of a shadow map, why that takes less bias, and when it fails."""

import io
import math

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from followspot.arrays import Floats
from followspot.present.report import plot
from followspot.present.report.bias_samples import REACH
from followspot.present.report.bias_study import (
    CONTACT,
    LABELS,
    OFFSETS,
    BiasStudy,
    Rates,
    study,
)
from followspot.present.report.material import Material
from followspot.present.report.plot import Line
from followspot.present.report.plot_frame import Mark
from followspot.present.report.prose import prose
from followspot.present.report.section import Section
from followspot.present.report.ticks import Axis
from followspot.scene.settings import CullFace

ZERO = OFFSETS.index(0.0)


def section(material: Material) -> Section:
    """The answer, with the experiment run on the scene's first light that casts a shadow."""
    found = study(material.scene, material.camera, material.size, material.on_progress)
    values = {} if found is None else _values(found)
    html = prose("bias.html", study=found, labels=LABELS, cullings=tuple(CullFace), **values)
    files = {} if found is None else {_file(key): _png(p) for key, p in found.pictures.items()}
    return Section(
        "bias",
        "Why the shadow map holds back faces, and how little bias that takes",
        html,
        {} if found is None else _figures(found),
        files,
    )


def _values(found: BiasStudy) -> dict[str, object]:
    samples = found.samples
    floor = 0.5 / len(samples.places)
    solid = samples.plain & ~samples.places.two_sided
    thickness = (samples.thickness / samples.texel)[solid & samples.lit]
    gap = (samples.gap / samples.texel)[solid & ~samples.lit]
    height, width = found.pictures[None].shape[:2]
    return {
        "count": len(samples.places),
        "lit": float(samples.lit.mean()),
        "edges": float(samples.near_edge.mean()),
        "texel": float(np.median(samples.texel)),
        "farthest": math.sqrt(2) * (found.settings.shadow_taps + 1) / 2,
        "zero": ZERO,
        "contact": f"{CONTACT:g}",
        "own": found.settings.shadow_normal_offset,
        "best": {culling: int(rates.wrong.argmin()) for culling, rates in found.rates.items()},
        "offsets": OFFSETS,
        "thin": _share_below(thickness, 1.0),
        "close": _share_below(gap, 1.0),
        "shadow_plot": _sweep(found, "false shadow", "false_shadow", floor),
        "light_plot": _sweep(found, "false light", "false_light", floor),
        "room_plot": _room(thickness, gap, REACH / float(samples.texel.max())),
        "file": _file,
        "size": (width, height),
    }


def _sweep(found: BiasStudy, name: str, field: str, floor: float) -> str:
    series = [
        Line(
            LABELS[culling],
            OFFSETS,
            np.maximum(getattr(rates, field), floor) * 100,
            markers=culling is not CullFace.NONE,
            dashed=culling is CullFace.NONE,
        )
        for culling, rates in found.rates.items()
    ]
    marks = [Mark(found.settings.shadow_normal_offset, "as set", across=False)]
    return plot.lines(
        f"Rate of {name} over the bias, for three ways of culling",
        series,
        Axis("texels that places are lifted", limits=(OFFSETS[0], OFFSETS[-1])),
        Axis(f"{name}, % of the places", log=True),
        marks=marks,
        description=f"Lowest rate of {name}: "
        + "; ".join(
            f"{LABELS[culling]} {getattr(rates, field).min() * 100:.2f} %"
            for culling, rates in found.rates.items()
        ),
    )


def _room(thickness: Floats, gap: Floats, most: float) -> str:
    """Shares of places with less room than so many texels, at most those that were looked for."""
    texels = np.geomspace(0.1, max(min(most, 100.0), 1.0), 61)
    series = [
        Line(label, texels, np.searchsorted(np.sort(values), texels) / len(values) * 100)
        for label, values in (
            ("lit: thickness behind", thickness),
            ("shaded: gap before", gap),
        )
        if len(values)
    ]
    return plot.lines(
        "How much room there is for errors of depth",
        series,
        Axis("texels along the ray", log=True),
        Axis("% of the places that have less", limits=(0, 100)),
        marks=[Mark(1.0, "one texel", across=False)],
        description="Cumulative shares: of lit places by the thickness of the solid behind them, "
        "of shaded ones by the gap between them and the first back that the light meets.",
    )


def _share_below(values: Floats, limit: float) -> float:
    return float((values < limit).mean()) if len(values) else 0.0


def _figures(found: BiasStudy) -> dict[str, float]:
    figures = {"places": float(len(found.samples.places))}
    figures |= _rates_at("own", found.chosen, 0)
    for culling, rates in found.rates.items():
        figures |= _rates_at(f"{culling.value}_unbiased", rates, ZERO)
        figures[f"{culling.value}_least_offset"] = rates.least
        figures[f"{culling.value}_endless_false_light"] = found.without_map(culling)[0]
    return figures


def _rates_at(name: str, rates: Rates, number: int) -> dict[str, float]:
    return {
        f"{name}_false_shadow": float(rates.false_shadow[number]),
        f"{name}_false_light": float(rates.false_light[number]),
    }


def _png(picture: NDArray[np.uint8]) -> bytes:
    """A small picture whose single pixels matter."""
    file = io.BytesIO()
    Image.fromarray(picture).save(file, "png", optimize=True)
    return file.getvalue()


def _file(culling: CullFace | None) -> str:
    return f"bias-{'own' if culling is None else culling.value}.png"
