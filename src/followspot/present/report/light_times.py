"""What lights and their shadow maps cost, measured in the report's own view."""

import time
from dataclasses import replace

import msgspec
import numpy as np

from followspot.arrays import Floats
from followspot.gpu.blocks import MAX_LIGHTS
from followspot.gpu.context import is_software
from followspot.passes import lighting
from followspot.passes.frame import FrameInput
from followspot.present.renderer import Renderer
from followspot.scene.camera import Camera
from followspot.scene.light import PointLight
from followspot.scene.scene import Scene
from followspot.spaces import vec3

COUNTS = (0, 2, 4, MAX_LIGHTS)
"""Numbers of lights that are timed."""

_REPEATS = 7


def by_count(scene: Scene, camera: Camera, renderer: Renderer, lamps: Floats) -> dict[int, float]:
    """Milliseconds of a frame by its number of lights without shadows."""
    result = {}
    for count in COUNTS:
        places = np.resize(lamps, (count, 3))
        lights = [PointLight(vec3(place), vec3([1, 1, 1]), casts_shadow=False) for place in places]
        result[count] = _frame_ms(scene.with_lights(*lights), camera, renderer)
    return result


def of_a_map(scene: Scene, camera: Camera, renderer: Renderer) -> float | None:
    """Milliseconds that drawing the scene's shadow maps anew adds to a frame, for each of them."""
    count = len(lighting.shadowed(scene.lights, scene.settings))
    if count == 0:
        return None
    kept, redrawn = (
        _frame_ms(
            replace(scene, settings=msgspec.structs.replace(scene.settings, redraw_shadows=redraw)),
            camera,
            renderer,
        )
        for redraw in (False, True)
    )
    return max(redrawn - kept, 0.0) / count


def _frame_ms(scene: Scene, camera: Camera, renderer: Renderer) -> float:
    """The best of some. Where processors rasterise, their time counts: not other programs'."""
    clock = time.process_time if is_software(renderer.gl_renderer) else time.perf_counter
    frame = FrameInput(scene, camera, scene.settings, 1.0)
    renderer.open(scene)
    renderer.draw(frame)
    renderer.finish()
    took = []
    for _ in range(_REPEATS):
        start = clock()
        renderer.draw(frame)
        renderer.finish()
        took.append(clock() - start)
    return min(took) * 1e3
