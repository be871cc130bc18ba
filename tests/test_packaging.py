import json
import re
import shutil
import subprocess
import sys
import tomllib
import zipfile
from importlib import metadata
from pathlib import Path

import pytest
import typer
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name
from typer.testing import CliRunner

from followspot.cli import app

ROOT = Path(__file__).parent.parent
COMMANDS = typer.main.get_command(app).commands  # type: ignore[attr-defined]


def run_python(*arguments: str, cwd: Path) -> str:
    command = [sys.executable, *arguments]
    done = subprocess.run(command, cwd=cwd, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> zipfile.Path:
    """A wheel built without the network from a copy of what belongs to the package."""
    copy = tmp_path_factory.mktemp("checkout")
    for name in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, copy)
    shutil.copytree(
        ROOT / "src", copy / "src", ignore=shutil.ignore_patterns("__pycache__", "*.egg-info")
    )
    offline = ("--quiet", "--no-index", "--no-deps", "--no-build-isolation")
    run_python("-m", "pip", "wheel", *offline, "--wheel-dir", "wheels", ".", cwd=copy)
    (built,) = (copy / "wheels").glob("followspot-*-py3-none-any.whl")
    return zipfile.Path(built)


def test_the_wheel_holds_the_package_and_nothing_else(wheel: zipfile.Path) -> None:
    names = (name for name in wheel.root.namelist() if not name.endswith("/"))
    held = {name for name in names if ".dist-info/" not in name}
    source = {
        path.relative_to(ROOT / "src").as_posix()
        for path in (ROOT / "src" / "followspot").rglob("*")
        if path.is_file() and "__pycache__" not in path.parts
    }
    assert held == source
    for wanted in (r"py\.typed", r"shaders/.+\.glsl", r"builtin/.+\.pk3", r"builtin/.+\.toml"):
        assert any(re.fullmatch(f"followspot/{wanted}", name) for name in held), wanted


def test_the_wheel_gives_the_command(wheel: zipfile.Path) -> None:
    (info,) = (path for path in wheel.iterdir() if path.name.endswith(".dist-info"))
    assert "followspot = followspot.cli:main" in (info / "entry_points.txt").read_text()
    assert "MIT License" in (info / "licenses" / "LICENSE").read_text()


def test_the_commands() -> None:
    assert {"bench", "doctor", "figures", "inspect", "render"} <= set(COMMANDS)


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_has_help(name: str) -> None:
    shown = CliRunner().invoke(app, [name, "--help"])
    assert shown.exit_code == 0, shown.output
    first_word = COMMANDS[name].help.split()[0]
    assert all(word in shown.output for word in ("Usage:", name, first_word))


def test_help_works_in_a_process_of_its_own(tmp_path: Path) -> None:
    shown = run_python("-m", "followspot", "--help", cwd=tmp_path)
    assert all(name in shown for name in COMMANDS)


def test_assets_and_scene_load_no_gl(tmp_path: Path) -> None:
    code = """
import importlib, json, pkgutil, sys
for room in ("assets", "scene", "levelbuilder"):
    package = importlib.import_module(f"followspot.{room}")
    for module in pkgutil.walk_packages(package.__path__, f"{package.__name__}."):
        importlib.import_module(module.name)
print(json.dumps(sorted(sys.modules)))
"""
    loaded = json.loads(run_python("-c", code, cwd=tmp_path))
    assert {"followspot.assets.bsp", "followspot.scene.load"} <= set(loaded)
    assert not {name.partition(".")[0] for name in loaded} & {"moderngl", "glcontext", "OpenGL"}


def pins() -> dict[str, str]:
    lines = (ROOT / "constraints.txt").read_text().splitlines()
    matches = [re.fullmatch(r"([A-Za-z0-9._-]+)==([A-Za-z0-9.+]+)", line) for line in lines]
    assert all(matches), lines
    return {canonicalize_name(match[1]): match[2] for match in matches if match}


def test_everything_installed_for_followspot_is_pinned() -> None:
    """Direct and transitive requirements, for running and for the tests."""
    found: set[str] = set()
    waiting = [("followspot", frozenset({"", "dev"}))]
    while waiting:
        name, extras = waiting.pop()
        for text in metadata.requires(name) or ():
            needed = Requirement(text)
            applies = not needed.marker or any(needed.marker.evaluate({"extra": e}) for e in extras)
            if applies and (key := canonicalize_name(needed.name)) not in found:
                found.add(key)
                waiting.append((key, frozenset({"", *needed.extras})))
    assert {"numpy", "glcontext", "pytest", "grimp"} <= found
    assert found - {"followspot", "setuptools"} <= set(pins())


def test_pins_meet_what_pyproject_asks_for() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    asked = project["dependencies"] + project["optional-dependencies"]["dev"]
    pinned = pins()
    for needed in map(Requirement, asked):
        assert needed.specifier.contains(pinned[canonicalize_name(needed.name)]), needed
