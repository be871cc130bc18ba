"""What is in a model, a mesh or a whole player, and what is missing."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from rich.table import Table
from rich.text import Text

from followspot.assets import image
from followspot.assets.animation import Animation
from followspot.assets.archive import Archive
from followspot.assets.md2 import Md2Model, read_md2
from followspot.assets.md3 import Md3Model, read_md3
from followspot.assets.mesh_file import MESH_SUFFIXES
from followspot.assets.model_file import find_model_image, images_beside
from followspot.assets.player import Player, load_player
from followspot.assets.script_files import load_scripts
from followspot.present.console import open_console, print_json
from followspot.scene import figure_file, props
from followspot.scene.figure_file import PLAYER, FigureFiles
from followspot.scene.props import PropFiles, PropSurface
from followspot.scene.search import search_roots


def inspect(name: str, assets: Sequence[Path]) -> dict[str, Any]:
    """Everything that can be told of a model without drawing it, ready for JSON.

    Args:
        name: ``player:NAME``, ``player:NAME/SKIN``, or a model's or mesh's file.
        assets: Game folders and pk3 files to look in first.

    Raises:
        AssetError: The model cannot be read.
    """
    archive, entry = figure_file.open_archive(name, search_roots(assets))
    with archive:
        if name.startswith(PLAYER):
            player = load_player(archive, name.removeprefix(PLAYER))
            return {"name": name, **_player(archive, player)}
        if entry.endswith(MESH_SUFFIXES):
            return {"name": name, **_mesh(name, archive, entry)}
        data, source = archive.read(entry), archive.source(entry)
        if entry.endswith(".md2"):
            return {"name": name, **_md2(archive, entry, read_md2(data, source))}
        return {"name": name, **_md3(archive, entry, read_md3(data, source))}


def tell(name: str, assets: Sequence[Path], *, as_json: bool) -> None:
    """Run ``followspot inspect`` for a model."""
    found = inspect(name, assets)
    if as_json:
        print_json(found)
        return
    console = open_console()
    console.print(Text(found["name"], style="bold"), found["file"], sep="  ")
    console.print(", ".join(f"{count} {what}" for what, count in found["counts"].items()))
    if "bounds" in found:
        over = ", over all frames" if "frames" in found["counts"] else ""
        console.print("bounds {mins} to {maxs} {unit}".format(**found["bounds"]) + over)
    for title in ("tags", "sex", "footsteps"):
        if found.get(title):
            console.print(f"{title}: {_cell(found[title])}")
    for title in ("parts", "surfaces", "skins", "animations"):
        if found.get(title):
            console.print(_table(title, [_without_tint(row) for row in found[title]]))
    for missing in found["missing"]:
        tried = ", ".join(missing["tried"])
        console.print(f"missing: {missing['name']} (tried {tried})", style="red")
    for problem in found["problems"]:
        console.print(f"passed over: {problem}", style="yellow")


def _md2(archive: Archive, entry: str, model: Md2Model) -> dict[str, Any]:
    missing: dict[str, list[str]] = {}
    skins: dict[str, str | None] = {}
    for name in model.skins:
        skins[name], tried = find_model_image(archive, entry, name)
        if skins[name] is None:
            missing[name] = tried
    if not any(skins.values()):
        skins |= {name: name for name in images_beside(archive, entry)}
    if not skins:
        stem = entry.rpartition(".")[0]
        skins[stem], missing[stem] = image.find_image(archive, stem)
    frames, vertices, _ = model.positions.shape
    return {
        "file": model.source,
        "counts": {
            "frames": frames,
            "triangles": len(model.indices) // 3,
            "vertices": vertices,
            "skins": len(skins),
        },
        "bounds": _bounds([model.positions]),
        "skins": [{"name": name, "image": found} for name, found in skins.items()],
        "animations": _animations(model.animations),
        "missing": _missing(missing),
        "problems": [],
    }


def _md3(archive: Archive, entry: str, model: Md3Model) -> dict[str, Any]:
    files = FigureFiles(archive, load_scripts(archive).find)
    shaders = [next(iter(surface.shaders), None) for surface in model.surfaces]
    return {
        "file": model.source,
        "counts": _counts([model]),
        "bounds": _bounds([surface.positions for surface in model.surfaces]),
        "surfaces": _surfaces(model, shaders, files, entry),
        "tags": list(model.tags),
        "animations": [],
        "missing": _missing(files.missing),
        "problems": [],
    }


def _mesh(name: str, archive: Archive, entry: str) -> dict[str, Any]:
    files = FigureFiles(archive, load_scripts(archive).find)
    surfaces = props.alone(entry, PropFiles(archive, files), name).surfaces
    return {
        "file": archive.source(entry),
        "counts": {
            "surfaces": len(surfaces),
            "triangles": sum(len(surface.indices) for surface in surfaces) // 3,
            "vertices": sum(len(surface.vertices) for surface in surfaces),
            "images": len({s.material.image for s in surfaces} - {None}),
        },
        "bounds": _bounds([surface.vertices["position"] for surface in surfaces]),
        "surfaces": [_mesh_surface(surface) for surface in surfaces],
        "animations": [],
        "missing": _missing(files.missing),
        "problems": [str(problem) for problem in files.problems],
    }


def _mesh_surface(surface: PropSurface) -> dict[str, Any]:
    material = surface.material
    shade = "blended" if material.blend else "cut out" if material.alpha_test else "solid"
    return {
        "name": surface.name,
        "triangles": len(surface.indices) // 3,
        "vertices": len(surface.vertices),
        "image": material.image,
        "tinted": material.is_tinted,
        "drawn": shade,
        "sides": material.sides.value,
    }


def _player(archive: Archive, player: Player) -> dict[str, Any]:
    files = FigureFiles(archive, load_scripts(archive).find)
    config = player.config
    return {
        "file": f"models/players/{player.name}",
        "skin": player.skin,
        "counts": _counts([part.model for part in player.parts.values()]),
        "parts": [
            {
                "name": name,
                "file": part.model.source,
                "frames": len(part.model.frames),
                "tags": list(part.model.tags),
            }
            for name, part in player.parts.items()
        ],
        "surfaces": [
            {"part": name, **surface}
            for name, part in player.parts.items()
            for surface in _surfaces(part.model, part.textures, files, None)
        ],
        "sex": config.sex,
        "footsteps": config.footsteps,
        "head_offset": config.head_offset,
        "fixed_legs": config.fixed_legs,
        "fixed_torso": config.fixed_torso,
        "animations": _animations(config.animations),
        "missing": _missing(files.missing),
        "problems": [str(problem) for problem in player.problems],
    }


def _counts(models: Sequence[Md3Model]) -> dict[str, int]:
    surfaces = [surface for model in models for surface in model.surfaces]
    return {
        "frames": max(len(model.frames) for model in models),
        "surfaces": len(surfaces),
        "triangles": sum(len(surface.indices) for surface in surfaces) // 3,
        "vertices": sum(len(surface.texcoords) for surface in surfaces),
        "tags": sum(len(model.tags) for model in models),
    }


def _bounds(positions: Sequence[Any]) -> dict[str, Any]:
    """The box round all frames; None to None where there are no vertices."""
    points = np.concatenate([frames.reshape(-1, 3) for frames in positions] or [np.empty((0, 3))])
    if not len(points):
        return {"mins": None, "maxs": None, "unit": "Quake units"}
    mins, maxs = points.min(axis=0).tolist(), points.max(axis=0).tolist()
    return {
        "mins": [round(number, 3) for number in mins],
        "maxs": [round(number, 3) for number in maxs],
        "unit": "Quake units",
    }


def _surfaces(
    model: Md3Model, textures: Sequence[str | None], files: FigureFiles, entry: str | None
) -> list[dict[str, Any]]:
    """Rows of surfaces; what they wear is found through shader scripts, as levels do."""
    rows: list[dict[str, Any]] = []
    for surface, texture in zip(model.surfaces, textures, strict=True):
        shown = texture if surface.indices.size else None
        rows.append(
            {
                "name": surface.name,
                "triangles": len(surface.indices) // 3,
                "vertices": len(surface.texcoords),
                "texture": texture,
                "image": files.material(shown, entry).image if shown else None,
            }
        )
    return rows


def _animations(animations: Mapping[str, Animation]) -> list[dict[str, Any]]:
    return [
        {
            "name": name,
            "first": a.first,
            "frames": a.count,
            "looping": a.looping,
            "fps": a.fps,
            **({"reversed": True} if a.is_reversed else {}),
        }
        for name, a in animations.items()
    ]


def _missing(names: Mapping[str, Sequence[str]]) -> list[dict[str, Any]]:
    return [{"name": name, "tried": list(tried)} for name, tried in names.items()]


def _without_tint(row: Mapping[str, Any]) -> dict[str, Any]:
    """A row as it is printed: what has colours of its own is not white for want of an image."""
    shown = dict(row)
    if shown.pop("tinted", False) and shown["image"] is None:
        shown["image"] = "coloured"
    return shown


def _table(title: str, rows: Sequence[Mapping[str, Any]]) -> Table:
    """A table of alike rows; numbers to the right, what is not there as white."""
    keys = list(rows[0])
    table = Table(*keys, title=title, title_justify="left")
    for column, key in zip(table.columns, keys, strict=True):
        column.justify = "right" if isinstance(rows[0][key], int | float) else "left"
        column.overflow = "fold"
    for row in rows:
        table.add_row(*(_cell(row.get(key)) for key in keys))
    return table


def _cell(value: Any) -> Text | str:
    if value is None:
        return Text("white", style="red")
    return ", ".join(value) if isinstance(value, list) else f"{value}"
