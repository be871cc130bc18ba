"""The shadow pass: depth from every shadow-casting light into its tile of one atlas.

The map of a light is kept until the light, the window that it covers, or a setting changes. The
window stays the same while the camera moves a little. Where there are characters, the level's
depth is kept by itself: when they move, it is put back where they were, and they are drawn over it.
"""

from collections.abc import Iterator
from contextlib import contextmanager

import moderngl
import numpy as np
from numpy.typing import NDArray

from followspot.errors import UsageError
from followspot.gpu import blocks, gl, program
from followspot.gpu.gpu_scene import GpuScene
from followspot.gpu.program import ShaderFolder
from followspot.gpu.targets import Part
from followspot.passes import shadow_fit
from followspot.passes.characters import CharacterPass
from followspot.passes.drawlist import DrawList
from followspot.passes.materials import alpha_test_vector, set_caster_culling
from followspot.passes.programs import BASE_IMAGE, Shader
from followspot.passes.shadow_fit import Boxes, Extent, ShadowFrustum
from followspot.passes.shadow_tiles import ShadowTiles
from followspot.scene.light import SpotLight
from followspot.scene.settings import CullFace, Settings
from followspot.spaces import Mat4


class ShadowPass:
    """The atlas, the two programs that fill it, and what is in it now.

    Attributes:
        redrawn: Whether the last call drew the level.
        version: Another number whenever something has been drawn.
        triangle_count: The level's triangles in the atlas.
        draw_count: Draw calls that it took.
    """

    def __init__(
        self,
        context: moderngl.Context,
        gpu_scene: GpuScene,
        characters: CharacterPass,
        folder: ShaderFolder,
    ) -> None:
        self._context = context
        self._gpu_scene = gpu_scene
        self._characters = characters
        size = max(gpu_scene.scene.mesh.indices.nbytes, 4) * blocks.MAX_SHADOWS
        self._indices = context.buffer(reserve=size, dynamic=True)  # all lights' casters
        self._solid = Shader(context, folder, "shadow", self._array)
        self._cut_out = Shader(context, folder, "shadow", self._array, {"ALPHA_TEST": 1})
        self._restore = Shader(context, folder, "restore", self._no_array, vertex="average")
        self.shaders = [self._solid, self._cut_out, self._restore]
        self._tiles = ShadowTiles(gpu_scene.scene)
        self._drawn: object = None
        self._maps: list[_Map] = []  # with characters the level's alone, then the one with theirs
        self._covered: list[Extent] = []  # by them, of each tile of it
        self.redrawn = False
        self.version = 0
        self.triangle_count = self.draw_count = 0

    def _array(self, shadow: moderngl.Program) -> list[moderngl.VertexArray]:
        """The level's one vertex array for a program."""
        content = [(self._gpu_scene.vertices, "3f 12x 2f", "in_position", "in_texcoord")]
        return [self._context.vertex_array(shadow, content, self._indices, skip_errors=True)]

    def _no_array(self, shadow: moderngl.Program) -> list[moderngl.VertexArray]:
        """For what is drawn over the whole map."""
        return [self._context.vertex_array(shadow, [])]

    def reserve(self, light_count: int, size: int) -> None:
        """Make room for so many tiles of so many texels. Not to be called inside a frame."""
        wanted = (size * max(light_count, 1), size)
        if self._maps and (self.atlas.size == wanted or light_count == 0):
            return
        limit = self._context.info["GL_MAX_TEXTURE_SIZE"]
        if wanted[0] > limit:
            raise UsageError(
                f"shadow_map_size: {light_count} lights with maps of {size} texels need "
                f"{wanted[0]} in a row; this OpenGL has {limit}"
            )
        self._drop_maps()
        self._maps = [_Map(self._context, wanted)]
        if len(self._gpu_scene.scene.crowd):
            self._maps[0].texture.compare_func = ""  # what it holds is fetched, to be put back
            self._maps.append(_Map(self._context, wanted))
        self._drawn = None

    @property
    def tiles(self) -> tuple[ShadowFrustum, ...]:
        """What the atlas covers, a frustum a light, in the lights' order."""
        return self._tiles.frusta

    @property
    def atlas(self) -> moderngl.Texture:
        """Depth texture, one square tile a light, side by side; compared by the fetch."""
        return self._maps[-1].texture

    def fit(
        self, lights: tuple[SpotLight, ...], settings: Settings, receivers: Boxes | None
    ) -> NDArray[np.float32]:
        """Choose what the lights' maps cover.

        Args:
            lights: Those with a shadow map, at most as many as reserved.
            settings: Of them the shadow settings are read.
            receivers: Boxes of what the camera sees, the same object while they are the same;
                none covers the lights' whole cones.

        Returns:
            (lights, 4, 4) ``shadow_from_world`` into the atlas, column-major.
        """
        if not lights:
            return np.empty((0, 4, 4), np.float32)
        if self._tiles.fit(lights, settings, receivers if settings.shadow_fit else None):
            indices = [casters.indices for casters in self._tiles.casters]
            self._indices.write(np.concatenate(indices))
        return np.array(
            [blocks.columns(self.shadow_from_world(number)) for number in range(len(lights))],
            np.float32,
        )

    def draw(self, settings: Settings, *, is_used: bool, characters_moved: bool) -> None:
        """Bring the atlas up to date for what was fitted last.

        Args:
            settings: As for `fit`.
            is_used: Whether there were lights to fit.
            characters_moved: Whether they stand elsewhere, or otherwise, than at the last call.
        """
        wanted = (self.tiles, settings.shadow_slope_bias)
        self.redrawn = is_used and (settings.redraw_shadows or wanted != self._drawn)
        if self.redrawn:
            with self._drawing_into(self._maps[0], settings):
                self._draw_level(settings)
            self._drawn = wanted
        has_moved = is_used and len(self._maps) > 1 and characters_moved
        if self.redrawn or has_moved:
            self.version += 1
            if len(self._maps) > 1:
                self._draw_characters(settings)

    def _draw_characters(self, settings: Settings) -> None:
        """Put the level's depth back where characters have been or will be; draw them over it."""
        level, sampled = self._maps
        before = [shadow_fit.WHOLE] * len(self.tiles) if self.redrawn else self._covered
        mins, maxs = self._characters.casting_boxes
        self._covered = [shadow_fit.covered(tile, mins, maxs) for tile in self.tiles]
        with self._drawing_into(sampled, settings):
            for number, tile in enumerate(self.tiles):
                part = shadow_fit.union(before[number], self._covered[number])
                sampled.choose_tile(number, settings.shadow_map_size, part)
                self._context.disable(moderngl.CULL_FACE)
                self._context.depth_func = "1"
                level.texture.use(BASE_IMAGE)
                self._restore.arrays[0].render(vertices=3)
                self._context.depth_func = "<"
                self._characters.draw_casters(tile.clip_from_world, settings.shadow_cull)

    def shadow_from_world(self, number: int) -> Mat4:
        """World to tile `number` of the atlas."""
        return self._tiles.shadow_from_world(number)

    @contextmanager
    def _drawing_into(self, target: "_Map", settings: Settings) -> Iterator[None]:
        """Bind a map and set what casters of all kinds are drawn with."""
        context = self._context
        target.framebuffer.use()
        context.enable_only(moderngl.DEPTH_TEST)
        context.enable_direct(gl.DEPTH_CLAMP)  # what is before the near plane casts all the same
        context.depth_func = "<"
        context.polygon_offset = settings.shadow_slope_bias, 0.0
        yield
        context.polygon_offset = 0.0, 0.0
        context.disable_direct(gl.DEPTH_CLAMP)

    def _draw_level(self, settings: Settings) -> None:
        target, size = self._maps[0], settings.shadow_map_size
        self.triangle_count = self.draw_count = 0
        target.framebuffer.scissor = None  # type: ignore[assignment]  # moderngl: nothing cut off
        target.framebuffer.clear()
        base = 0
        for number, (tile, casters) in enumerate(zip(self.tiles, self._tiles.casters, strict=True)):
            target.choose_tile(number, size)
            matrix = blocks.columns(tile.clip_from_world)
            for shader in (self._solid, self._cut_out):
                program.set_uniform(shader.program, "clip_from_world", matrix)
            self._draw_casters(casters, base, settings.shadow_cull)
            base += len(casters.indices)

    def _draw_casters(self, casters: DrawList, base: int, cull: CullFace) -> None:
        for batch in casters.batches:
            material = self._gpu_scene.scene.materials[batch.material]
            set_caster_culling(self._context, material, cull)
            if material.alpha_test is None:
                shader = self._solid
            else:
                shader = self._cut_out
                program.set_uniform(shader.program, "alpha_test", alpha_test_vector(material))
                self._gpu_scene.image_of(material).use(BASE_IMAGE)
            shader.arrays[0].render(vertices=batch.count, first=base + batch.first)
        self.triangle_count += casters.triangle_count
        self.draw_count += len(casters.batches)

    def read_distance(self, number: int, size: int) -> NDArray[np.float32]:
        """(size, size) distances along light `number`'s axis in units, top row first.

        Infinite where the light's rays hit nothing.
        """
        depths = self.read_depths(number, (0, 0, size, size), size)
        return self.tiles[number].distances(depths).astype(np.float32)

    def read_depths(self, number: int, part: Part, size: int) -> NDArray[np.float32]:
        """Read a part of light `number`'s map of `size` texels; waits for the GPU.

        Returns:
            (h, w) depths in [0, 1], top row first.
        """
        x, y, width, height = part
        box = number * size + x, size - y - height, width, height
        self._context.finish()  # Mesa's llvmpipe may not wait for what is still being drawn
        raw = self._maps[-1].framebuffer.read(box, components=1, attachment=-1, dtype="f4")
        return np.frombuffer(raw, "<f4").reshape(height, width)[::-1]

    def release(self) -> None:
        """Give the GL objects back."""
        self._drop_maps()
        self._indices.release()
        for shader in self.shaders:
            shader.release()

    def _drop_maps(self) -> None:
        for each in self._maps:
            each.release()
        self._maps = []


class _Map:
    """A depth texture to draw into and to sample."""

    def __init__(self, context: moderngl.Context, size: tuple[int, int]) -> None:
        self.texture = context.depth_texture(size)
        self.texture.compare_func = "<="
        self.texture.filter = moderngl.LINEAR, moderngl.LINEAR
        self.texture.repeat_x = self.texture.repeat_y = False
        self.framebuffer = context.framebuffer(depth_attachment=self.texture)

    def choose_tile(self, number: int, size: int, part: Extent = shadow_fit.WHOLE) -> None:
        """Draw into one light's square from now on, or into the texels that hold a part of it."""
        x, y = int(part.left * size), int(part.bottom * size)
        width = max(0, min(int(part.right * size) + 1, size) - x)
        height = max(0, min(int(part.top * size) + 1, size) - y)
        self.framebuffer.viewport = number * size, 0, size, size
        self.framebuffer.scissor = number * size + x, y, width, height
        self.framebuffer.use()

    def release(self) -> None:
        """Give the GL objects back."""
        self.framebuffer.release()
        self.texture.release()
