"""What of a material is told to GL before its draws: what follows time, and layers' colours."""

import struct
from collections.abc import Iterator
from itertools import chain

import moderngl

from followspot.gpu import program
from followspot.gpu.gpu_scene import GpuScene
from followspot.passes.materials import Variant
from followspot.passes.programs import BASE_IMAGE, LAYER_IMAGE
from followspot.scene.material import Material
from followspot.scene.motion import Motion

_PAIR, _TRIPLE, _QUADRUPLE = (struct.Struct(f"{count}f") for count in (2, 3, 4))
_AFFINE, _SWAY = struct.Struct("6f"), struct.Struct("8f")


def mover_of(material: Material, variant: Variant, gpu_scene: GpuScene) -> "Mover | None":
    """A material's, if it has anything to be told."""
    is_colored = variant.layer is not None and variant.layer.colored
    needed = material.moves or is_colored
    return Mover(material, variant, gpu_scene) if needed else None


class Mover:
    """One material's.

    Args:
        material: What is drawn.
        variant: What it is drawn by.
        gpu_scene: Has its images.
    """

    def __init__(self, material: Material, variant: Variant, gpu_scene: GpuScene) -> None:
        self._material, self._variant = material, variant
        frames = [(BASE_IMAGE, material.motion, gpu_scene.frames_of(material))]
        if material.layer is not None:
            of_layer = gpu_scene.layer_frames_of(material.layer)
            frames.append((LAYER_IMAGE, material.layer.motion, of_layer))
        self._animated = [each for each in frames if each[2]]
        self._seconds: float | None = None
        self._values: list[tuple[str, bytes]] = []

    def set(self, to: moderngl.Program, seconds: float) -> None:
        """Bind images and set uniforms of a program for what is drawn next."""
        if seconds != self._seconds:
            self._seconds, self._values = seconds, list(self._uniforms(seconds))
        for unit, motion, textures in self._animated:
            textures[motion.frame(seconds)].use(unit)
        for name, value in self._values:
            program.set_uniform(to, name, value)

    def _uniforms(self, seconds: float) -> Iterator[tuple[str, bytes]]:
        """Names and values at a time."""
        of, variant = self._material, self._variant
        if variant.moves:
            yield from _coordinates("base", of.motion, seconds)
        if of.layer is not None and variant.layer is not None:
            if variant.layer.moves:
                yield from _coordinates("layer", of.layer.motion, seconds)
            if variant.layer.colored:
                yield "layer_color", _TRIPLE.pack(*of.layer.color_at(seconds))
        if variant.pulses:
            yield "pulse", _PAIR.pack(*of.motion.pulse(seconds))
        if variant.displaced:
            yield "displaced", _TRIPLE.pack(*of.deforms.moved(seconds))
        if variant.swells:
            yield "swell", _QUADRUPLE.pack(*of.deforms.swelling(seconds))


def _coordinates(name: str, motion: Motion, seconds: float) -> Iterator[tuple[str, bytes]]:
    """Pairs as the columns of matrices of two rows."""
    terms = motion.terms(seconds)
    yield f"{name}_moved", _AFFINE.pack(*chain.from_iterable(terms[:3]))
    if motion.is_turbulent:
        yield f"{name}_swayed", _SWAY.pack(*chain.from_iterable(terms[3:]))
