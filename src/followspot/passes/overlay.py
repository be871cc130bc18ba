"""The overlay pass: boxes and frusta as lines over the finished picture, to debug by."""

import enum
from typing import Any

import moderngl
import numpy as np
from numpy.typing import NDArray

from followspot.gpu import blocks, gl, program
from followspot.gpu.program import ShaderFolder
from followspot.gpu.targets import encode_srgb
from followspot.passes.programs import Shader
from followspot.passes.shadow_tiles import Tile
from followspot.scene import outlines
from followspot.scene.light import CubeSide, Light, SpotLight
from followspot.scene.outlines import Points
from followspot.scene.scene import Scene
from followspot.spaces import Mat4


class Overlay(enum.StrEnum):
    """What can be drawn over a picture."""

    BOXES = "boxes"
    """Boxes of objects, red: see `outlines.objects`; characters' as culling takes them."""
    SCENE = "scene"
    """The box of everything, yellow."""
    LIGHT_FRUSTUM = "light-frustum"
    """What the lights' shadow maps cover, translucent blue, with their cones and places."""
    CAMERA_FRUSTUM = "camera-frustum"
    """What the camera sees that decides what is drawn, where that is another one; white."""


_RED, _YELLOW, _WHITE = (255, 60, 40, 230), (255, 225, 40, 255), (255, 255, 255, 255)
_BLUE, _BLUE_SIDES, _PALE_BLUE = (90, 150, 255, 255), (50, 110, 255, 40), (150, 190, 255, 200)
"""Displayed colours and coverage."""

_BEHIND = 0.2
"""How strongly lines are drawn where something is in front of them."""

_NEARER = 2.0
"""Pixels' widths by which lines count as nearer, so that the faces that they bound do not hide
them: enough for faces that deepen by no more than this from pixel to pixel."""

_MARK = 16.0
"""Units to each side of a light's mark."""

_VERTEX = np.dtype([("position", "<f4", 3), ("colour", "u1", 4)])


class OverlayPass:
    """Everything that can be drawn over the pictures of one scene."""

    def __init__(self, context: moderngl.Context, scene: Scene, folder: ShaderFolder) -> None:
        self._context = context
        self._crowd = scene.crowd
        mins, maxs = scene.bounds
        self._scene = _coloured(outlines.box_lines(mins[np.newaxis], maxs[np.newaxis]), _YELLOW)
        self._objects = _coloured(outlines.box_lines(*outlines.objects(scene)), _RED)
        most = len(self._scene) + len(self._objects)
        most += outlines.EDGE_POINTS * (len(scene.crowd) + 1)
        most += outlines.MARK_POINTS * blocks.MAX_LIGHTS
        a_light = outlines.EDGE_POINTS + outlines.CONE_POINTS + outlines.SIDE_POINTS
        most += (a_light + outlines.EDGE_POINTS) * blocks.MAX_SHADOWS
        most += outlines.EDGE_POINTS * blocks.SIDES * blocks.MAX_LIGHTS
        self._vertices = context.buffer(reserve=most * _VERTEX.itemsize, dynamic=True)
        self._shader = Shader(context, folder, "overlay", self._array)
        self.shaders = [self._shader]
        self._uploaded: object = None
        self._side_count = self._line_count = 0

    def _array(self, overlay: moderngl.Program) -> list[moderngl.VertexArray]:
        content = [(self._vertices, "3f 4f1", "in_position", "in_colour")]
        return [self._context.vertex_array(overlay, content, skip_errors=True)]

    def update(
        self,
        shown: frozenset[Overlay],
        lights: tuple[Light, ...],
        shadowed: tuple[SpotLight, ...],
        tiles: tuple[Tile, ...],
        seconds: float,
        frustum: Mat4 | None,
    ) -> None:
        """Upload what is to be drawn, if anything has changed.

        Args:
            shown: What is asked for.
            lights: The frame's.
            shadowed: What shadow maps look into.
            tiles: What the maps cover.
            seconds: The time, for characters.
            frustum: ``clip_from_world`` of a camera other than the picture's that decides what is
                drawn, if there is one.
        """
        moves = len(self._crowd) and Overlay.BOXES in shown
        seen = None if frustum is None else frustum.tobytes()
        frusta = tuple(tile.frustum for tile in tiles)
        wanted = (shown, lights, frusta, seconds if moves else None, seen)
        if wanted == self._uploaded:
            return
        self._uploaded = wanted
        sides, lines = [], []
        if Overlay.BOXES in shown:
            centres = self._crowd.places(seconds)[:, :3]
            radius = self._crowd.radius[:, np.newaxis]
            boxes = outlines.box_lines(centres - radius, centres + radius)
            lines += [self._objects, _coloured(boxes, _RED)]
        if Overlay.SCENE in shown:
            lines.append(self._scene)
        if Overlay.CAMERA_FRUSTUM in shown and frustum is not None:
            lines.append(_coloured(outlines.frustum_lines(frustum), _WHITE))
        if Overlay.LIGHT_FRUSTUM in shown:
            for tile in tiles:
                light, corners = shadowed[tile.light], tile.frustum.clip_from_world
                lines.append(_coloured(outlines.frustum_lines(corners), _BLUE))
                if isinstance(light, CubeSide):
                    continue  # six filled ones would hide everything
                if not tile.is_near:
                    sides.append(_coloured(outlines.frustum_triangles(corners), _BLUE_SIDES))
                    lines.append(
                        _coloured(outlines.cone_lines(light, tile.frustum.far), _PALE_BLUE)
                    )
            lines += [_coloured(outlines.mark_lines(x.position, _MARK), _WHITE) for x in lights]
        self._side_count = sum(len(each) for each in sides)
        self._line_count = sum(len(each) for each in lines)
        if sides or lines:
            self._vertices.write(np.concatenate([*sides, *lines]))

    def draw(self, clip_from_view: Mat4, width: int) -> None:
        """Draw over the picture that is bound, in displayed colours; its alpha stays.

        Args:
            clip_from_view: The picture's; the frame block has the rest.
            width: Of the whole picture in pixels.
        """
        context, shader = self._context, self._shader
        encode_srgb(context, False)
        context.enable_direct(gl.DEPTH_CLAMP)  # lights may be outside of the camera's range
        context.enable_direct(gl.LINE_SMOOTH)
        context.enable_only(moderngl.DEPTH_TEST | moderngl.BLEND)
        over, keep = (
            (moderngl.SRC_ALPHA, moderngl.ONE_MINUS_SRC_ALPHA),
            (moderngl.ZERO, moderngl.ONE),
        )
        context.blend_func = (*over, *keep)  # type: ignore[assignment]  # four are taken, too
        # Clip z is a distance times one number plus another: with that one larger by a share, the
        # quotient z/w is what it would be at a distance smaller by the same share.
        share = _NEARER * 2 / (float(clip_from_view[0, 0]) * width)
        nearer = float(clip_from_view[2, 3]) * share
        program.set_uniform(shader.program, "nearer", nearer)
        self._render("<", 1.0, moderngl.TRIANGLES, 0, self._side_count)
        self._render(">", _BEHIND, moderngl.LINES, self._side_count, self._line_count)
        self._render("<=", 1.0, moderngl.LINES, self._side_count, self._line_count)
        context.disable_direct(gl.LINE_SMOOTH)
        context.disable_direct(gl.DEPTH_CLAMP)

    def _render(self, depth: str, strength: float, mode: int, first: int, count: int) -> None:
        if count:
            self._context.depth_func = depth
            program.set_uniform(self._shader.program, "strength", strength)
            self._shader.arrays[0].render(mode, vertices=count, first=first)

    def release(self) -> None:
        """Give the GL objects back."""
        self._shader.release()
        self._vertices.release()


def _coloured(points: Points, colour: tuple[int, int, int, int]) -> NDArray[Any]:
    """(n,) of _VERTEX."""
    vertices = np.empty(len(points), _VERTEX)
    vertices["position"], vertices["colour"] = points, colour
    return vertices
