"""How followspot's frame time grows with pixels, the shadow map's size, triangles and lights.

One view, llvmpipe, the shadow maps kept and redrawn in every frame. Triangles are varied without
changing the picture: the level's curved patches are cut coarser or finer. Point lights with shadows
stand around the camera, beside the level's own light. All sizes take turns. Writes a table, and a
plot as out/benchmarks/scale.svg.
"""

import sys
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from pathlib import Path

import common
import numpy as np
import ours
import svg
from common import BenchmarkError, View
from msgspec.structs import replace as changed

from followspot.scene.camera import Camera
from followspot.scene.light import PointLight
from followspot.scene.scene import Scene

SIZES = ((320, 240), (640, 480), (960, 720), (1280, 720), (1920, 1080))
SHADOW_SIZES = (256, 512, 1024, 2048, 4096)
TOLERANCES = (32.0, 4.0, 1.0, 0.25, 0.06)
"""Units by which triangles may miss a curved patch."""

POINT_LIGHTS = (0, 1, 2, 4)
OFFSETS = 40.0 * np.array([(1, 0, 1), (-1, 0, 1), (0, 1, 1), (0, -1, 1)])
"""Units from the camera to the lamps, in that order."""

KEPT, REDRAWN = "map kept", "map redrawn"


@dataclass
class Point:
    """One setting: where it stands on its axis, how it is named, and its times in both cases."""

    axis: str
    x: float
    name: str
    renderer: ours.Renderer
    scene: Scene
    camera: Camera
    ms: dict[str, list[float]] = field(default_factory=lambda: {KEPT: [], REDRAWN: []})

    def measure(self, frames: int) -> None:
        """Take one turn."""
        for case, times in self.ms.items():
            settings = changed(self.scene.settings, redraw_shadows=case == REDRAWN)
            scene = replace(self.scene, settings=settings)
            self.renderer.open(scene)
            times.append(ours.frame_times(self.renderer, scene, self.camera, frames).median_ms)


def points(view: View, stack: ExitStack) -> list[Point]:
    """All settings, with a renderer each for what differs in it."""

    def renderer(size: tuple[int, int]) -> ours.Renderer:
        return stack.enter_context(ours.Renderer(size))

    scene, camera = ours.open_scene(view)
    found = []
    for width, height in SIZES:
        name = f"{width}x{height}"
        each = renderer((width, height))
        found.append(Point("pixels", width * height / 1e6, name, each, scene, camera))
    for size in SHADOW_SIZES:
        mapped = replace(scene, settings=changed(scene.settings, shadow_map_size=size))
        each = renderer(ours.SIZE)
        found.append(Point("shadow map", size * size / 1e6, f"{size}x{size}", each, mapped, camera))
    for tolerance in TOLERANCES:
        cut, camera = ours.open_scene(view, tolerance)
        count = cut.mesh.triangle_count
        each = renderer(ours.SIZE)
        found.append(Point("triangles", count / 1e3, f"{count}", each, cut, camera))
    for count in POINT_LIGHTS:
        lamps = tuple(
            PointLight(camera.position + offset, np.full(3, 100.0)) for offset in OFFSETS[:count]
        )
        lit = replace(scene, lights=scene.lights + lamps)
        each = renderer(ours.SIZE)
        found.append(Point("point lights", count, f"{count}", each, lit, camera))
    return found


def panels(found: list[Point]) -> list[svg.Panel]:
    """A plot for each axis."""
    labels = {
        "pixels": "million pixels",
        "shadow map": "million texels of the shadow map",
        "triangles": "thousand triangles in the level",
        "point lights": "point lights with shadows",
    }
    return [
        svg.Panel(
            f"cost against {axis}",
            label,
            "ms a frame",
            {
                case: [(p.x, common.median(p.ms[case])) for p in found if p.axis == axis]
                for case in (KEPT, REDRAWN)
            },
        )
        for axis, label in labels.items()
    ]


def main() -> None:
    """Measure, print the table, keep it with its plot."""
    parser = common.parser(__doc__)
    parser.add_argument("--views", type=Path, default=common.VIEWS, help="file of views")
    parser.add_argument("--level", default="oa_dm5", help="its first view is measured")
    parser.add_argument("--frames", type=int, default=30, help="counted frames a turn")
    parser.add_argument("--rounds", type=int, default=5, help="turns")
    arguments = parser.parse_args()
    common.two_cores()
    view = common.read_views(arguments.views, arguments.level)[0]
    with ExitStack() as stack:
        found = points(view, stack)
        if len({p.x for p in found if p.axis == "triangles"}) == 1:
            raise BenchmarkError(f"{view.level} has no curved patches to cut finer; try oa_dm5")
        for turn in range(arguments.rounds):
            for point in found:
                point.measure(arguments.frames)
            print(f"round {turn + 1} of {arguments.rounds}", file=sys.stderr)
    rows = [[p.axis, p.name, *(common.median(t) for t in p.ms.values())] for p in found]
    header = [f"{view.name}: cost against", "", f"{KEPT}, ms", f"{REDRAWN}, ms"]
    figures = [{"axis": p.axis, "name": p.name, "x": p.x, "ms": p.ms} for p in found]
    common.write("scale", common.markdown(header, rows), figures)
    (common.OUT / "scale.svg").write_text(svg.plot(panels(found)))


if __name__ == "__main__":
    common.guarded(main)
