"""The shadow pass: depth from every shadow-casting light into its tiles of one atlas.

A tile is kept until its light, the window that it covers, or a setting changes. The window stays
the same while the camera moves a little. Where there are characters, the level's depth is kept by
itself: when they move, it is put back where they were, and they are drawn over it anew.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import moderngl
import numpy as np
from numpy.typing import NDArray

from followspot.errors import UsageError
from followspot.gpu import blocks, gl, program
from followspot.gpu.gpu_scene import GpuScene
from followspot.gpu.program import ShaderFolder
from followspot.gpu.targets import Part
from followspot.passes import shadow_extent, shadow_tiles
from followspot.passes.characters import CharacterPass
from followspot.passes.drawlist import DrawList
from followspot.passes.materials import alpha_test_vector, set_caster_culling
from followspot.passes.programs import BASE_IMAGE, Shader
from followspot.passes.shadow_extent import Extents
from followspot.passes.shadow_fit import Receivers
from followspot.passes.shadow_map import ShadowMap
from followspot.passes.shadow_tiles import Place, ShadowTiles, Tile
from followspot.scene.light import SpotLight
from followspot.scene.settings import CullFace, Settings


class ShadowPass:
    """The atlas, the programs that fill it, and what is in it now.

    Attributes:
        layout: Where its tiles are in it, and what casts into them.
        redrawn: Whether the last call drew the level into any tile.
        version: Counts up whenever anything is drawn into the atlas.
        triangle_count: The level's triangles that were drawn last.
        draw_count: Draw calls that it took.
        size: Texels along a tile's edge.
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
        self._flush = gl.flush_function(context)
        self._indices = context.buffer(reserve=4, dynamic=True)  # all tiles' casters
        self._solid = Shader(context, folder, "shadow", self._array)
        self._cut_out = Shader(context, folder, "shadow", self._array, {"ALPHA_TEST": 1})
        most = max(len(gpu_scene.scene.crowd), 1)  # where all were; or a whole tile
        self._rectangles = context.buffer(reserve=most * 16, dynamic=True)
        self._restore = Shader(context, folder, "restore", self._rectangle_array)
        self.shaders = [self._solid, self._cut_out, self._restore]
        self.layout = ShadowTiles(gpu_scene.scene)
        self._placed: object = None
        self._placing: list[tuple[str, Any, Any]] = []
        self._drawn: dict[Place, object] = {}  # what is in the level's tiles
        # With characters two: the level's alone, then the one with theirs.
        self._maps: list[ShadowMap] = []
        self._covered: dict[Place, Extents] = {}  # by them
        self.redrawn = False
        self.version = 0
        self.triangle_count = self.draw_count = self.size = 0

    def _array(self, shadow: moderngl.Program) -> list[moderngl.VertexArray]:
        """The level's one vertex array for a program."""
        content = [(self._gpu_scene.vertices, "3f 12x 2f", "in_position", "in_texcoord")]
        return [self._context.vertex_array(shadow, content, self._indices, skip_errors=True)]

    def _rectangle_array(self, restore: moderngl.Program) -> list[moderngl.VertexArray]:
        content = [(self._rectangles, "4f/i", "in_corners")]
        return [self._context.vertex_array(restore, content)]

    def reserve(self, lights: tuple[SpotLight, ...], settings: Settings) -> None:
        """Make room for lights' maps. Not to be called inside a frame."""
        size = shadow_tiles.tile_size(settings)
        columns, rows = shadow_tiles.shape(lights, settings)
        wanted = columns * size, max(rows, 1) * size
        is_alike = self._maps and (self.size, self.atlas.size) == (size, wanted)
        if is_alike or (self._maps and not lights):
            return
        limit = self._context.info["GL_MAX_TEXTURE_SIZE"]
        if max(wanted) > limit:
            raise UsageError(
                f"shadow_map_size: {len(lights)} maps, six of a point light, of "
                f"{settings.shadow_map_size} texels need an atlas of {wanted[0]} x {wanted[1]}; "
                f"this OpenGL has {limit}, enough for maps of "
                f"{shadow_tiles.map_size(limit // max(columns, rows), settings)}"
            )
        self.size = size
        most = columns * max(rows, 1) * self._gpu_scene.scene.mesh.indices.nbytes
        self._indices.orphan(max(most, 4))  # and what was in it is lost
        self.layout.forget()
        self._drop_maps()
        self._maps = [ShadowMap(self._context, wanted, size)]
        if len(self._gpu_scene.scene.crowd):
            self._maps[0].texture.compare_func = ""  # what it holds is fetched, to be put back
            self._maps.append(ShadowMap(self._context, wanted, size))
        self._drawn = {}

    @property
    def tiles(self) -> tuple[Tile, ...]:
        """What the atlas holds: the first light's wide tile, its near one if any, and so on."""
        return self.layout.tiles

    def tiles_of(self, number: int) -> tuple[Tile, ...]:
        """Those of light `number`; none if it has no shadow map."""
        return tuple(tile for tile in self.tiles if tile.light == number)

    @property
    def map(self) -> ShadowMap:
        """What is sampled: the level's depth and characters'."""
        return self._maps[-1]

    @property
    def atlas(self) -> moderngl.Texture:
        """Its depth texture, compared by the fetch."""
        return self.map.texture

    def fit(self, lights: tuple[SpotLight, ...], settings: Settings, receivers: Receivers) -> None:
        """Choose what the lights' tiles cover.

        Args:
            lights: Those with a shadow map, for which there is room.
            settings: Of them the shadow settings are read.
            receivers: What the camera sees, the same object while it is the same.
        """
        if lights and self.layout.fit(lights, settings, receivers if settings.shadow_fit else None):
            self._indices.write(np.concatenate([tile.casters.indices for tile in self.tiles]))

    def write_tiles(self, block: NDArray[np.void], settings: Settings) -> None:
        """Fill in where a frame block's lights have their tiles.

        Args:
            block: One of `blocks.FRAME`.
            settings: As for `fit`.
        """
        wanted = self.tiles, self.atlas.size, settings.shadow_normal_offset
        if wanted != self._placed:
            self._placed = wanted
            spots = shadow_tiles.spot_count(self.layout.lights)
            wide = [tile for tile in self.tiles if tile.light < spots and not tile.is_near]
            self._placing = [value for tile in wide for value in self._values(tile, settings)]
        for name, index, value in self._placing:
            block[name][index] = value

    def _values(self, tile: Tile, settings: Settings) -> list[tuple[str, Any, Any]]:
        """What a spot's surfaces are looked up by, from its wide tile: field, index, value."""
        number = tile.light
        (right, up), deeper = self.layout.offsets(tile, settings.shadow_normal_offset, self.size)
        into_wide = blocks.column_major(self.layout.atlas_from_world(tile))
        return [
            ("shadow_from_world", number, into_wide),
            ("near_from_wide", number, self.layout.near_from_wide()[number]),
            ("offset_right", number, right),
            ("offset_up", number, up),
            ("light_position", (number, 3), deeper),
        ]

    def draw(self, settings: Settings, *, is_used: bool, characters_moved: bool) -> None:
        """Bring the atlas up to date for what was fitted last.

        Args:
            settings: As for `fit`.
            is_used: Whether there were lights to fit.
            characters_moved: Whether they stand elsewhere, or otherwise, than at the last call.
        """
        tiles = self.tiles if is_used else ()
        now: dict[Place, object] = {
            tile.place: (tile.frustum, tile.casters, settings.shadow_slope_bias) for tile in tiles
        }
        anew = {
            box
            for box, wanted in now.items()
            if settings.redraw_shadows or wanted != self._drawn.get(box)
        }
        self.redrawn = bool(anew)
        if self.redrawn:
            with self._drawing_into(self._maps[0], settings):
                self._draw_level(settings, anew)
            self._drawn = now
        if len(self._maps) > 1 and tiles:
            characters_moved |= not self._covered  # never drawn, or not to the end
            if self.redrawn or characters_moved:
                self._draw_characters(settings, anew)
        if tiles and (self.redrawn or characters_moved):
            self.version += 1

    def forget(self) -> None:
        """Draw every tile anew in the next frame, whatever is in it now."""
        self._drawn = {}

    def _draw_characters(self, settings: Settings, anew: set[Place]) -> None:
        """Put the level's depth back where characters were; draw them where they are."""
        level, sampled = self._maps
        before, self._covered = self._covered, {}  # and so it stays if this is interrupted
        covered = {
            tile.place: self._characters.covering(number) for number, tile in enumerate(self.tiles)
        }
        with self._drawing_into(sampled, settings):
            for place in covered:
                sampled.choose(place)
                is_kept = place in before and place not in anew
                self._put_back(level, before[place] if is_kept else shadow_extent.WHOLE)
            for number, tile in enumerate(self.tiles):
                sampled.choose(tile.place)
                self._characters.draw_casters(
                    number, tile.frustum.clip_from_world, settings.shadow_cull
                )
                self._flush()  # a software rasteriser draws while the next ones are set up
        self._covered = covered

    def _put_back(self, level: ShadowMap, touched: Extents) -> None:
        """The level's depth in some rectangles of the tile that is drawn into."""
        rectangles = shadow_extent.texels(touched, self.size)
        if not len(rectangles):
            return
        self._rectangles.write(rectangles)
        self._context.disable(moderngl.CULL_FACE)
        self._context.depth_func = "1"
        level.texture.use(BASE_IMAGE)
        self._restore.arrays[0].render(
            moderngl.TRIANGLE_STRIP, vertices=4, instances=len(rectangles)
        )
        self._context.depth_func = "<"

    @contextmanager
    def _drawing_into(self, target: ShadowMap, settings: Settings) -> Iterator[None]:
        """Bind a map and set what casters of all kinds are drawn with."""
        context = self._context
        target.framebuffer.use()
        context.enable_only(moderngl.DEPTH_TEST)
        context.enable_direct(gl.DEPTH_CLAMP)  # what is before the near plane casts all the same
        context.depth_func = "<"
        context.polygon_offset = settings.shadow_slope_bias, 0.0
        try:
            yield
        finally:
            context.polygon_offset = 0.0, 0.0
            context.disable_direct(gl.DEPTH_CLAMP)

    def _draw_level(self, settings: Settings, anew: set[Place]) -> None:
        target = self._maps[0]
        self.triangle_count = self.draw_count = 0
        if len(anew) == len(self.tiles):
            target.framebuffer.scissor = None  # type: ignore[assignment]  # nothing cut off
            target.framebuffer.clear()
        base = 0
        for tile in self.tiles:
            if tile.place in anew:
                target.choose(tile.place)
                if len(anew) < len(self.tiles):
                    target.framebuffer.clear()
                matrix = blocks.column_major(tile.frustum.clip_from_world)
                for shader in (self._solid, self._cut_out):
                    program.set_uniform(shader.program, "clip_from_world", matrix)
                self._draw_casters(tile.casters, base, settings.shadow_cull)
            base += len(tile.casters.indices)

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

    def read_depths(self, tile: Tile, part: Part) -> NDArray[np.float32]:
        """Read a part of a tile; waits for the GPU.

        Returns:
            (h, w) depths in [0, 1], top row first.
        """
        return self.map.read(tile.place, part)

    def release(self) -> None:
        """Give the GL objects back."""
        self._drop_maps()
        for buffer in (self._indices, self._rectangles):
            buffer.release()
        for shader in self.shaders:
            shader.release()

    def _drop_maps(self) -> None:
        for each in self._maps:
            each.release()
        self._maps = []
