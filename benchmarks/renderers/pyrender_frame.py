"""One shadowed spot light on the exported scene in pyrender, with EGL."""

import os

os.environ["PYOPENGL_PLATFORM"] = "egl"

import numpy as np
import pyrender
import pyrender.renderer
import shared
from OpenGL import GL
from PIL import Image


def build(scene: shared.Exported) -> pyrender.Scene:
    """The scene's nodes: one mesh with a primitive for each texture."""
    about = scene.about
    images: dict[int, pyrender.Texture] = {}
    primitives = []
    for part in scene.parts:
        key = id(part.image)
        if key not in images:
            sampler = pyrender.Sampler(
                magFilter=GL.GL_LINEAR,
                minFilter=GL.GL_LINEAR_MIPMAP_LINEAR,
                wrapS=GL.GL_REPEAT,
                wrapT=GL.GL_REPEAT,
            )
            images[key] = pyrender.Texture(
                source=Image.fromarray(part.image), source_channels="RGBA", sampler=sampler
            )
        material = pyrender.MetallicRoughnessMaterial(
            baseColorTexture=images[key],
            metallicFactor=0.0,
            roughnessFactor=1.0,
            alphaMode="MASK" if part.cut_out else "OPAQUE",
            doubleSided=part.cut_out,
        )
        # Its textures have v up, as in glTF files loaded by trimesh.
        texcoords = np.stack([scene.texcoords[:, 0], 1 - scene.texcoords[:, 1]], axis=1)
        primitives.append(
            pyrender.Primitive(
                positions=scene.positions,
                normals=scene.normals,
                texcoord_0=texcoords,
                indices=part.indices,
                material=material,
            )
        )
    world = pyrender.Scene(ambient_light=[0.3] * 3, bg_color=[0, 0, 0])
    world.add(pyrender.Mesh(primitives))
    width, height = about["size"]
    camera = about["camera"]
    world.add(
        pyrender.PerspectiveCamera(
            np.radians(camera["fov_y"]), camera["near"], camera["far"], width / height
        ),
        pose=np.array(camera["world_from_view"]),
    )
    light = about["light"]
    spot = pyrender.SpotLight(
        color=np.ones(3),
        intensity=light["power"],
        innerConeAngle=light["half_angle"] * 0.7,
        outerConeAngle=light["half_angle"],
    )
    world.add(spot, pose=np.array(light["world_from_view"]))
    return world


def main() -> None:
    """Draw the picture, then measure frames."""
    scene, frames = shared.read()
    for module in (pyrender.renderer, pyrender.light):
        module.SHADOW_TEX_SZ = scene.about["shadow_map_size"]
    renderer = pyrender.OffscreenRenderer(*scene.about["size"])
    world = build(scene)
    flags = pyrender.RenderFlags.SHADOWS_SPOT
    picture, _ = renderer.render(world, flags=flags)
    shared.save(picture, scene, "pyrender")
    # Frames are to end when they are drawn; copying the picture out of GL is left out.
    renderer._renderer._read_main_framebuffer = lambda *_: GL.glFinish()
    shared.measure(lambda: renderer.render(world, flags=flags), frames)


if __name__ == "__main__":
    main()
