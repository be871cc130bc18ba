"""followspot against pygfx, pyrender and Panda3D: the same mesh, textures, camera, size, light.

A level's opaque and cut-out triangles are written to files, one part for each texture, and each
renderer draws them in its own virtual environment (made below out/benchmarks when it is not
there) with one spot light whose shadow map of the same size is drawn in every frame. pygfx and
pyrender shade with their own plainest lit material; Panda3D is given followspot's own shaders.
All draw on Mesa's software rasteriser: pygfx through Vulkan, the others through OpenGL.

followspot takes part three times: with its map redrawn in every frame as the others do it, with its
map kept, as it does while nothing moves, and redrawn without leaving out what the camera cannot
see. It draws its sky and its blended surfaces besides.
"""

import json
import sys
from pathlib import Path
from typing import Any

import common
import numpy as np
import ours
from common import Comparison, View

from followspot import spaces
from followspot.assets.image import Image, decode_all
from followspot.assets.shader_values import Sides
from followspot.gpu import blocks, program
from followspot.passes import lighting
from followspot.scene.material import Shade

VULKAN = "/usr/share/vulkan/icd.d/lvp_icd.x86_64.json"
NEEDS: dict[str, list[str]] = {
    "pygfx": ["pygfx==0.17.0", "wgpu==0.32.0", "rendercanvas"],
    "pyrender": ["pyrender==0.1.45", "numpy<1.24"],
    "panda3d": ["panda3d==1.10.16", "numpy"],
}
"""What is installed for each; pyrender uses names that NumPy dropped in 1.24."""


def environment(name: str) -> Path:
    """The Python of a renderer's virtual environment, made if it is not there."""
    folder = common.OUT / f"venv-{name}"
    python = folder / "bin" / "python"
    ready = folder / "ready"
    wanted = " ".join(NEEDS[name])
    if not ready.exists() or ready.read_text() != wanted:
        print(f"installing {wanted}", file=sys.stderr)
        common.run([sys.executable, "-m", "venv", "--clear", folder])
        common.run([python, "-m", "pip", "install", "--quiet", *NEEDS[name]], timeout=1200)
        ready.write_text(wanted)
    return python


def export(view: View, folder: Path) -> None:
    """Write the scene for the other renderers (renderers/shared.py says what is in it)."""
    # One tile for the whole cone: the others have one map, which they fit to nothing.
    scene, camera = ours.open_scene(view, redraw_shadows=True, exposure=1.0, shadow_fit=False)
    light = lighting.in_order(scene.lights)[0]
    with ours.Renderer(ours.SIZE) as renderer:
        gpu_scene = renderer.open(scene)
        ours.draw(renderer, scene, camera)
        block = np.frombuffer(gpu_scene.frame_block.read(), blocks.FRAME)[0]
    arrays: dict[str, np.ndarray] = {
        name + "s": scene.mesh.vertices[name] for name in ("position", "normal", "texcoord")
    }
    images = [np.full((1, 1, 4), 255, np.uint8)]
    numbers: dict[str | None, int] = {None: 0}
    for path, (_, image) in zip(scene.images, decode_all(scene.archive, scene.images), strict=True):
        numbers[path] = len(images) if isinstance(image, Image) else 0
        images += [image.pixels] if isinstance(image, Image) else []
    arrays |= {f"image{k}": image for k, image in enumerate(images)}
    parts: list[dict[str, Any]] = []
    owner = np.repeat(scene.mesh.faces["material"], scene.mesh.faces["index_count"])
    for number, material in enumerate(scene.materials):
        triangles = scene.mesh.indices[owner == number].reshape(-1, 3)
        if material.blend is not None or material.shade is not Shade.LIT or not len(triangles):
            continue
        arrays[f"indices{len(parts)}"] = np.ascontiguousarray(triangles[:, ::-1])
        cut_out = material.alpha_test is not None or material.sides is not Sides.FRONT
        parts.append({"image": numbers.get(material.image, 0), "cut_out": cut_out})
    folder.mkdir(parents=True, exist_ok=True)
    np.savez(folder / "scene.npz", **arrays)  # type: ignore[arg-type]
    about = {
        "size": ours.SIZE,
        "shadow_map_size": scene.settings.shadow_map_size,
        "parts": parts,
        "camera": _camera(camera, scene),
        "light": _light(light, scene, block),
        "frame_block": {name: block[name].tolist() for name in block.dtype.names},
        "shaders": _shaders(scene),
    }
    (folder / "scene.json").write_text(json.dumps(about))


def _camera(camera: Any, scene: Any) -> dict[str, Any]:
    return {
        "position": camera.position.tolist(),
        "yaw": camera.yaw,
        "pitch": camera.pitch,
        "world_from_view": np.linalg.inv(camera.view_from_world).tolist(),
        "fov_y": spaces.vertical_fov(camera.fov, ours.SIZE[0] / ours.SIZE[1]),
        "near": camera.near,
        "far": camera.far_for(*scene.mesh.bounds),
    }


def _light(light: Any, scene: Any, block: np.void) -> dict[str, Any]:
    yaw, pitch = spaces.angles_from_forward(light.direction)
    view = spaces.view_from_world(light.position, yaw, pitch)
    corners = spaces.box_corners(*(np.asarray(b, np.float64) for b in scene.mesh.bounds))
    along = (corners - light.position) @ light.direction
    shadow_from_world = block["shadow_from_world"][0].T
    clip_from_world = np.linalg.inv(spaces.SHADOW_FROM_CLIP) @ shadow_from_world
    return {
        "world_from_view": np.linalg.inv(view).tolist(),
        "half_angle": light.half_angle,
        "power": float(light.intensity.mean() / scene.metres_per_unit**2),
        "near": max(float(along.min()), 1.0),
        "far": float(along.max()),
        "clip_from_world": clip_from_world.T.tolist(),
    }


def _shaders(scene: Any) -> dict[str, str]:
    """GLSL of the opaque and the cut-out surface program and of the shadow pass."""
    common_macros = {
        "VIEW_FINAL": 0,
        "VIEW": "VIEW_FINAL",
        "LIGHTS": 1,
        "SHADOWS": 1,
        "ENCODED": 1,
        **lighting.constants(scene, scene.settings),
    }
    variants = {
        "surface": ("surface", common_macros),
        "cut_out": ("surface", common_macros | {"ALPHA_TEST": 1, "SIDES_BOTH": 1}),
        "shadow": ("shadow", {}),
    }
    return {
        f"{name}.{stage}": program.expand(f"{file}.{stage}", macros)[0]
        for name, (file, macros) in variants.items()
        for stage in ("vert", "frag")
    }


def run_other(name: str, folder: Path, frames: int) -> float:
    """Median milliseconds of a run of another renderer."""
    script = common.HERE / "renderers" / f"{name}_frame.py"
    variables = common.LLVMPIPE | {"VK_ICD_FILENAMES": VULKAN, "VK_DRIVER_FILES": VULKAN}
    ended = common.run([environment(name), script, folder, str(frames)], variables)
    return common.median(float(word) for word in ended.output.split())


def compare(view: View, names: list[str], frames: int, rounds: int) -> Comparison:
    """All renderers at one view, in turn."""
    folder = common.OUT / "renderers"
    export(view, folder)
    taken: dict[str, list[float]] = {"followspot": []}
    taken |= {"followspot, map kept": [], "followspot, culling off": []}
    taken |= {name: [] for name in names}
    for turn in range(rounds):
        taken["followspot"].append(ours.run(view, frames, redraw=True).median_ms)
        taken["followspot, map kept"].append(ours.run(view, frames, redraw=False).median_ms)
        all_faces = ["--redraw-shadows", "--set", "culling=false"]
        taken["followspot, culling off"].append(ours.bench(view, frames, *all_faces)[0].median_ms)
        for name in names:
            taken[name].append(run_other(name, folder, frames))
        print(f"round {turn + 1} of {rounds}: {view.name}", file=sys.stderr)
    return Comparison(f"{view.name}, ms a frame", taken)


def main() -> None:
    """Measure, print the table, keep it."""
    parser = common.parser(__doc__)
    parser.add_argument("--views", type=Path, default=common.VIEWS, help="file of views")
    parser.add_argument("--level", default="oa_dm5", help="the level whose views are measured")
    parser.add_argument("--only", action="append", choices=NEEDS, help="one of the renderers")
    parser.add_argument("--frames", type=int, default=60, help="counted frames a turn")
    parser.add_argument("--rounds", type=int, default=3, help="turns")
    arguments = parser.parse_args()
    common.need_file(VULKAN, "mesa-vulkan-drivers")
    common.two_cores()
    names = arguments.only or list(NEEDS)
    views = common.read_views(arguments.views, arguments.level)
    rows = [compare(view, names, arguments.frames, arguments.rounds) for view in views]
    common.report("renderers", "one shadowed light, the same mesh", rows)


if __name__ == "__main__":
    common.guarded(main)
