"""Shadow maps of three cullings and many biases, held against rays.

A *false shadow* is where the map says dark (by more than half) and the ray to the light's centre
meets nothing, *false light* the other way round. Both are counted at the middles of a picture's
pixels on surfaces that face the light within its cone; `bias_samples` has the rays' part.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import msgspec
import numpy as np

from followspot.arrays import Floats, Mask
from followspot.passes.view import View
from followspot.present.renderer import Renderer
from followspot.present.report import bias_samples
from followspot.present.report.bias_samples import Samples
from followspot.present.report.visibility import Rays, fitted
from followspot.scene.camera import Camera
from followspot.scene.character import Crowd
from followspot.scene.light import SpotLight, casting
from followspot.scene.scene import Scene
from followspot.scene.settings import CullFace, Settings

PIXELS = 112 * 84
"""Of the pictures that are compared, about: tracing their rays is what takes time."""

OFFSETS = (-3.0, -2.0, -1.5, -1.0, -0.7, -0.5, -0.3, -0.2, -0.1, 0.0,
           0.1, 0.2, 0.3, 0.4, 0.5, 0.7, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0)  # fmt: skip
"""Texels by which receivers are moved along their normals."""

LABELS = {
    CullFace.FRONT: "without front faces",
    CullFace.BACK: "without back faces",
    CullFace.NONE: "with all faces",
}
"""What maps are by their culling, in words."""

NO_ACNE = 1e-3
"""Share of the samples up to which acne is not seen."""

CONTACT = 4.0
"""Texels from what casts a shadow on them up to which places count as touching it."""


@dataclass(frozen=True, eq=False)
class Rates:
    """What one culling does over OFFSETS, as shares of all samples; (offsets,) of each.

    Attributes:
        false_shadow: Dark and should not be.
        false_light: Lit and should not be.
        acne: Of the false shadow, what is neither near an edge nor a matter of leaves.
        leak: Of the false light, likewise.
        sheets: Of the false shadow, what lies on two-sided surfaces.
        contact: Of the false light, what is nearer than CONTACT to what should shade it.
    """

    false_shadow: Floats
    false_light: Floats
    acne: Floats
    leak: Floats
    sheets: Floats
    contact: Floats

    @property
    def wrong(self) -> Floats:
        """False shadow and false light together."""
        return self.false_shadow + self.false_light

    @property
    def least(self) -> float:
        """The smallest of OFFSETS from which on, up to one texel, there is no acne to speak of."""
        usual = np.flatnonzero(np.array(OFFSETS) <= 1)
        bad = usual[self.acne[usual] > NO_ACNE]
        number = int(bad[-1]) + 1 if len(bad) else 0
        return OFFSETS[number] if number < len(usual) else math.nan


@dataclass(frozen=True, eq=False)
class BiasStudy:
    """Everything that is told.

    Attributes:
        light: Whose shadows they are.
        settings: All but the culling and the biases.
        samples: What rays say.
        rates: By culling, over OFFSETS.
        chosen: Of the scene's own settings, at one offset: its culling, its biases.
        pictures: By culling at offset 0, and of the scene's own settings under None: (h, w, 3)
            bytes, false light red, false shadow blue.
        away: Share of the lit half-space that is left out: smooth normals face the light there
            and their triangles do not.
    """

    light: SpotLight
    settings: Settings
    samples: Samples
    rates: dict[CullFace, Rates]
    chosen: Rates
    pictures: dict[CullFace | None, np.ndarray]
    away: float

    def without_map(self, culling: CullFace) -> tuple[float, float]:
        """(false light, false shadow) as shares of all samples, were a map's texels endless."""
        samples = self.samples
        kept = {
            CullFace.FRONT: samples.exits,
            CullFace.BACK: samples.entries,
            CullFace.NONE: samples.entries + samples.exits,
        }[culling]
        dark = kept + samples.sheets > 0
        return float((~samples.lit & ~dark).mean()), float((samples.lit & dark).mean())


Progress = Callable[[float, str], None]


def study(
    scene: Scene, camera: Camera, shape: tuple[int, int], on_progress: Progress
) -> BiasStudy | None:
    """Compare; none where no light casts a shadow on what is seen.

    Args:
        scene: Of its lights the first that casts a shadow is looked at; characters are left out.
        camera: Where the picture is taken from.
        shape: (width, height) of which pictures have the proportions.
        on_progress: Called with the share that is done and what is next.
    """
    light = next(iter(casting(scene.lights)), None)
    if light is None:
        return None
    settings = msgspec.structs.replace(scene.settings, shadows=True)
    on_progress(0.0, "tracing what the camera sees")
    scene = replace(scene.with_lights(light), crowd=Crowd())  # rays do not meet characters
    rays = Rays(scene)
    edge = math.sqrt(PIXELS / (shape[0] * shape[1]))
    size = max(1, round(shape[0] * edge)), max(1, round(shape[1] * edge))
    tiles = fitted(scene, camera, size, light, settings)
    seen = rays.seen_by(camera, size, camera.far_for(*scene.bounds))
    with Renderer(size) as renderer:
        depth = _drawn(renderer, scene, camera, View.DEPTH, settings)[seen.pixel]
        grey = renderer.render(scene, camera, [View.SHADING], settings=settings)[View.SHADING]
        places, away = bias_samples.facing(seen, light, depth)
        if len(places) == 0:
            return None
        on_progress(0.2, "tracing what the light sees")
        samples = bias_samples.take(rays, places, light, tiles, settings)

        def look(culling: CullFace, bias: float, offset: float, slope: float) -> Mask:
            changed = msgspec.structs.replace(
                settings,
                shadow_cull=culling,
                shadow_bias=bias,
                shadow_normal_offset=offset,
                shadow_slope_bias=slope,
            )
            share = _drawn(renderer, scene, camera, View.SHADOW, changed)
            return np.asarray(share[samples.places.pixel] >= 0.5)

        said = {}
        for number, culling in enumerate(CullFace):
            on_progress(0.7 + 0.1 * number, f"shadow maps {LABELS[culling]}")
            said[culling] = np.array([look(culling, 0.0, offset, 0.0) for offset in OFFSETS])
        own = look(
            settings.shadow_cull,
            settings.shadow_bias,
            settings.shadow_normal_offset,
            settings.shadow_slope_bias,
        )
    pictures: dict[CullFace | None, np.ndarray] = {
        culling: _marked(grey, samples, said[culling][OFFSETS.index(0.0)]) for culling in CullFace
    }
    pictures[None] = _marked(grey, samples, own)
    return BiasStudy(
        light,
        settings,
        samples,
        {culling: _rates(samples, lit) for culling, lit in said.items()},
        _rates(samples, own[np.newaxis]),
        pictures,
        away,
    )


def _drawn(
    renderer: Renderer, scene: Scene, camera: Camera, view: View, settings: Settings
) -> Floats:
    """(pixels,) values of a view."""
    drawn = renderer.render(scene, camera, [view], settings=settings, linear=True)[view]
    return np.asarray(drawn.ravel().astype(np.float64))


def _rates(samples: Samples, said_lit: Mask) -> Rates:
    """Of what maps say, (offsets, n)."""
    shadow, light = samples.lit & ~said_lit, ~samples.lit & said_lit
    plain = samples.plain
    return Rates(
        shadow.mean(axis=1),
        light.mean(axis=1),
        (shadow & plain).mean(axis=1),
        (light & plain).mean(axis=1),
        (shadow & samples.places.two_sided).mean(axis=1),
        (light & (samples.gap < CONTACT * samples.texel)).mean(axis=1),
    )


def _marked(picture: np.ndarray, samples: Samples, said_lit: Mask) -> np.ndarray:
    """False light red and false shadow blue over a grey picture, (h, w, 3) bytes."""
    grey = (picture.mean(axis=2, keepdims=True) * 0.8).astype(np.uint8)
    marked = np.repeat(grey, 3, axis=2).reshape(-1, 3)
    pixel = samples.places.pixel
    marked[pixel[~samples.lit & said_lit]] = 235, 40, 30
    marked[pixel[samples.lit & ~said_lit]] = 40, 110, 255
    return marked.reshape(picture.shape)
