"""followspot against a bare C program that makes the same OpenGL calls and nothing else.

A frame of followspot is recorded call by call (gl_trace.py): buffers, textures, shaders as they
were sent to the driver, uniforms, draws. From it comes a C program with EGL and no window
(floor/bare.c), which makes the calls again and again. Its picture must equal followspot's, byte
for byte, before anything is timed; then both take turns. With the shadow map kept, and with it
redrawn in every frame.
"""

import sys
from pathlib import Path

import common
import gl_trace
import numpy as np
import ours
from common import BenchmarkError, Comparison, View

WARM = 5
CASES = {"shadow map kept": False, "shadow map redrawn": True}


def export(view: View, redraw: bool, folder: Path) -> np.ndarray:
    """Record a frame, build the program that repeats it, and give the picture it must draw."""
    scene, camera = ours.open_scene(view, redraw_shadows=redraw, exposure=1.0)
    with gl_trace.tracing() as traces, ours.Renderer(ours.SIZE) as renderer:
        trace = traces[0]
        for _ in range(2):
            ours.draw(renderer, scene, camera)
        trace.note_as("frame")
        ours.draw(renderer, scene, camera)
        trace.note_as(None)
        picture = renderer.render(scene, camera, ["final"])
        gl_renderer = renderer.gl_renderer
    final = next(iter(picture.values()))
    framebuffer, _, _, width, height, *_ = trace.picture
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "data").write_bytes(trace.data)
    functions = [
        f"static void {name}(void) {{\n    " + "\n    ".join(lines) + "\n}\n"
        for name, lines in trace.sections.items()
    ]
    header = [
        f'#define GL_RENDERER_RECORDED "{gl_renderer}"',
        f"#define PICTURE_FRAMEBUFFER {framebuffer}",
        f"#define PICTURE_WIDTH {width}",
        f"#define PICTURE_HEIGHT {height}",
    ]
    (folder / "calls.h").write_text("\n".join([*header, *functions]))
    source = common.HERE / "floor" / "bare.c"
    command: list[str | Path] = [common.need("gcc", "gcc"), "-O2", f"-I{folder}", source]
    common.run([*command, "-o", folder / "bare", "-lEGL", "-lGL", "-lm"])
    return final


def run_bare(folder: Path, frames: int) -> float:
    """Median milliseconds of a run of the C program."""
    command: list[str | Path] = [
        folder / "bare",
        folder / "data",
        str(frames),
        str(WARM),
        folder / "picture",
    ]
    ended = common.run(command, common.LLVMPIPE)
    return common.median(map(float, ended.output.split()))


def check_picture(folder: Path, wanted: np.ndarray) -> None:
    """Compare what the C program drew.

    Raises:
        BenchmarkError: a byte differs; tells how many pixels do and by how much.
    """
    run_bare(folder, 1)
    drawn = np.fromfile(folder / "picture", np.uint8).reshape(wanted.shape)[::-1]
    difference = np.abs(drawn.astype(int) - wanted).max(axis=2)
    if difference.any():
        raise BenchmarkError(
            f"the C program's picture differs in {np.count_nonzero(difference)} pixels, "
            f"by {difference.max()} at most"
        )


def compare(view: View, frames: int, rounds: int) -> list[Comparison]:
    """Both cases of one view, in turn."""
    rows = []
    for case, redraw in CASES.items():
        folder = common.OUT / "floor" / ("redrawn" if redraw else "kept")
        check_picture(folder, export(view, redraw, folder))
        taken: dict[str, list[float]] = {"followspot": [], "bare C": []}
        for _ in range(rounds):
            taken["followspot"].append(ours.run(view, frames, redraw).median_ms)
            taken["bare C"].append(run_bare(folder, frames))
        rows.append(Comparison(f"{view.name}, {case}, ms a frame", taken))
    return rows


def main() -> None:
    """Measure, print the table, keep it."""
    parser = common.parser(__doc__)
    parser.add_argument("--views", type=Path, default=common.VIEWS, help="file of views")
    parser.add_argument("--level", default="oa_dm5", help="the level whose views are measured")
    parser.add_argument("--frames", type=int, default=200, help="counted frames a turn")
    parser.add_argument("--rounds", type=int, default=5, help="turns")
    arguments = parser.parse_args()
    common.two_cores()
    rows = []
    for view in common.read_views(arguments.views, arguments.level):
        rows += compare(view, arguments.frames, arguments.rounds)
        print(f"done: {view.name}", file=sys.stderr)
    common.report("floor", "followspot and the same GL calls from C", rows)


if __name__ == "__main__":
    common.guarded(main)
