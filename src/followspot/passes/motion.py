"""What of a material follows the time, told to GL before its draws."""

import struct
from itertools import chain

import moderngl

from followspot.gpu import program
from followspot.gpu.gpu_scene import GpuScene
from followspot.passes.materials import Variant
from followspot.passes.programs import BASE_IMAGE, LAYER_IMAGE
from followspot.scene.material import Material
from followspot.scene.motion import Motion, Terms

_AFFINE, _SWAY = struct.Struct("6f"), struct.Struct("8f")


class Mover:
    """One material's, of those that move.

    Args:
        material: What is drawn.
        variant: What it is drawn by.
        gpu_scene: Has its images.
    """

    def __init__(self, material: Material, variant: Variant, gpu_scene: GpuScene) -> None:
        base, layer = material.motion, material.layer_motion
        self._motion, self._deforms, self._variant = base, material.deforms, variant
        frames = (
            (BASE_IMAGE, base, gpu_scene.frames_of(material)),
            (LAYER_IMAGE, layer, gpu_scene.layer_frames_of(material)),
        )
        self._animated = [each for each in frames if each[2]]
        moved: list[tuple[str, Motion, bool]] = []
        if variant.moves:
            moved.append(("base", base, variant.sways))
        if variant.layer_apart:
            moved.append(("layer", layer, variant.layer_sways))
        self._moved = moved

    def set(self, to: moderngl.Program, seconds: float) -> None:
        """Bind images and set uniforms of a program for what is drawn next."""
        for unit, motion, textures in self._animated:
            textures[motion.frame(seconds)].use(unit)
        for name, motion, sways in self._moved:
            terms = motion.terms(seconds)
            program.set_uniform(to, f"{name}_moved", _packed(_AFFINE, terms[:3]))
            if sways:
                program.set_uniform(to, f"{name}_swayed", _packed(_SWAY, terms[3:]))
        if self._variant.pulses:
            program.set_uniform(to, "pulse", self._motion.pulse(seconds))
        if self._variant.displaced:
            program.set_uniform(to, "displaced", self._deforms.moved(seconds))
        if self._variant.swells:
            program.set_uniform(to, "swell", self._deforms.swelling(seconds))


def _packed(columns: struct.Struct, terms: Terms) -> bytes:
    """Pairs as the columns of a matrix of two rows."""
    return columns.pack(*chain.from_iterable(terms))
