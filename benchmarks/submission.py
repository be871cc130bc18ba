"""What it costs to tell the driver of a frame, without drawing it: GALLIUM_NOOP=1.

With that variable Mesa runs its whole OpenGL front end and draws nothing, so what is left of a
frame is the processor's cost of culling, sorting and calling. Measured from every spawn point of
the largest OpenArena levels: oa_thor has the most faces, suspended the most triangles. Four
cases: the shadow map kept, redrawn in every frame, kept while the camera turns by a degree a
frame, so that everything is culled and sorted anew, and a light that rises by a unit a frame.
"""

import os
import sys
from collections.abc import Iterator
from dataclasses import replace

os.environ["GALLIUM_NOOP"] = "1"  # before a GL library is loaded
# Without this Mesa puts a thread between GL and the driver that does nothing, which llvmpipe has
# not got; in 22.3 the two together crash when a buffer is written that a frame has just used.
os.environ["GALLIUM_THREAD"] = "0"

import common
import ours
from common import BenchmarkError
from msgspec.structs import replace as changed

from followspot.errors import FollowspotError
from followspot.scene.light import Light
from followspot.scene.load import load
from followspot.scene.scene import Scene
from followspot.spaces import vec3

LEVELS = ("oa_thor", "suspended")
CASES = ("kept", "redrawn", "kept, turning", "moving")
WANTED_MS = (0.25, 0.4, None, None)


def frame_ms(renderer: ours.Renderer, scene: Scene, case: str, frames: int) -> Iterator[float]:
    """The median time of a frame from each spawn point, in milliseconds."""
    settings = changed(scene.settings, redraw_shadows=case == "redrawn")
    scene = replace(scene, settings=settings)
    renderer.open(scene)
    for camera in scene.cameras.values():
        steps = range(1, frames // 10 + 2)
        if case.endswith("turning"):
            ours.draw(renderer, scene, camera)
            turned = (replace(camera, yaw=camera.yaw + degrees) for degrees in steps)
            yield common.median([ours.draw(renderer, scene, each) for each in turned])
        elif case == "moving":
            ours.draw(renderer, scene, camera)
            lit = (scene.with_lights(*(_higher(light, k) for light in scene.lights)) for k in steps)
            yield common.median([ours.draw(renderer, each, camera) for each in lit])
        else:
            yield ours.frame_times(renderer, scene, camera, frames).median_ms


def _higher(light: Light, units: float) -> Light:
    return replace(light, position=light.position + vec3((0, 0, units)))


def main() -> None:
    """Measure, print the table, keep it."""
    parser = common.parser(__doc__)
    parser.add_argument("--level", action="append", help=f"levels; else {' and '.join(LEVELS)}")
    parser.add_argument(
        "--frames", type=int, default=200, help="counted frames a spawn point (moving: a tenth)"
    )
    arguments = parser.parse_args()
    common.two_cores()
    rows, figures = [], []
    with ours.Renderer(ours.SIZE) as renderer:
        for level in arguments.level or LEVELS:
            try:
                scene = load(level)
            except FollowspotError as error:
                raise BenchmarkError(str(error)) from None
            size = f"{level}, {len(scene.mesh.faces)} faces, {scene.mesh.triangle_count} triangles"
            for case, wanted in zip(CASES, WANTED_MS, strict=True):
                times = sorted(frame_ms(renderer, scene, case, arguments.frames))
                asked = "-" if wanted is None else f"{wanted:.2f}"
                rows.append([size, case, common.median(times), times[-1], asked])
                figures.append({"level": level, "case": case, "ms": times, "wanted_ms": wanted})
            print(f"done: {level}", file=sys.stderr)
    header = [
        "submission alone, ms a frame", "shadow map", "median view", "worst view", "wanted"
    ]  # fmt: skip
    common.write("submission", common.markdown(header, rows), figures)


if __name__ == "__main__":
    common.guarded(main)
