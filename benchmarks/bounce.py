"""Light from sky and walls: as it is without `--bake`, with it, and by Mitsuba's path tracer.

Draws cameras of the built-in courtyard under its sun and a sky of one colour, all of one
reflectance, without what reaches surfaces straight from the sun, and compares radiance where all
three see the same solid surface. No times.
"""

import tempfile
from dataclasses import replace
from pathlib import Path

import common
import numpy as np
import ours
from msgspec.structs import replace as changed

from followspot.arrays import Floats, Mask
from followspot.present import mitsuba_scene
from followspot.present.raytracer import RayTracer
from followspot.scene import bounce
from followspot.scene.camera import Camera
from followspot.scene.light import SpotLight
from followspot.scene.load import load
from followspot.scene.scene import Scene

SIZE = (160, 120)
BLOCK = 8
"""Pixels along an edge of what is compared."""
ALBEDO, SKY = 0.5, 0.25
CAMERAS = ("title", "arcade", "cloister", "gallery", "stair", "gate", "fountain", "overview")


def uniform(name: str) -> Scene:
    """A scene under one sun and an even sky, without textures."""
    scene = load(name)
    sun = next(light for light in scene.lights if isinstance(light, SpotLight))
    white = replace(scene.sky, faces=np.full_like(scene.sky.faces, 255))
    settings = changed(scene.settings, albedo=ALBEDO, exposure=1.0)
    lit = replace(scene, sky=white, environment_constant=SKY, ambient=0.0, settings=settings)
    return lit.with_lights(sun)


def truth(mesh: Path, scene: Scene, camera: Camera, samples: int) -> Floats:
    """(h, w, 3) radiance by Mitsuba's path tracer, less that of the sun's light itself."""
    import mitsuba as mi

    mi.set_variant("scalar_rgb")  # LLVM 15 cannot compile this for every processor
    lamp = mitsuba_scene.emitter(mi, scene.lights[0], scene.metres_per_unit)
    grey = {"type": "diffuse", "reflectance": {"type": "rgb", "value": ALBEDO}}
    level = {"type": "ply", "filename": str(mesh), "bsdf": {"type": "twosided", "bsdf": grey}}
    sky = {"type": "constant", "radiance": {"type": "rgb", "value": SKY}}
    sampler = {"type": "independent", "sample_count": samples}
    sensor = mitsuba_scene.sensor(mi, camera, SIZE, sampler, scene.metres_per_unit)

    def radiance(depth: int, **emitters: object) -> Floats:
        world = mi.load_dict({"type": "scene", "level": level, **emitters})
        integrator = mi.load_dict({"type": "path", "max_depth": depth})
        picture = mi.render(world, integrator=integrator, sensor=sensor, spp=samples)
        return np.array(picture, np.float64)

    return radiance(bounce.BOUNCES + 2, lamp=lamp, sky=sky) - radiance(2, lamp=lamp)


def same_surface(tracer: RayTracer, scene: Scene, camera: Camera, depth: Floats) -> Mask:
    """(h, w) where the rasteriser's depth, in units, is that of what Mitsuba's rays meet."""
    hit = tracer._solid.ray_intersect(tracer._rays(camera, SIZE))
    way = np.asarray(hit.p, np.float64).reshape(3, -1).T / scene.metres_per_unit - camera.position
    along = (way @ camera.forward).reshape(SIZE[1], SIZE[0])
    return np.asarray(np.isfinite(depth) & (np.abs(along - depth) < 0.01 * depth))


def blocks(picture: Floats, where: Mask) -> Floats:
    """(n, 3) means of blocks of pixels of which most count: single paths scatter."""
    weights = where.reshape(SIZE[1] // BLOCK, BLOCK, -1, BLOCK).astype(float)
    values = picture.reshape(*weights.shape, 3)
    sums = np.einsum("ijkl,ijklc->ikc", weights, np.where(weights[..., np.newaxis] > 0, values, 0))
    count = weights.sum(axis=(1, 3))
    most = count > BLOCK**2 / 2
    return np.asarray(sums[most] / count[most][:, np.newaxis])


def main() -> None:
    """Measure, print the table, keep it."""
    parser = common.parser(__doc__)
    parser.add_argument("--samples", type=int, default=256, help="paths a pixel")
    arguments = parser.parse_args()
    flat = uniform("courtyard")
    baked = bounce.bake(flat)
    tracer = RayTracer(flat, ALBEDO)
    rows, figures, shown = [], {}, {}
    with ours.Renderer(SIZE) as renderer:
        for name in CAMERAS:
            camera = flat.cameras[name]
            taken = renderer.render(flat, camera, ["environment", "depth"], linear=True)
            traced = renderer.render(baked, camera, ["environment"], linear=True)["environment"]
            where = same_surface(tracer, flat, camera, taken["depth"])
            shown[name] = taken["environment"], traced, where
    with tempfile.TemporaryDirectory() as folder:
        mesh = Path(folder) / "level.ply"
        tracer._solid.shapes()[0].write_ply(str(mesh))
        for name, (*pictures, where) in shown.items():
            wanted = truth(mesh, flat, flat.cameras[name], arguments.samples)
            wanted, *found = (blocks(picture, where) for picture in (wanted, *pictures))
            means = [float(each.mean() / wanted.mean()) for each in found]
            errors = [float(np.abs(each - wanted).mean() / wanted.mean()) for each in found]
            figures[name] = {"means": means, "errors": errors}
            rows.append([name, *(f"{m:.2f}, {e:.2f}" for m, e in zip(means, errors, strict=True))])
    header = [
        "indirect radiance over Mitsuba's: mean; mean error",
        "sky's light everywhere",
        "--bake",
    ]
    common.write("bounce", common.markdown(header, rows), figures)


if __name__ == "__main__":
    common.guarded(main)
