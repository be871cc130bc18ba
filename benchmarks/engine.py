"""followspot against the game engine, at fixed views of real levels, 640x480 on llvmpipe.

Three renderers take turns level by level: followspot with its shadow map redrawn in every frame,
the engine's classic renderer with full textures and light baked into lightmaps (gl1hq-noent), and
its modern renderer with a moving sun whose shadows are redrawn in every frame (gl2sunmove). All
draw the level alone. The engine is Debian's, unmodified; a small module in front of the game's
client module sets the eye and reads the clock (proxy.c). Its frames end in a virtual X server's
window, followspot's in a renderbuffer with the GPU drained.

Told besides: from start to the first picture, and the peak of memory.
"""

import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import common
import ours
from common import BenchmarkError, View

ENGINE = "/usr/lib/ioquake3/ioquake3"
GAME = "/usr/lib/openarena/baseoa/cgamex86_64.so"
FOLLOWSPOT = "followspot"
WARM = 20
SHOT_AT = 10.0
"""Seconds of the game's time at which pictures are taken: proxy.c's FIRST_TIME."""

_FULL_TEXTURES = {
    "r_picmip": 0,
    "r_textureMode": "GL_LINEAR_MIPMAP_LINEAR",
    "r_lodCurveError": 10000,
    "r_subdivisions": 4,
}
PRESETS: dict[str, dict[str, object]] = {
    "gl1hq-noent": {"cl_renderer": "opengl1", **_FULL_TEXTURES},
    "gl2sunmove": {
        "cl_renderer": "opengl2",
        **_FULL_TEXTURES,
        "r_forceSun": 2,
        "r_sunShadows": 1,
        "r_sunlightMode": 2,
        "r_shadowFilter": 1,
        "r_shadowMapSize": 1024,
        "r_depthPrepass": 1,
    },
}
_COMMON: dict[str, object] = {
    # Unlimited frame rate in a plain window of our size, and nothing that waits.
    "com_maxfps": 0, "com_maxfpsUnfocused": 0, "com_maxfpsMinimized": 0, "com_busyWait": 1,
    "r_mode": -1, "r_customwidth": ours.SIZE[0], "r_customheight": ours.SIZE[1], "r_fullscreen": 0,
    "r_swapInterval": 0, "r_allowSoftwareGL": 1, "in_nograb": 1, "in_mouse": 0,
    "in_joystick": 0, "s_initsound": 0, "com_introplayed": 1, "cl_motd": 0,
    # The module in front needs native code and no checks of it.
    "sv_pure": 0, "vm_cgame": 0, "vm_game": 0, "vm_ui": 0,
    # The level alone.
    "cg_draw2D": 0, "cg_drawGun": 0, "cg_drawCrosshair": 0, "cg_fov": 90,
    "cg_shadows": 1, "cg_thirdPerson": 0, "con_notifytime": -1, "bot_enable": 0,
    "bot_minplayers": 0, "g_gametype": 0, "g_doWarmup": 0, "timelimit": 0, "fraglimit": 0,
}  # fmt: skip


@dataclass(frozen=True)
class Sample:
    """One process of one renderer at one level: median ms by view, and what it took besides."""

    median_ms: dict[str, float]
    first_picture_s: float
    peak_mb: float


@contextmanager
def display() -> Iterator[str]:
    """A virtual X server of our own; gives DISPLAY's value."""
    server = common.need("Xvfb", "xvfb")
    read, write = os.pipe()
    process = subprocess.Popen(
        [server, "-displayfd", str(write), "-screen", "0", "1280x1024x24", "-nolisten", "tcp"],
        pass_fds=[write],
        stderr=subprocess.DEVNULL,
    )
    os.close(write)
    try:
        with os.fdopen(read) as answer:
            number = answer.readline().strip()
        if not number:
            raise BenchmarkError("Xvfb did not start")
        yield f":{number}"
    finally:
        process.terminate()
        process.wait()


def build_proxy(folder: Path) -> Path:
    """Compile the module that stands in front of the game's."""
    target = folder / "proxy.so"
    options = ["-O2", "-fPIC", "-shared", "-fvisibility=hidden"]
    source = common.HERE / "engine" / "proxy.c"
    common.run([common.need("gcc", "gcc"), *options, source, "-o", target, "-ldl", "-lm"])
    return target


def run_engine(
    preset: str,
    views: list[View],
    frames: int,
    proxy: Path,
    at: str,
    shots: Path | None = None,
) -> Sample:
    """One process of the engine through all views of one level.

    Args:
        preset: Of `PRESETS`.
        views: Of one level.
        frames: Counted a view.
        proxy: As from `build_proxy`.
        at: The display.
        shots: A folder that gets a picture of each view, ``view00.tga`` and so on, with the level's
            doors and pick-ups; or none.
    """
    common.need_file(ENGINE, "ioquake3")
    common.need_file(GAME, "openarena")
    with tempfile.TemporaryDirectory() as home:
        base = Path(home, ".openarena", "baseoa")
        base.mkdir(parents=True)
        (base / "cgamex86_64.so").symlink_to(proxy)
        # More than 32 settings on the command line are ignored; this file is read before drawing.
        settings = {**_COMMON, **PRESETS[preset], "r_drawentities": int(shots is not None)}
        lines = [f'set {name} "{value}"\n' for name, value in settings.items()]
        (base / "autoexec.cfg").write_text("".join(lines))
        places = Path(home, "views")
        places.write_text("".join(" ".join(map(str, v.place)) + "\n" for v in views))
        times = Path(home, "times")
        options = {
            "com_basegame": "baseoa", "fs_basepath": "/usr/lib/openarena",
            "com_homepath": ".openarena", "fs_homepath": str(base.parent),
            "com_legacyprotocol": "71", "com_protocol": "71", "com_hunkmegs": "512",
            "ttycon": "0", "sv_cheats": "1",
        }  # fmt: skip
        command = [ENGINE]
        for name, value in options.items():
            command += ["+set", name, value]
        environment = common.LLVMPIPE | {
            "HOME": home, "DISPLAY": at, "vblank_mode": "0", "SDL_VIDEODRIVER": "x11",
            "SDL_AUDIODRIVER": "dummy", "FOLLOWSPOT_CGAME": GAME,
            "FOLLOWSPOT_VIEWS": str(places), "FOLLOWSPOT_TIMES": str(times),
            "FOLLOWSPOT_FRAMES": str(frames), "FOLLOWSPOT_WARM": str(WARM),
            **({} if shots is None else {"FOLLOWSPOT_SHOTS": "1"}),
        }  # fmt: skip
        start = time.monotonic()
        ended = common.run([*command, "+devmap", views[0].level], environment, timeout=300)
        if shots is not None:
            for picture in (base / "screenshots").glob("*.tga"):
                shutil.copy(picture, shots)
        first, *rows = times.read_text().splitlines() if times.exists() else [""]
    if len(rows) != len(views):
        raise BenchmarkError(f"{preset} measured {len(rows)} of {len(views)} views")
    medians = {
        view.name: common.median([float(ms) for ms in row.split()])
        for view, row in zip(views, rows, strict=True)
    }
    return Sample(medians, float(first.split()[1]) - start, ended.peak_mb)


def run_ours(views: list[View], frames: int) -> Sample:
    """Run our own commands: a picture for the time to the first, then ``bench`` by view."""
    command: list[str | Path] = [ours.program(), "render", views[0].level]
    command += ["--camera", views[0].camera, "-o", common.OUT / "first.png"]
    first = common.run(command, common.LLVMPIPE)
    medians, peaks = {}, [first.peak_mb]
    for view in views:
        timing, ended = ours.bench(view, frames, "--redraw-shadows")
        medians[view.name] = timing.median_ms
        peaks.append(ended.peak_mb)
    return Sample(medians, first.seconds, max(peaks))


def measure(views: list[View], frames: int, rounds: int) -> dict[str, list[dict[str, Sample]]]:
    """All renderers in turn: for each level a list of rounds, each a sample by renderer."""
    samples: dict[str, list[dict[str, Sample]]] = {}
    with tempfile.TemporaryDirectory() as folder, display() as at:
        proxy = build_proxy(Path(folder))
        for turn in range(rounds):
            for level, group in common.by_level(views).items():
                row = {FOLLOWSPOT: run_ours(group, frames)}
                for preset in PRESETS:
                    row[preset] = run_engine(preset, group, frames, proxy, at)
                samples.setdefault(level, []).append(row)
                print(f"round {turn + 1} of {rounds}: {level}", file=sys.stderr)
    return samples


def summary(samples: dict[str, list[dict[str, Sample]]]) -> list[common.Comparison]:
    """The mean over the views, start and memory over the levels, then each view."""
    names = [FOLLOWSPOT, *PRESETS]
    turns = list(zip(*samples.values(), strict=True))  # each turn has every level

    def over_levels(what: str, value: Callable[[Sample], float]) -> common.Comparison:
        taken = {n: [common.mean([value(row[n]) for row in turn]) for turn in turns] for n in names}
        return common.Comparison(what, taken)

    rows = [
        over_levels("mean of the views, ms a frame", lambda s: common.mean(s.median_ms.values())),
        over_levels("start to first picture, s", lambda s: s.first_picture_s),
        over_levels("peak memory, MiB", lambda s: s.peak_mb),
    ]
    for rounds in samples.values():
        for view in rounds[0][FOLLOWSPOT].median_ms:
            taken = {n: [row[n].median_ms[view] for row in rounds] for n in names}
            rows.append(common.Comparison(f"{view}, ms a frame", taken))
    return rows


def main() -> None:
    """Measure, print the table, keep it."""
    parser = common.parser(__doc__)
    parser.add_argument("--views", type=Path, default=common.VIEWS, help="file of views")
    parser.add_argument("--level", help="only the views of this level")
    parser.add_argument("--frames", type=int, default=200, help="counted frames a view and turn")
    parser.add_argument("--rounds", type=int, default=5, help="turns")
    arguments = parser.parse_args()
    common.two_cores()
    views = common.read_views(arguments.views, arguments.level)
    samples = measure(views, arguments.frames, arguments.rounds)
    common.report("engine", "followspot and the game engine", summary(samples))


if __name__ == "__main__":
    common.guarded(main)
