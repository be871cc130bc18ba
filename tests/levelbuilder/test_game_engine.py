"""The unmodified game engine on the courtyard: it loads, stands a player up and draws it alike.

Needs Debian's openarena, ioquake3 and xvfb; no display.
"""

import re
import subprocess
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

import followspot.builtin
from followspot.present import still

PK3 = Path(followspot.builtin.__file__).with_name("courtyard.pk3")
ENGINE = Path("/usr/lib/ioquake3/ioquake3")
WIDTH, HEIGHT = 640, 480
VIEW = (-160, -300, 70, 60)  # x y z yaw, an eye over open floor; the game lets the player drop

_CONFIG = f"""
set com_introplayed 1; set cl_motd 0; set r_mode -1; set r_fullscreen 0; set r_allowSoftwareGL 1
set r_customwidth {WIDTH}; set r_customheight {HEIGHT}; set r_picmip 0; set r_subdivisions 1
set r_lodCurveError 10000; set cl_renderer opengl1; set s_initsound 0; set in_nograb 1
set in_mouse 0; set in_joystick 0; set cg_draw2D 0; set cg_drawGun 0; set con_notifytime -1
set cg_fov 90; set bot_enable 0; set g_gametype 0; set g_doWarmup 0; set com_maxfps 60
set r_drawentities 0; set r_fastsky 1
"""
_SHOTS = f"""
wait 150
viewpos
setviewpos {VIEW[0]} {VIEW[1]} {VIEW[2]} {VIEW[3]}
wait 150
viewpos
screenshot view
wait 5
quit
"""


@dataclass(frozen=True)
class Visit:
    """What came of one run: the log, the eyes that viewpos told, and the picture."""

    log: str
    eyes: list[tuple[float, ...]]
    picture: NDArray[np.uint8]


@pytest.fixture(scope="module")
def visit(tmp_path_factory: pytest.TempPathFactory) -> Visit:
    assert ENGINE.exists(), "install Debian's packages openarena, ioquake3 and xvfb"
    home = tmp_path_factory.mktemp("game")
    base = home / ".openarena" / "baseoa"
    base.mkdir(parents=True)
    (base / "courtyard.pk3").symlink_to(PK3)
    (base / "autoexec.cfg").write_text(_CONFIG)
    (base / "shots.cfg").write_text(_SHOTS)
    settings = {
        "com_basegame": "baseoa",
        "fs_basepath": "/usr/lib/openarena",
        "com_homepath": ".openarena",
        "fs_homepath": str(base.parent),
        "com_legacyprotocol": "71",
        "com_protocol": "71",
        "com_hunkmegs": "256",
        "ttycon": "0",
        "sv_pure": "0",
    }
    display = ["xvfb-run", "-a", "-s", "-screen 0 800x600x24 +extension GLX"]
    places = ["env", f"HOME={home}", "LIBGL_ALWAYS_SOFTWARE=1", "SDL_AUDIODRIVER=dummy"]
    sets = [word for name, value in settings.items() for word in ("+set", name, value)]
    orders = ["+devmap", "courtyard", "+exec", "shots.cfg"]
    run = subprocess.run(
        [*display, *places, str(ENGINE), *sets, *orders],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        timeout=240,
        check=True,
    )
    log = run.stdout.decode("latin-1")
    found = re.findall(r"\((-?\d+) (-?\d+) (-?\d+)\) : (-?\d+)", log)
    shot = Image.open(base / "screenshots" / "view.tga").convert("RGB")
    return Visit(log, [tuple(map(float, place)) for place in found], np.asarray(shot))


@pytest.mark.openarena
def test_the_engine_loads_the_level_without_a_complaint_about_it(visit: Visit) -> None:
    assert "entered the game" in visit.log
    assert "ERROR" not in visit.log
    for line in visit.log.splitlines():
        if re.search(r"warning|couldn't|could not|bad |missing|mismatch|not found", line, re.I):
            # a level shot for the loading screen is not part of a level
            ours = "courtyard" in line and "levelshots" not in line
            assert not ours and "light grid" not in line, line


@pytest.mark.openarena
def test_the_player_stands_on_the_floor_at_a_spawn_point(visit: Visit) -> None:
    with_eyes = [(120, -200, 50), (-480, -200, 50), (-480, 416, 50), (452, 300, 50)]
    with_eyes += [(-200, 400, 258), (-460, 40, 258)]  # 24 to the origin, 26 more to the eye
    x, y, z, _ = visit.eyes[0]
    assert min(np.abs(np.subtract(eye, (x, y, z))).max() for eye in with_eyes) <= 1


@pytest.mark.openarena
@pytest.mark.gl
def test_the_engine_and_followspot_draw_the_same_silhouettes(visit: Visit, tmp_path: Path) -> None:
    (x, y, _, _), yaw = visit.eyes[1], VIEW[3]
    middle = np.array([x, y]) + 0.5 * np.sign([x, y])  # told without their fractions
    eye = (*middle, 50.125)  # the game keeps an eighth of a unit between feet and floor
    wish = still.Wish(
        view="depth",
        camera=",".join(f"{value}" for value in (*eye, yaw, 0)),
        fov=90,
        size=f"{WIDTH}x{HEIGHT}",
    )
    still.render("courtyard", tmp_path / "depth.npy", wish)
    depth = np.load(tmp_path / "depth.npy")
    sky, their_sky = np.isinf(depth), visit.picture.max(axis=2) == 0
    assert sky.mean() > 0.05
    assert (sky & their_sky).sum() > 0.97 * (sky | their_sky).sum()

    # steps in depth are edges in the engine's picture, and nowhere else as well as there
    step = np.abs(np.diff(np.log(np.minimum(depth, 1e5)), axis=1))[:, :-1] > 0.1
    edge = np.abs(np.diff(visit.picture.astype(float).mean(axis=2), axis=1))
    strength = [edge[:, 20 + s : WIDTH - 22 + s][step[:, 20:-20]].mean() for s in range(-15, 16)]
    assert abs(int(np.argmax(strength)) - 15) <= 1
    assert max(strength) > 2 * np.median(strength)
