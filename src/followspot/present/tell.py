"""What the commands print: progress while they work, tables when they are done."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from rich.table import Table
from rich.text import Text

from followspot.present import bench as bench_
from followspot.present import figures as figures_
from followspot.present import inspect as inspect_
from followspot.present import inspect_model
from followspot.present.console import open_console, print_json, working
from followspot.present.still import Wish
from followspot.present.stopwatch import Steps
from followspot.scene import figure_file


def figures(name: str, folder: Path, wish: Wish) -> None:
    """Run ``followspot figures`` and print each file with the time that it took."""
    console, steps = open_console(), Steps()
    table = Table("picture", "ms", title=f"{name}, {wish.size}")
    table.columns[1].justify = "right"

    def on_picture(path: Path) -> None:
        steps(path.name)
        table.add_row(str(path), f"{steps.ms[path.name]:.0f}")

    with working(console, f"drawing {name}"):
        figures_.make(name, folder, wish, steps, on_picture)
    console.print(table)
    files = {row.name for row in folder.iterdir()}
    loading = {step: ms for step, ms in steps.ms.items() if step not in files}
    console.print(_steps(loading))


def inspect(name: str, assets: Sequence[Path], *, as_json: bool) -> None:
    """Run ``followspot inspect``."""
    if figure_file.is_model(name):
        inspect_model.tell(name, assets, as_json=as_json)
        return
    found = inspect_.inspect(name, assets)
    if as_json:
        print_json(found)
        return
    console = open_console()
    console.print(Text(found["name"], style="bold"), found["file"], sep="  ")
    mins, maxs = found["bounds"]["mins"], found["bounds"]["maxs"]
    console.print(f"bounds {mins} to {maxs} units; sky {found['sky']}")
    for title in ("counts", "entities"):
        console.print(_two_columns(title, found[title]))
    console.print(_cameras(found["cameras"]))
    if found["props"]:
        console.print(_props(found["props"]))
    console.print(_materials(found["materials"]))
    for missing in found["missing"]:
        tried = ", ".join(missing["tried"])
        console.print(f"missing: {missing['name']} (tried {tried})", style="red")
    for problem in found["problems"]:
        console.print(f"passed over: {problem}", style="yellow")
    console.print(
        _two_columns("memory, MiB", {k: f"{v:.1f}" for k, v in found["memory_mb"].items()})
    )
    console.print(_steps(found["load_ms"]))


def bench(name: str, wish: Wish, frames: int, *, sweep: bool, as_json: bool) -> None:
    """Run ``followspot bench``."""
    console = open_console(on_stderr=as_json)
    with working(console, f"measuring {name}") as status:
        result = bench_.run(
            name,
            wish,
            frames,
            sweep,
            lambda t: status.update(Text(f"measuring {name}: {t.camera} {t.median_ms:.1f} ms")),
        )
    if as_json:
        print_json(result)
        return
    redrawn = ", shadow map redrawn in every frame" if result.redraw_shadows else ""
    table = Table(
        title=f"{name} at {wish.size}, {frames} frames a view{redrawn}\n{result.gl_renderer}",
        caption="ms a frame with the GPU drained; submit is the CPU's share of it",
    )
    for heading in ("view", "median", "p95", "worst", "submit", "draws", "triangles", "of"):
        table.add_column(heading, justify="left" if heading == "view" else "right")
    for view in result.views:
        times = (view.median_ms, view.p95_ms, view.worst_ms, view.submit_ms)
        counts = view.frame.draws, view.frame.triangles, view.frame.triangles_in_scene
        table.add_row(view.camera, *(f"{t:.2f}" for t in times), *(str(c) for c in counts))
    console.print(table)
    for view in result.views if len(result.views) == 1 else ():
        parts = ", ".join(f"{name} {ms:.2f}" for name, ms in view.pass_ms.items())
        console.print(f"GPU ms by pass: {parts}")
    console.print(_steps(result.load_ms))
    console.print(f"peak memory {result.peak_memory_mb:.0f} MiB")


def _steps(ms: Mapping[str, float]) -> str:
    parts = ", ".join(f"{name} {value:.0f}" for name, value in ms.items())
    return f"loading took {sum(ms.values()):.0f} ms: {parts}"


def _two_columns(title: str, rows: Mapping[str, Any]) -> Table:
    table = Table(title, "", title_justify="left")
    table.columns[1].justify = "right"
    for name, value in rows.items():
        table.add_row(str(name), str(value))
    return table


def _cameras(cameras: Mapping[str, Sequence[float]]) -> Table:
    table = Table("view", "x, y, z, yaw, pitch")
    for name, numbers in cameras.items():
        table.add_row(name, ",".join(f"{n:g}" for n in numbers))
    return table


def _props(props: Sequence[Mapping[str, Any]]) -> Table:
    table = Table("prop", "from", "to", "triangles")
    table.columns[3].justify = "right"
    for prop in props:
        corners = (" ".join(f"{n:g}" for n in prop[name]) for name in ("mins", "maxs"))
        table.add_row(prop["name"], *corners, str(prop["triangles"]))
    return table


def _materials(materials: Sequence[Mapping[str, Any]]) -> Table:
    table = Table("material", "drawn as", "triangles")
    table.columns[0].overflow = "fold"
    table.columns[2].justify = "right"
    for m in materials:
        kind = m["shade"] if m["blend"] else "cut out" if m["alpha_test"] else "solid"
        kind += ", emissive" if m["shade"] == "emissive" and not m["blend"] else ""
        sides = "" if m["sides"] == "front" else f", {m['sides']} sides"
        name = Text(m["name"])
        if m["image"] is None and not m["tinted"]:
            name.append("\n  white", "red")
        elif not (image := m["image"] or "coloured").startswith(m["name"] + "."):
            name.append(f"\n  {image}")
        if m["layer"] is not None:
            name.append(f"\n  + {m['layer']}, {m['laid']}")
        table.add_row(name, kind + sides, str(m["triangles"]))
    return table
