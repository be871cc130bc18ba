"""What characters cost: 16 players in view, and the processor's share of 100; and a film's speed.

The players stand in a grid before the eye on the floor, run and attack, each with a clock of its
own: once all of one model, which are one draw a surface, and once as many models as OpenArena has.
Frames with and without them are drawn in turn while the level's shadow map is kept. The processor's
share is measured in a process of its own with GALLIUM_NOOP=1, as in submission.py.
"""

import itertools
import math
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import common
import ours
from common import View

from followspot.passes.frame import FrameInput
from followspot.scene.camera import Camera
from followspot.scene.load import load
from followspot.scene.scene import Scene

VIEW = View("oa_dm5", (1096, -432, 246, 225, 5.711))
PLAYERS = (
    "sarge", "gargoyle", "kyonshi", "liz", "merman", "neko", "penguin", "sergei", "skelebot",
    "smarine", "sorceress", "assassin", "beret", "major", "arachna", "tony", "angelyss", "ayumi",
)  # fmt: skip
APART = 64.0
"""Units between neighbours."""
FILM_SECONDS = 20
NOOP = {"GALLIUM_NOOP": "1", "GALLIUM_THREAD": "0"}  # why both: submission.py


def crowd(players: Sequence[str], count: int) -> Scene:
    """The view's level with so many running players in rows before the eye.

    Args:
        players: Names of models, used in turn.
        count: How many stand there.
    """
    x, y, z, yaw, _ = VIEW.place
    ahead = math.cos(math.radians(yaw)), math.sin(math.radians(yaw))
    columns = math.ceil(math.sqrt(count))
    text = f'level = "{VIEW.level}"\n[cameras.eye]\nposition = [{x}, {y}, {z}]\n'
    text += f"yaw = {yaw}\npitch = {VIEW.place[4]}\n"
    for number, player in zip(range(count), itertools.cycle(players)):
        forward = 120 + APART * (number // columns)
        aside = APART * (number % columns - (columns - 1) / 2)
        place = [x + ahead[0] * forward - ahead[1] * aside,
                 y + ahead[1] * forward + ahead[0] * aside, z - 20]  # fmt: skip
        text += f'[[characters]]\nmodel = "player:{player}"\nposition = {place}\n'
        text += f'yaw = {yaw + 180}\nanimation = "run+attack"\nclock = {number * 0.37}\n'
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "crowd.toml"
        path.write_text(text)
        return load(str(path))


def frames_ms(
    renderer: ours.Renderer, scene: Scene, camera: Camera, start: int, count: int
) -> Iterator[tuple[float, float]]:
    """Milliseconds of whole frames, and of the processor's share, as the characters move on."""
    frame = FrameInput(scene, camera, scene.settings, exposure=1.0)
    for number in range(start, start + count):
        moment = replace(frame, time=number / 60)
        begin = time.perf_counter()
        report = renderer.draw(moment)
        renderer.finish()
        yield (time.perf_counter() - begin) * 1e3, report.submit_ms


def in_view(
    players: Sequence[str], frames: int, rounds: int
) -> tuple[list[object], dict[str, object]]:
    """16 players against none, drawn in turn: a row of the table, and its figures."""
    with ours.Renderer(ours.SIZE) as empty, ours.Renderer(ours.SIZE) as full:
        scenes = [(empty, crowd((), 0)), (full, crowd(players, 16))]
        for renderer, scene in scenes:
            renderer.open(scene)
            list(frames_ms(renderer, scene, scene.camera("eye"), 0, 5))
        times: list[list[float]] = [[], []]
        for turn in range(rounds):
            for (renderer, scene), found in zip(scenes, times, strict=True):
                drawn = frames_ms(renderer, scene, scene.camera("eye"), turn * frames, frames)
                found.append(common.median([whole for whole, _ in drawn]))
        renderer, scene = scenes[1]
        moment = FrameInput(scene, scene.camera("eye"), scene.settings, 1.0, time=0.5)
        report = renderer.draw(moment)
        if report.characters != 16:
            raise common.BenchmarkError(f"{report.characters} of 16 characters are in view")
    added = [with_ - without for without, with_ in zip(*times, strict=True)]
    without, with_ = map(common.median, times)
    triangles = sum(figure.triangle_count for figure in scene.crowd.figures) / len(players[:16])
    title = f"16 players of {len(scene.crowd.figures)} models, {triangles:.0f} triangles each, ms"
    row: list[object] = [title, without, with_, common.median(added), "8"]
    return row, {
        "players": list(players),
        "without_ms": times[0],
        "with_ms": times[1],
        "added_ms": added,
    }


def submission(frames: int) -> float:
    """The median processor's share of a frame with 100 players of 4 models, in milliseconds."""
    scene = crowd(PLAYERS[:4], 100)
    with ours.Renderer(ours.SIZE) as renderer:
        renderer.open(scene)
        drawn = list(frames_ms(renderer, scene, scene.camera("eye"), 0, 5 + frames))
        return common.median([submit for _, submit in drawn[5:]])


def film_seconds() -> float:
    """How long a film of the level takes in two processes, from start to file."""
    with tempfile.TemporaryDirectory() as folder:
        made = Path(folder) / "fly.mp4"
        command: list[str | Path] = [ours.program(), "film", VIEW.level, "-o", made]
        command += ["--jobs", str(common.CORES), "--seconds", str(FILM_SECONDS), "--fps", "30"]
        return common.run(command, common.LLVMPIPE).seconds


def main() -> None:
    """Measure, print the table, keep it."""
    parser = common.parser(__doc__)
    parser.add_argument("--frames", type=int, default=30, help="frames of a turn")
    parser.add_argument("--rounds", type=int, default=8, help="turns")
    parser.add_argument(
        "--submission", action="store_true", help="the processor's share alone, in ms"
    )
    arguments = parser.parse_args()
    common.two_cores()
    if arguments.submission:
        print(submission(arguments.frames * arguments.rounds))
        return
    turns = arguments.frames, arguments.rounds
    found = [in_view(players, *turns) for players in (PLAYERS[:1], PLAYERS)]
    command = [sys.executable, __file__, "--submission", "--frames", str(arguments.frames)]
    share = float(common.run([*command, "--rounds", str(arguments.rounds)], NOOP).output)
    film = film_seconds()
    rows = [
        *(row for row, _ in found),
        ["100 players of 4 models, submission alone, ms", "-", share, "-", "0.7"],
        [f"film of {FILM_SECONDS} s of {VIEW.level} at 30 frames/s, s", "-", film, "-",
         str(FILM_SECONDS)],
    ]  # fmt: skip
    header = ["characters", "without", "with", "added", "wanted, at most"]
    figures = {"in_view": [each for _, each in found], "submission_ms": share, "film_s": film}
    common.write("characters", common.markdown(header, rows), figures)


if __name__ == "__main__":
    common.guarded(main)
