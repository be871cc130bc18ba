"""What is measured in the stages' pictures, from their linear values."""

import msgspec
import numpy as np

from followspot.arrays import Floats, Mask
from followspot.passes.view import View
from followspot.present.report.material import Material

_ROUNDING = 5e-7
"""Relative difference up to which two float32 results are the same value worked out in two ways."""


class StageNumbers(msgspec.Struct, frozen=True):
    """Figures of one viewpoint; shares are in [0, 1].

    Attributes:
        normal_length_error: Largest difference of a normal's length from 1.
        albedo_mean: Mean Lambertian coefficient of opaque surfaces.
        albedo_largest: Its largest value.
        product_error: Largest relative difference of texture times shading from lit texture.
        product_share: Share of the surfaces' pixels that this was looked at in: those with nothing
            blended in front.
        unlit_share: Share of the surfaces' pixels that no light reaches by a straight line, walls
            apart, and that are black without the environment.
        environment_share: The environment's share of the light that the picture shows.
        shadowed_share: Share of the key light that the picture's surfaces lose to shadows.
    """

    normal_length_error: float
    albedo_mean: float
    albedo_largest: float
    product_error: float
    product_share: float
    unlit_share: float
    environment_share: float
    shadowed_share: float


def measure(material: Material) -> StageNumbers:
    """Draw the linear values of every stage from the material's viewpoint and compare them.

    Without fog, which hangs before the last stage alone.
    """
    views = (
        View.FINAL, View.NORMALS, View.LAMBERTIAN, View.SHADING, View.DIRECT, View.ENVIRONMENT,
        View.SHADOW, View.DEPTH,
    )  # fmt: skip
    with_shadows = _draw(material, views, shadows=True)
    unshadowed = _draw(material, (View.DIRECT, View.SHADOW), shadows=False)
    surface: Mask = np.isfinite(with_shadows[View.DEPTH])
    lit = with_shadows[View.DIRECT] + with_shadows[View.ENVIRONMENT]
    opaque = surface & (_difference(with_shadows[View.FINAL], lit).max(axis=2) < _ROUNDING)
    albedo = with_shadows[View.LAMBERTIAN]
    product = albedo * with_shadows[View.SHADING]
    lengths = np.linalg.norm(with_shadows[View.NORMALS][surface] * 2 - 1, axis=1)
    return StageNumbers(
        normal_length_error=_largest(np.abs(lengths - 1)),
        albedo_mean=_mean(albedo[opaque]),
        albedo_largest=_largest(albedo[opaque]),
        product_error=_largest(_difference(product, lit)[opaque]),
        product_share=_mean(opaque[surface]),
        unlit_share=_mean(unshadowed[View.DIRECT][surface].max(axis=1) <= 0),
        environment_share=_ratio(with_shadows[View.ENVIRONMENT][surface], lit[surface]),
        shadowed_share=1
        - _ratio(with_shadows[View.SHADOW][surface], unshadowed[View.SHADOW][surface]),
    )


def _draw(material: Material, views: tuple[View, ...], *, shadows: bool) -> dict[str, Floats]:
    scene = material.scene
    shadows = shadows and scene.settings.shadows
    settings = msgspec.structs.replace(scene.settings, shadows=shadows, fog=False)
    drawn = material.renderer.render(scene, material.camera, views, settings=settings, linear=True)
    return {view: values.astype(np.float64) for view, values in drawn.items()}


def _difference(values: Floats, expected: Floats) -> Floats:
    """|values - expected| over the brightest channel of what is expected."""
    brightest = expected.max(axis=-1, keepdims=True)
    difference: Floats = np.abs(values - expected) / np.maximum(brightest, 1e-12)
    return difference


def _largest(values: Floats) -> float:
    return float(values.max(initial=0.0))


def _mean(values: Floats | Mask) -> float:
    return float(values.mean()) if values.size else 0.0


def _ratio(part: Floats, whole: Floats) -> float:
    """Of the sums; 1 where there is nothing at all."""
    return float(part.sum() / whole.sum()) if whole.sum() > 0 else 1.0
