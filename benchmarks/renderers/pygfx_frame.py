"""One shadowed spot light on the exported scene in pygfx, on Mesa's software Vulkan."""

import numpy as np
import pygfx as gfx
import shared
import wgpu
from rendercanvas.offscreen import RenderCanvas


def build(scene: shared.Exported) -> tuple[gfx.Scene, gfx.PerspectiveCamera]:
    """The scene's objects: one mesh for each texture."""
    about = scene.about
    world = gfx.Scene()
    images: dict[int, gfx.Texture] = {}
    for part in scene.parts:
        key = id(part.image)
        if key not in images:
            images[key] = gfx.Texture(part.image, dim=2, colorspace="srgb", generate_mipmaps=True)
        geometry = gfx.Geometry(
            positions=scene.positions,
            normals=scene.normals,
            texcoords=scene.texcoords,
            indices=part.indices,
        )
        image = gfx.TextureMap(images[key], wrap="repeat", filter="linear", mipmap_filter="linear")
        material = gfx.MeshPhongMaterial(
            map=image,
            shininess=1,
            specular="#000",
            side="both" if part.cut_out else "front",
            alpha_test=0.5 if part.cut_out else 0.0,
        )
        mesh = gfx.Mesh(geometry, material)
        mesh.cast_shadow = mesh.receive_shadow = True
        world.add(mesh)
    light = about["light"]
    lamp = gfx.SpotLight(intensity=light["power"], angle=light["half_angle"], penumbra=0.3, decay=2)
    lamp.local.matrix = np.array(light["world_from_view"])
    lamp.cast_shadow = True
    size = about["shadow_map_size"]
    lamp.shadow._map_size = [size, size]
    lamp.shadow.camera.depth_range = light["near"], light["far"]
    world.add(gfx.AmbientLight("#fff", 0.3), lamp)
    width, height = about["size"]
    camera = gfx.PerspectiveCamera(
        about["camera"]["fov_y"],
        width / height,
        depth_range=(about["camera"]["near"], about["camera"]["far"]),
    )
    camera.local.matrix = np.array(about["camera"]["world_from_view"])
    return world, camera


def main() -> None:
    """Draw the picture, then measure frames."""
    scene, frames = shared.read()
    world, camera = build(scene)
    canvas = RenderCanvas(size=tuple(scene.about["size"]), pixel_ratio=1)
    renderer = gfx.WgpuRenderer(canvas, pixel_ratio=1, ppaa="none")
    canvas.request_draw(lambda: renderer.render(world, camera))
    shared.save(np.asarray(canvas.draw()), scene, "pygfx")
    target = gfx.Texture(dim=2, size=(*scene.about["size"], 1), format="rgba8unorm-srgb")
    offscreen = gfx.WgpuRenderer(target, pixel_ratio=1, ppaa="none")

    queue = offscreen.device.queue
    usage = wgpu.BufferUsage.COPY_SRC | wgpu.BufferUsage.COPY_DST
    little = offscreen.device.create_buffer(size=4, usage=usage)

    def frame() -> None:
        offscreen.render(world, camera)
        queue.read_buffer(little)  # comes when everything before it is done

    shared.measure(frame, frames)


if __name__ == "__main__":
    main()
