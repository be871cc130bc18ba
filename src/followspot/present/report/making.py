"""How the report was made: the machine, the versions, the times, the program's size."""

import os
import platform
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from importlib import metadata
from importlib.resources import files
from pathlib import Path

from followspot import __version__
from followspot.present.report.material import Material
from followspot.present.report.page import fill
from followspot.present.report.section import Section
from followspot.present.stopwatch import peak_memory_mb

PACKAGES = ("moderngl", "numpy", "av", "pillow", "jinja2")

_CODE = {".py": "Python", ".glsl": "GLSL", ".vert": "GLSL", ".frag": "GLSL"}


def making(material: Material, seconds: Mapping[str, float], failed: Sequence[str]) -> Section:
    """What the other steps cost and where they ran.

    Args:
        material: What they worked with.
        seconds: What each step took, by its title.
        failed: Titles of those that failed.
    """
    lines = code_lines()
    facts = {
        "Machine": f"{processor()}, {os.cpu_count()} cores",
        "OpenGL renderer": material.renderer.gl_renderer,
        "System": f"{platform.system()} {platform.release()}, Python {platform.python_version()}",
        "followspot": __version__,
        "Packages": ", ".join(f"{name} {metadata.version(name)}" for name in PACKAGES),
        "Program": ", ".join(f"{count:,} lines of {name}" for name, count in lines.items()),
        "Scene": _scene(material),
        "Viewpoint": _viewpoint(material),
        "Memory": f"{peak_memory_mb():,.0f} MiB at most",
        "Made": datetime.now(UTC).strftime("%d %B %Y, %H:%M UTC"),
    }
    html = fill(
        "making.html", facts=facts, seconds=seconds, total=sum(seconds.values()), failed=failed
    )
    figures = {f"lines_of_{name}": float(count) for name, count in lines.items()}
    figures |= {"seconds": sum(seconds.values()), "peak_memory_mb": peak_memory_mb()}
    return Section("making", "How this page was made", html, figures)


def code_lines() -> dict[str, int]:
    """Lines of the installed package that are not blank, by language."""
    counts = dict.fromkeys(_CODE.values(), 0)
    for path in sorted(Path(str(files("followspot"))).rglob("*")):
        if path.suffix in _CODE:
            text = path.read_text(encoding="utf-8")
            counts[_CODE[path.suffix]] += sum(bool(line.strip()) for line in text.splitlines())
    return counts


def processor() -> str:
    """The processor's name, as well as the system knows it."""
    try:
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    except OSError:
        pass
    return platform.processor() or platform.machine()


def _scene(material: Material) -> str:
    scene = material.scene
    counts = {
        "triangles": scene.triangle_count,
        "materials": len(scene.materials),
        "lights": len(scene.lights),
        "characters": len(scene.crowd.characters),
    }
    return ", ".join(f"{name} {count:,}" for name, count in counts.items() if count)


def _viewpoint(material: Material) -> str:
    camera = material.camera
    place = ", ".join(f"{value:g}" for value in camera.position)
    width, height = material.size
    return (
        f"{place} units, yaw {camera.yaw:g}°, pitch {camera.pitch:g}°, {camera.fov:g}° wide; "
        f"{width} × {height} pixels"
    )
