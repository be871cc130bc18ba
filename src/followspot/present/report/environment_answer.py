"""How six look-ups in a tiny cube map stand for a whole sky, and how well."""

import math
from collections.abc import Sequence

import numpy as np
from markupsafe import Markup

from followspot.arrays import Floats
from followspot.assets.image import LUMINANCE
from followspot.errors import UsageError
from followspot.present import sky_irradiance
from followspot.present.report import environment_study as study
from followspot.present.report.environment_study import HARMONICS, LITERAL, SIX, TRUE_SIX, SkyErrors
from followspot.present.report.material import Material
from followspot.present.report.plot import Line, dots, heat_map, lines
from followspot.present.report.prose import prose
from followspot.present.report.section import Section
from followspot.present.report.ticks import Axis, count, number
from followspot.scene.sky import CubeMap

NORMALS = 4096
"""Directions, spread evenly, that errors are taken over."""

ROWS = 48
"""Of the map of the error by direction."""

_EXAMPLE_FACE = 512  # of which the text speaks
_LEAST_SHOWN = 1.0  # percent that the colours of the map by direction reach at least


def section(material: Material) -> Section:
    """The derivation, and the experiment on every sky that can be found.

    Raises:
        UsageError: all of them are black.
    """
    material.on_progress(0.0, "looking for skies")
    skies = study.known_skies(material.scene.sky, material.scene.archive)
    if not skies:
        raise UsageError("there is no sky with any light in it to compare")
    material.on_progress(0.3, "summing whole skies")
    normals = study.sphere(NORMALS)
    errors = study.study(skies, normals)
    material.on_progress(0.8, "comparing")
    shown, face = errors[0], skies[0].faces.shape[1]
    (by_direction,) = study.study(skies[:1], study.grid(ROWS), levels=False)
    worst = max(errors, key=lambda e: e.largest(SIX))
    at = np.abs(worst.errors[SIX]).argmax()
    angles = sky_irradiance.texel_solid_angles(face)
    axis_gain = study.CUBE_FACE_COSINE / (2 / 3)
    html = prose(
        "environment.html",
        sky=_short(shown.name),
        own=skies[0] is material.scene.sky,
        errors=[(_short(each.name), each) for each in errors],
        names={"six": SIX, "literal": LITERAL, "true_six": TRUE_SIX, "harmonics": HARMONICS},
        shown=shown,
        face=face,
        texels=6 * face * face,
        example=_EXAMPLE_FACE,
        example_level=math.log2(_EXAMPLE_FACE),
        example_texels=_EXAMPLE_FACE**2,
        normals=len(normals),
        resampled=sky_irradiance.FACE_SIZE,
        resampling=_resampling(skies[0], normals),
        literal_most=math.sqrt(3) - 1,
        axis_gain=axis_gain,
        diagonal_gain=axis_gain / math.sqrt(3),
        face_cosine=study.CUBE_FACE_COSINE,
        texel_weights=float(np.ptp(angles) / angles.max()),
        median=lambda name, what: float(np.median([getattr(e, what)(name) for e in errors])),
        worst=worst,
        worst_truth=float(worst.truth[at] / worst.truth.mean()),
        better=sum(e.mean_of_mean(HARMONICS) < e.mean_of_mean(SIX) for e in errors),
        short=_short,
        number=number,
        count=count,
        by_sky=Markup(_by_sky(errors)),
        by_level=Markup(_by_level(skies, errors)),
        by_direction=Markup(_by_direction(by_direction, SIX)),
        by_direction_harmonics=Markup(_by_direction(by_direction, HARMONICS)),
        meridian=Markup(_meridian(skies[0], normals, shown)),
    )
    figures = {"environment_skies": float(len(errors))}
    for name, key in ((SIX, "six"), (LITERAL, "literal"), (HARMONICS, "harmonics")):
        figures[f"environment_{key}_largest"] = shown.largest(name)
        figures[f"environment_{key}_mean"] = shown.mean(name)
    return Section("environment", "Six directions for a whole sky", html, figures)


def _short(name: str) -> str:
    return name.removeprefix("textures/").removeprefix("env/")


def _resampling(sky: CubeMap, normals: Floats) -> float:
    """Largest relative change of luminance if faces twice as fine are summed over."""
    some = normals[:: len(normals) // 256]
    coarse, fine = (
        sky_irradiance.irradiance(some, [sky_irradiance.radiance(sky, size)])[0]
        for size in (sky_irradiance.FACE_SIZE, 2 * sky_irradiance.FACE_SIZE)
    )
    return float(np.abs(study.relative_error(coarse, fine)).max())


def _by_sky(errors: Sequence[SkyErrors]) -> str:
    series = {
        "six directions, largest": [100 * e.of_mean(SIX) for e in errors],
        "six directions, mean": [100 * e.mean_of_mean(SIX) for e in errors],
        "harmonics, largest": [100 * e.of_mean(HARMONICS) for e in errors],
        "harmonics, mean": [100 * e.mean_of_mean(HARMONICS) for e in errors],
    }
    return dots(
        "Errors of two approximations for every sky",
        [_short(e.name) for e in errors],
        series,
        Axis("error of irradiance, % of the sky's mean irradiance", log=True),
        description="A line for every sky with the largest and the mean error of six directions "
        "and of spherical harmonics up to order two.",
    )


def _by_level(skies: Sequence[CubeMap], errors: Sequence[SkyErrors]) -> str:
    """Levels are counted from the top, since faces differ in size."""
    deepest = min(len(e.by_level) for e in errors)
    texels = 2.0 ** np.arange(deepest)
    table = 100 * np.array([e.by_level[::-1][:deepest] for e in errors])
    of_others = Line(
        f"median of {len(errors)} skies",
        texels,
        np.median(table, axis=0),
        band=(table.min(axis=0), table.max(axis=0)),
        markers=True,
    )
    own = Line(
        _short(skies[0].name),
        2.0 ** np.arange(len(errors[0].by_level)),
        100 * errors[0].by_level[::-1],
        markers=True,
    )
    return lines(
        "Mean error of six directions by the MIP level that they are looked up at",
        [of_others, own] if len(errors) > 1 else [own],
        Axis(
            "texels along a face's edge at the level looked up",
            log=True,
            ticks=[2.0**k for k in range(len(errors[0].by_level))],
        ),
        Axis("mean error, % of the sky's mean irradiance", log=True),
        description="From the mean of a whole face on the left to its middle texels on the right.",
    )


def _by_direction(errors: SkyErrors, shortcut: str) -> str:
    """Over the normals of `study.grid`."""
    values = 100 * errors.errors[shortcut].reshape(ROWS, 2 * ROWS)
    reach = max(float(np.ceil(np.abs(values).max())), _LEAST_SHOWN)
    return heat_map(
        f"Error of {shortcut} by the direction of the normal",
        values,
        Axis("azimuth of the normal, degrees", limits=(-180, 180), ticks=range(-180, 181, 45)),
        Axis("elevation, degrees", limits=(-90, 90), ticks=range(-90, 91, 45)),
        Axis("relative error of irradiance, %", limits=(-reach, reach)),
        description="Blue where it is too dark, red where it is too bright.",
    )


def _meridian(sky: CubeMap, normals: Floats, errors: SkyErrors) -> str:
    """Irradiance round the great circle through the zenith and the worst normal."""
    worst = normals[np.abs(errors.errors[SIX]).argmax()]
    across = worst * [1, 1, 0] if np.hypot(*worst[:2]) > 1e-6 else np.array([1.0, 0, 0])
    across /= np.linalg.norm(across)
    angle = np.linspace(-180, 180, 361)
    a = np.radians(angle)[:, np.newaxis]
    way = np.cos(a) * [0, 0, 1] + np.sin(a) * across
    true = sky_irradiance.irradiance(way, [sky_irradiance.radiance(sky)])[0]
    curves = {
        "whole sky": true,
        SIX: study.six_directions(way, sky.towards_axes()),
        "not normalised": study.six_directions(way, sky.towards_axes(), normalised=False),
        HARMONICS: study.harmonics(way, study.project(sky_irradiance.radiance(sky))),
    }
    return lines(
        "Irradiance on a surface that is turned all the way round",
        [
            Line(name, angle, values @ LUMINANCE / math.pi, dashed=name == HARMONICS)
            for name, values in curves.items()
        ],
        Axis("angle from the zenith, degrees", ticks=range(-180, 181, 45), limits=(-180, 180)),
        Axis("irradiance, as a share of that under a white sky"),
        description="One curve for the sum over the whole sky and one for each approximation. "
        "Those of six directions have kinks where the normal passes an axis.",
    )
