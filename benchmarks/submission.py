"""What it costs to tell the driver of a frame, without drawing it: GALLIUM_NOOP=1.

With that variable Mesa runs its whole OpenGL front end and draws nothing, so what is left of a
frame is the processor's cost of culling, sorting and calling. Measured from every spawn point of
the largest OpenArena levels: oa_thor has the most faces, suspended the most triangles. Three
cases: the shadow map kept, redrawn in every frame, and kept while the camera turns by a degree a
frame, so that everything is culled and sorted anew.
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
from followspot.scene.load import load
from followspot.scene.scene import Scene

LEVELS = ("oa_thor", "suspended")
CASES = ("kept", "redrawn", "kept, turning")
WANTED_MS = (0.25, 0.4, None)


def frame_ms(renderer: ours.Renderer, scene: Scene, case: str, frames: int) -> Iterator[float]:
    """The median time of a frame from each spawn point, in milliseconds."""
    settings = changed(scene.settings, redraw_shadows=case == "redrawn")
    scene = replace(scene, settings=settings)
    renderer.open(scene)
    for camera in scene.cameras.values():
        if case.endswith("turning"):
            ours.draw(renderer, scene, camera)
            turned = (
                replace(camera, yaw=camera.yaw + degrees) for degrees in range(1, frames // 10 + 2)
            )
            yield common.median([ours.draw(renderer, scene, each) for each in turned])
        else:
            yield ours.measure(renderer, scene, camera, frames).median_ms


def main() -> None:
    """Measure, print the table, keep it."""
    parser = common.parser(__doc__)
    parser.add_argument("--level", action="append", help=f"levels; else {' and '.join(LEVELS)}")
    parser.add_argument(
        "--frames", type=int, default=200, help="counted frames a spawn point (turning: a tenth)"
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
