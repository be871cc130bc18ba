"""Characters: which are seen, how they stand, and one instanced draw for each of their materials.

Each tile of the shadow maps and the picture draw characters of their own choice, whose rows are
put into their figures' buffers just before.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import moderngl
import numpy as np
from numpy.typing import NDArray

from followspot.arrays import Mask
from followspot.assets.player import PARTS
from followspot.gpu import blocks, program
from followspot.gpu.characters import INSTANCE_FORMAT, POSE_ROW_BITS, VERTEX_FORMAT, GpuFigure
from followspot.gpu.gpu_scene import GpuScene
from followspot.gpu.program import ShaderFolder
from followspot.passes import drawlist, shadow_extent
from followspot.passes.materials import (
    Variant,
    set_caster_culling,
    set_state,
    set_uniforms,
    variant_of,
)
from followspot.passes.motion import Mover, mover_of
from followspot.passes.programs import BASE_IMAGE, KEY_POSES, LAYER_IMAGE, Shader, SurfacePrograms
from followspot.passes.shadow_extent import Extents
from followspot.passes.shadow_tiles import Tile
from followspot.scene.figure import Run
from followspot.scene.material import Material
from followspot.scene.settings import CullFace
from followspot.spaces import Mat4, Vec3

_POSED: dict[str, int | str] = {"POSED": 1, "POSE_ROW_BITS": POSE_ROW_BITS}

_INSTANCE = [f"in_{name}" for part in PARTS for name in (f"world_from_{part}", f"{part}_pose")]
"""Attributes in `INSTANCE_FORMAT`."""


class _Draw(NamedTuple):
    """What wears one material, or casts alike, of all characters of figure number `figure`."""

    figure: int
    run: Run
    variant: Variant
    image: moderngl.Texture
    layer: moderngl.Texture | None
    mover: Mover | None


class _Choice(NamedTuple):
    """Which of the rows are drawn: (n,) whether, and how many of each figure."""

    rows: Mask
    counts: list[int]

    @classmethod
    def of(cls, rows: Mask, figure_of: NDArray[np.intp], figures: int) -> "_Choice":
        return cls(rows, np.bincount(figure_of[rows], minlength=figures).tolist())


class CharacterPass:
    """All characters of a scene.

    Attributes:
        seen: Number of characters in the camera's view, after `update`.
    """

    def __init__(
        self, context: moderngl.Context, gpu_scene: GpuScene, folder: ShaderFolder
    ) -> None:
        self._context = context
        self._gpu_scene = gpu_scene
        self._crowd = gpu_scene.scene.crowd
        self._figures = gpu_scene.crowd.figures
        draws = [self._draw_of(k, r) for k, each in enumerate(self._figures) for r in each.runs]
        draws.sort(key=lambda draw: draw.run.material.order)
        self._opaque = [draw for draw in draws if draw.run.material.blend is None]
        self._blended = [draw for draw in draws if draw.run.material.blend is not None]
        self._casters = [
            self._draw_of(k, run)
            for k, each in enumerate(self._figures)
            for run in _casters(each.runs)
        ]
        variants = [draw.variant for draw in draws]
        self.programs = SurfacePrograms(context, folder, variants, self._arrays, _POSED)
        kinds = (_POSED, _POSED | {"ALPHA_TEST": 1}) if draws else ()
        self._shadows = [Shader(context, folder, "shadow", self._arrays, kind) for kind in kinds]
        self._updated: object = None
        self._cast: object = None
        self._rows: NDArray[Any] = np.zeros(0)
        self._light: NDArray[np.float32] | None = None
        self._picture = _Choice(np.zeros(0, bool), [0] * len(self._crowd.figures))
        self._casting: list[_Choice] = []
        self._uploaded: _Choice | None = None
        self._covering: list[Extents] = []
        self._seconds = 0.0
        self.seen = 0

    def _draw_of(self, figure: int, run: Run) -> _Draw:
        material, of = run.material, self._gpu_scene
        variant = variant_of(material, is_smoothed=False)
        mover = mover_of(material, variant, of)
        return _Draw(figure, run, variant, of.image_of(material), of.layer_of(material), mover)

    def _arrays(self, of: moderngl.Program) -> list[moderngl.VertexArray]:
        """A vertex array for each figure."""
        return [_array(self._context, of, each) for each in self._figures]

    def update(
        self,
        seconds: float,
        eye: Vec3,
        clip_from_world: Mat4,
        tiles: Sequence[Tile],
        may_be_seen: Mask | None,
    ) -> bool:
        """Choose the characters that matter and work out how they stand, if anything has changed.

        Args:
            seconds: The time.
            eye: (3,) from where the picture is taken, world units. Whoever stands there casts a
                shadow, but is not in the picture.
            clip_from_world: Of the camera that decides who is seen.
            tiles: Of the shadow maps.
            may_be_seen: (n,) which the level does not hide from the camera; none draws also those
                that cannot be seen.

        Returns:
            Whether they cast otherwise than after the last call.
        """
        if not self._figures:
            return False
        frusta = tuple((tile.frustum, tile.finer) for tile in tiles)
        viewpoint = eye.tobytes(), clip_from_world.tobytes()
        baked = self._gpu_scene.shown_baked
        wanted = (seconds, viewpoint, frusta, may_be_seen is None, baked)
        if wanted == self._updated:
            return False
        crowd, self._seconds = self._crowd, seconds
        places = crowd.places(seconds)

        def within(matrix: Mat4) -> Mask:
            planes = drawlist.frustum_planes(matrix)
            return drawlist.cubes_in_frustum(planes, places[:, :3], crowd.radius)

        seen = np.ones(len(crowd), bool)
        if may_be_seen is not None:
            seen = may_be_seen & within(clip_from_world)
        casting = np.zeros(len(crowd), bool)
        for tile in tiles:
            if not tile.is_near:
                casting |= within(tile.frustum.clip_from_world)
        depth = places[:, :3] @ clip_from_world[3, :3]  # near ones first: they hide others
        order = np.lexsort((depth, crowd.figure_of))
        order = order[(seen | casting)[order]]
        self._rows = crowd.instances(seconds, places, order)
        if baked is not None:
            self._light = baked.around(places[order, :3]).astype(np.float32)
        figure_of, figures = crowd.figure_of[order], len(crowd.figures)
        boxes = crowd.boxes(self._rows, order)
        holds_eye = ((boxes[0] < eye) & (eye < boxes[1])).all(axis=1)
        shown = seen[order] & ~holds_eye
        self.seen = int(shown.sum())
        self._picture = _Choice.of(shown, figure_of, figures)
        self._casting, self._covering = [], []
        found = finer = np.empty((0, 4))
        for tile in tiles:
            found = finer if tile.is_near else shadow_extent.extents(tile.frustum, *boxes)
            casts = casting[order] & shadow_extent.meets(found)
            if tile.finer is not None:  # the next one, in which alone some shadows are looked up
                scale, shift = tile.finer_from_here
                finer = (found.reshape(-1, 2, 2) * scale + shift).reshape(-1, 4)
                casts &= ~shadow_extent.within(finer, tile.seam)
            self._casting.append(_Choice.of(casts, figure_of, figures))
            self._covering.append(found[casts])
        self._uploaded = None
        self._updated = wanted
        cast = seconds, frusta
        if not tiles or cast == self._cast:  # without tiles, maps stay as they are
            return False
        self._cast = cast
        return True

    def covering(self, number: int) -> Extents:
        """Where in tile `number` those are that it draws."""
        return self._covering[number]

    def _upload(self, choice: "_Choice") -> None:
        """Put the rows of those that are drawn next into their figures' buffers."""
        if self._uploaded is not None and np.array_equal(choice.rows, self._uploaded.rows):
            return
        self._uploaded = choice
        rows = self._rows[choice.rows]
        light = None if self._light is None else self._light[choice.rows]
        start = 0
        for figure, count in zip(self._figures, choice.counts, strict=True):
            if count:
                figure.instances.write(rows[start : start + count])
                if light is not None:
                    figure.light.write(light[start : start + count])
                start += count

    def draw_opaque(self) -> None:
        """Draw solid and cut-out surfaces of those in view with depth test and writes."""
        self._context.enable_only(moderngl.DEPTH_TEST | moderngl.CULL_FACE)
        self._context.depth_func = "<"
        self._draw(self._opaque)

    def draw_blended(self) -> None:
        """Draw blended surfaces of those in view into what stands there, in no order."""
        self._context.enable_only(moderngl.DEPTH_TEST | moderngl.CULL_FACE | moderngl.BLEND)
        self._context.depth_func = "<="
        self._draw(self._blended)

    def _draw(self, draws: Sequence[_Draw]) -> None:
        self._upload(self._picture)
        state: object = None
        (chosen,) = self.programs.chosen.values()
        for draw in draws:
            count = self._picture.counts[draw.figure]
            if not count:
                continue
            material = draw.run.material
            if material.state != state:
                state = material.state
                set_state(self._context, material)
            draw.image.use(BASE_IMAGE)
            if draw.layer is not None:
                draw.layer.use(LAYER_IMAGE)
            shader = chosen[draw.variant]
            if draw.mover is not None:
                draw.mover.set(shader.program, self._seconds)
            self._render(draw, shader, count)
        self._context.polygon_offset = 0.0, 0.0

    def draw_casters(self, number: int, clip_from_world: Mat4, cull: CullFace) -> None:
        """Draw the depth of those that matter into a shadow map's tile, whose state is set.

        Args:
            number: Of the tile, among those of the last `update`.
            clip_from_world: The light's.
            cull: Which faces are left out.
        """
        matrix = blocks.column_major(clip_from_world)
        for shadow in self._shadows:
            program.set_uniform(shadow.program, "clip_from_world", matrix)
        choice = self._casting[number]
        self._upload(choice)
        sides: object = None
        for draw in self._casters:
            count = choice.counts[draw.figure]
            if not count:
                continue
            if draw.run.material.sides is not sides:
                sides = draw.run.material.sides
                set_caster_culling(self._context, draw.run.material, cull)
            if draw.variant.cut_out:
                draw.image.use(BASE_IMAGE)
            self._render(draw, self._shadows[draw.variant.cut_out], count)

    def _render(self, draw: _Draw, shader: Shader, count: int) -> None:
        if draw.variant.cut_out or draw.variant.blended:
            set_uniforms(shader.program, draw.run.material)
        self._figures[draw.figure].key_poses.use(KEY_POSES)
        array = shader.arrays[draw.figure]
        array.render(vertices=draw.run.count, first=draw.run.first, instances=count)

    @property
    def shaders(self) -> list[Shader]:
        """All that have been compiled."""
        return [*self.programs.shaders, *self._shadows]

    def counts(self, *, with_blended: bool) -> tuple[int, int]:
        """Draw calls and triangles that those in view take."""
        draws = [*self._opaque, *(self._blended if with_blended else ())]
        instances = [self._picture.counts[draw.figure] for draw in draws]
        triangles = (n * d.run.count // 3 for n, d in zip(instances, draws, strict=True))
        return sum(n > 0 for n in instances), sum(triangles)

    def release(self) -> None:
        """Give the GL objects back."""
        self.programs.release()
        for shadow in self._shadows:
            shadow.release()


def _array(
    context: moderngl.Context, of: moderngl.Program, each: GpuFigure
) -> moderngl.VertexArray:
    """A figure's vertex array for a program, which may not look at texture coordinates."""
    vertices = each.vertices, VERTEX_FORMAT, "in_texcoord", "in_vertex"
    instances = each.instances, INSTANCE_FORMAT, *_INSTANCE
    content: list[tuple[Any, ...]] = [vertices, instances, (each.light, "3f/i", "in_baked")]
    return context.vertex_array(of, content, each.indices, skip_errors=True)


def _casters(runs: Sequence[Run]) -> list[Run]:
    """What casts a shadow; solid neighbours of one state as one run."""
    casters: list[Run] = []
    for run in runs:
        if run.material.blend is not None:
            continue
        last = casters[-1] if casters else None
        if last is not None and _alike(last.material, run.material):
            casters[-1] = Run(last.material, last.first, last.count + run.count)
        else:
            casters.append(run)
    return casters


def _alike(a: Material, b: Material) -> bool:
    return a.alpha_test is None and b.alpha_test is None and a.sides is b.sides
