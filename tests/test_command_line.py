"""The command line: mistakes give one line and exit code 2, and leave no file."""

import gc
import os
import re
import signal
import subprocess
import sys
import warnings
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from followspot import cli
from followspot.errors import UsageError
from followspot.present import still
from followspot.present.inspect import inspect
from followspot.present.still import Wish
from followspot.present.viewer import window

Capture = pytest.CaptureFixture[str]


@pytest.fixture
def fail(monkeypatch: pytest.MonkeyPatch, capsys: Capture, tmp_path: Path) -> "Fail":
    return Fail(monkeypatch, capsys, tmp_path)


class Fail:
    """Run a command that must fail; the line that it writes to stderr."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, capsys: Capture, folder: Path) -> None:
        self.monkeypatch, self.capsys, self.folder = monkeypatch, capsys, folder

    def __call__(self, *arguments: str) -> str:
        self.monkeypatch.setattr(sys, "argv", ["followspot", *arguments])
        self.monkeypatch.chdir(self.folder)
        with warnings.catch_warnings():
            # A process that ends closes its paks; this one goes on.
            warnings.simplefilter("ignore", ResourceWarning)
            with pytest.raises(SystemExit) as caught:
                cli.main()
            code = caught.value.code
            del caught
            gc.collect()
        assert code == 2
        out, error = self.capsys.readouterr()
        assert out == ""
        assert error.startswith("followspot: ") and error.count("\n") == 1 and len(error) < 600
        assert list(self.folder.iterdir()) == []
        return error


RENDER = ("render", "courtyard", "-o", "x.png")


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (("--view", "colour"), "there are final, normals"),
        (("--size", "640"), "WIDTHxHEIGHT"),
        (("--size", "0x5"), "1 to"),
        (("--size", "99999999x5"), "1 to"),
        (("--size", "-640x480"), "WIDTHxHEIGHT"),
        (("--camera", "roof"), "there are "),
        (("--camera", "1,2,3"), "x,y,z,yaw,pitch"),
        (("--camera", "1,2,3,4,nan"), "x,y,z,yaw,pitch"),
        (("--camera", "1,2,3,4,100"), "-90 to 90"),
        (("--fov", "180"), "1 to 170"),
        (("--fov", "nan"), "1 to 170"),
        (("--fov", "170.0001"), "found 170.0001"),
        (("--camera", "1,2,3,4,90.0000001"), "found 90.0000001"),
        (("--albedo", "-1"), "--albedo: expected 0 to 1, found -1"),
        (("--light", "sun:1,2,3:4"), "spot:"),
        (("--light", "point:1,2:4"), "point:x,y,z:power"),
        (("--light", "point:1,2,3:-4"), "0 or more"),
        (("--light", "point:1,2,3:inf"), "power"),
        (("--light", "spot:1,2,3:0,0,0:0.5:4"), "direction"),
        (("--light", "spot:1,2,3:1e-200,0,0:0.5:4"), "direction"),
        (("--light", "spot:1,2,3:1e308,1e308,0:0.5:4"), "1e308"),
        (("--light", "spot:1,2,3:0,0,1:1.6:4"), "half-angle"),
        (("--light", "spot:1,2,3:0,0,1:0:4"), "half-angle"),
        (("--albedo", "2"), "albedo"),
        (("--albedo", "nan"), "albedo"),
        (("--set", "shadow_bias"), "KEY=VALUE"),
        (("--set", "brightness=2"), "brightness"),
        (("--set", "shadow_cull=left"), "shadow_cull"),
        (("--set", "exposure=inf"), "exposure"),
        (("--assets", "nowhere"), "nowhere"),
        (("--time", "nan"), "--time"),
        (("--time", "-1e30"), "--time: expected -1e+06 to 1e+06 s, found -1e+30"),
        (("--set", "culling=yes"), "culling: expected true or false, found 'yes'"),
        (("--view", "shadow-map", "--no-shadows"), "no shadow map"),
        (("--light", "point:0,0,9:5") * 9, "--light: at most 8 lights"),
        (("--view", "shadow-map", "--overlay", "boxes"), "--overlay: expected none over a shadow"),
    ],
    ids=lambda value: " ".join(value)[:60] if isinstance(value, tuple) else "",
)
def test_options_that_make_no_sense(fail: Fail, options: tuple[str, ...], told: str) -> None:
    assert told in fail(*RENDER, *options)


@pytest.mark.parametrize("name", ["x", "x.gif", "", "."])
def test_outputs_of_no_known_kind(fail: Fail, name: str) -> None:
    assert ".png" in fail("render", "courtyard", "-o", name)


@pytest.mark.parametrize(
    ("typed", "told"),
    [
        ((*RENDER, "--fov", "abc"), "'--fov'.*, found 'abc'$"),
        ((*RENDER, "--fov=abc"), "'--fov'.*, found 'abc'$"),
        ((*RENDER, "--time", ""), "'--time'.*, found ''$"),
        ((*RENDER, "more"), r"unexpected extra argument.*\(more\)"),
        ((*RENDER, "--view"), "'--view' requires an argument$"),
        ((*RENDER, "--veiw", "final"), "No such option: --veiw"),
        (("render", "courtyard"), "Missing option .*'--output'"),
        (("render", "-o", "x.png"), "Missing argument 'SCENE_OR_LEVEL'"),
        (
            ("film", "courtyard", "-o", "x.mp4", "--samples", "257"),
            "--samples: expected 1 to 256 moments, found 257$",
        ),
        (("rendr",), "No such command 'rendr'"),
        (("a\nb",), r"No such command 'a\\nb'"),
        (("figures", "courtyard", "-o", ""), ": expected a folder's name, found ''$"),
        (("validate", "courtyard", "-o", ""), ": expected a folder's name, found ''$"),
        (("film", "[/x]", "-o", "x.mp4"), r"\[/x\]: expected"),
        (("figures", "[/x]", "-o", "x"), r"\[/x\]: expected"),
        (("bench", "[/x]"), r"\[/x\]: expected"),
        (("bench", "courtyard", "--sweep", "--camera", "title"), "--camera: .* none with --sweep"),
        (("bench", "courtyard", "--sweep", "--fov", "90"), "--fov: .* none with --sweep"),
        (("inspect", "a\nb\x1b[1m"), r"a\\nb\\x1b\[1m: expected"),
    ],
)
def test_what_is_typed_wrongly_is_one_line(fail: Fail, typed: tuple[str, ...], told: str) -> None:
    assert re.search(told, fail(*typed))


@pytest.mark.parametrize(
    ("number", "told"),
    [
        (signal.SIGINT, "interrupted"),
        (signal.SIGTERM, "terminated"),
        (signal.SIGHUP, "terminated"),
    ],
)
@pytest.mark.usefixtures("heard_hang_up")
def test_an_interrupt_is_told(
    monkeypatch: pytest.MonkeyPatch, capsys: Capture, number: signal.Signals, told: str
) -> None:
    def interrupt(*_: object, **__: object) -> None:
        os.kill(os.getpid(), number)
        raise AssertionError("went on")

    before = signal.getsignal(number)
    monkeypatch.setattr("followspot.present.still.render", interrupt)
    monkeypatch.setattr(sys, "argv", ["followspot", *RENDER])
    with pytest.raises(SystemExit) as caught:
        cli.main()
    assert caught.value.code == 128 + number
    assert capsys.readouterr() == ("", f"followspot: {told}\n")
    assert signal.getsignal(number) == before


@pytest.mark.parametrize("typed", [(), ("--help",), ("render", "-h"), ("--version",)])
def test_what_only_tells(
    monkeypatch: pytest.MonkeyPatch, capsys: Capture, typed: tuple[str, ...]
) -> None:
    monkeypatch.setattr(sys, "argv", ["followspot", *typed])
    with pytest.raises(SystemExit) as caught:
        cli.main()
    assert not caught.value.code
    assert "followspot" in capsys.readouterr().out


@pytest.mark.parametrize("name", ["no_such_level", "nowhere.toml", "nowhere.bsp", "x" * 300, ""])
def test_scenes_that_are_not_there(fail: Fail, name: str) -> None:
    assert "error" in fail("render", name, "-o", "x.png")[:60]


@pytest.mark.parametrize("command", ["render", "figures", "inspect", "bench"])
def test_every_command_tells_the_same_way(fail: Fail, command: str) -> None:
    output = ("-o", "out.png") if command in ("render", "figures") else ()
    assert "no_such_level" in fail(command, "no_such_level", *output)


def followspot(*arguments: str, cwd: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "followspot", *arguments],
        cwd=cwd,
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )


def test_broken_level_file_as_a_user_sees_it(tmp_path: Path) -> None:
    (tmp_path / "bad.bsp").write_bytes(b"IBSP\x2e\0\0\0" + b"\xff" * 100)
    done = followspot("render", "bad.bsp", "-o", "x.png", cwd=tmp_path)
    assert done.returncode == 2 and done.stdout == ""
    assert done.stderr.count("\n") == 1 and "bad.bsp" in done.stderr
    assert "expected" in done.stderr and "found" in done.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["bad.bsp"]


def test_lights_of_a_scene_file_that_are_too_many(tmp_path: Path) -> None:
    """Told with file and key, before anything is drawn; those that are typed take their place."""
    light = "[[lights]]\ntype = 'point'\nposition = [0, 0, 100]\npower = 5\n"
    path = tmp_path / "nine.toml"
    path.write_text('level = "courtyard"\n' + light * 9)
    told = f"{path}: lights: at most 8 lights, .* there are 9, 0 spot"
    for opened in (still.open_scene, window.start):
        with pytest.raises(UsageError, match=told):
            opened(str(path), Wish())
    one = Wish(lights=["point:0,0,9:5"])
    assert len(still.open_scene(str(path), one)[0].lights) == 1
    assert len(window.start(str(path), one).lamps) == 1


@pytest.mark.gl
def test_folder_that_cannot_be_written(tmp_path: Path) -> None:
    (tmp_path / "file").write_bytes(b"")
    done = followspot("render", "courtyard", "-o", "file/x.png", "--size", "16x12", cwd=tmp_path)
    assert done.returncode == 2 and done.stderr.count("\n") == 1
    assert "cannot be written" in done.stderr
    assert (tmp_path / "file").read_bytes() == b""


@pytest.mark.gl
def test_a_picture_and_its_numbers(tmp_path: Path) -> None:
    """The same command to png and npy: the second holds float32, top row first."""
    common = ("render", "courtyard", "--size", "48x32", "--camera", "0,0,100,90,10", "--fov", "80")
    for output, view in (("n.png", "normals"), ("n.npy", "normals"), ("d.npy", "depth")):
        done = followspot(*common, "--view", view, "-o", output, cwd=tmp_path)
        assert done.returncode == 0, done.stderr
        assert done.stderr == ""
    shown = np.asarray(Image.open(tmp_path / "n.png"))
    normals, depth = np.load(tmp_path / "n.npy"), np.load(tmp_path / "d.npy")
    assert shown.shape == normals.shape == (32, 48, 3) and depth.shape == (32, 48)
    assert normals.dtype == depth.dtype == np.float32
    assert np.abs(shown / 255 - normals).max() < 1.01 / 255
    assert sorted(path.name for path in tmp_path.iterdir()) == ["d.npy", "n.npy", "n.png"]


def test_help_says_what_can_be_filmed(monkeypatch: pytest.MonkeyPatch, capsys: Capture) -> None:
    """`film player:sarge` is refused; a report of it just has no film."""
    monkeypatch.setenv("COLUMNS", "400")  # so that no line of it is folded
    told = {}
    for command in ("film", "report"):
        monkeypatch.setattr(sys, "argv", ["followspot", command, "--help"])
        with pytest.raises(SystemExit):
            cli.main()
        told[command] = capsys.readouterr().out
    assert "player:sarge" in told["report"] and "player:sarge" not in told["film"]
    assert all("one frame at least" in text for text in told.values())
    assert "whose edges are made even" in told["report"]


def test_help_names_every_command(tmp_path: Path) -> None:
    done = followspot("--help", cwd=tmp_path)
    assert done.returncode == 0
    for command in ("render", "figures", "inspect", "bench", "doctor"):
        assert command in done.stdout


@pytest.mark.gl
def test_render_of_a_model_at_a_time(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    robot = "models/robot/robot.md2"
    shown = []
    for time in ("0", "0.35"):
        picture = tmp_path / f"{time}.png"
        typed = ["render", robot, "--animation", "run", "--time", time, "--size", "80x60"]
        monkeypatch.setattr(sys, "argv", ["followspot", *typed, "-o", str(picture)])
        with pytest.raises(SystemExit) as done:
            cli.main()
        assert not done.value.code
        with Image.open(picture) as image:
            shown.append(np.asarray(image))
    assert shown[0].std() > 10 and (shown[0] != shown[1]).any()


def test_a_film_may_show_items(monkeypatch: pytest.MonkeyPatch) -> None:
    wishes: list[Wish] = []

    def run(scene: str, output: str, wish: Wish, film_wish: object) -> int:
        wishes.append(wish)
        return 0

    monkeypatch.setattr("followspot.present.film.run", run)
    for flags in ((), ("--items",)):
        monkeypatch.setattr(sys, "argv", ["followspot", "film", "oa_dm5", "-o", "x.mp4", *flags])
        with pytest.raises(SystemExit):
            cli.main()
    assert [wish.items for wish in wishes] == [False, True]


@pytest.mark.gl
def test_what_cannot_be_read_is_told_beside_the_picture(
    monkeypatch: pytest.MonkeyPatch, capsys: Capture, tmp_path: Path
) -> None:
    folder = tmp_path / "textures/courtyard"
    folder.mkdir(parents=True)
    for name in ("ashlar", "clay"):
        (folder / f"{name}.jpg").write_bytes(b"junk")
    output = tmp_path / "yard.png"
    typed = ["render", "courtyard", f"--assets={tmp_path}", "--size=32x24", f"--output={output}"]
    monkeypatch.setattr(sys, "argv", ["followspot", *typed])
    with pytest.raises(SystemExit) as caught:
        cli.main()
    assert not caught.value.code and output.is_file()
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"followspot: passed over: {folder}/ashlar.jpg: expected")
    assert line.endswith("and 1 more")
    found = inspect("courtyard", [tmp_path])["problems"]
    assert [problem.split(":")[0] for problem in found] == [
        f"{folder}/{name}.jpg" for name in ("ashlar", "clay")
    ]
