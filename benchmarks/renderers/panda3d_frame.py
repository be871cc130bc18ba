"""The exported scene in Panda3D with followspot's own surface and shadow shaders."""

import re

import numpy as np
import shared
from direct.showbase.ShowBase import ShowBase
from panda3d import core

core.load_prc_file_data(
    "",
    "load-display p3headlessgl\nwindow-type none\ngl-version 3 3\naudio-library-name null\n"
    "notify-level error\nsync-video false\ntextures-power-2 none\ngl-finish true\n",
)
NAMES = {
    "in_position": "p3d_Vertex",
    "in_normal": "p3d_Normal",
    "in_texcoord": "p3d_MultiTexCoord0",
    "base_image": "p3d_Texture0",
}
_BLOCK = re.compile(r"layout\(std140\) uniform Frame \{(.*?)\};", re.DOTALL)


def adapted(source: str) -> str:
    """A shader of followspot under Panda3D's names; it has no uniform blocks, so plain uniforms."""

    def plain(block: re.Match[str]) -> str:
        return re.sub(r"^(\s*)(mat4|vec4) ", r"\1uniform \2 ", block[1], flags=re.MULTILINE)

    source = _BLOCK.sub(plain, re.sub(r"^#line.*$", "", source, flags=re.MULTILINE))
    for ours, theirs in NAMES.items():
        source = re.sub(rf"\b{ours}\b", theirs, source)
    return source


def matrix(columns: list[list[float]]) -> core.LMatrix4f:
    """A matrix in GL's order; Panda3D's are for row vectors, which is the same order."""
    return core.LMatrix4f(*np.ravel(columns))


def set_inputs(node: core.NodePath, values: dict[str, list]) -> None:
    """The values of followspot's uniform block."""
    for name, value in values.items():
        shape = np.shape(value)
        if shape == (4, 4):
            node.set_shader_input(name, matrix(value))
        elif len(shape) == 3:
            array = core.PTA_LMatrix4f([matrix(each) for each in value])
            node.set_shader_input(name, array)
        elif len(shape) == 2:
            node.set_shader_input(name, core.PTA_LVecBase4f([core.LVecBase4f(*v) for v in value]))
        else:
            node.set_shader_input(name, core.LVecBase4f(*value))


def vertices(scene: shared.Exported) -> core.GeomVertexData:
    """All vertices, interleaved as in followspot."""
    data = core.GeomVertexData("level", core.GeomVertexFormat.get_v3n3t2(), core.Geom.UH_static)
    data.unclean_set_num_rows(len(scene.positions))
    rows = np.hstack([scene.positions, scene.normals, scene.texcoords]).astype(np.float32)
    memoryview(data.modify_array(0)).cast("B").cast("f")[:] = memoryview(rows.ravel())
    return data


def parts(scene: shared.Exported, root: core.NodePath) -> list[core.NodePath]:
    """One node for each texture, and what it is drawn with."""
    data = vertices(scene)
    images: dict[int, core.Texture] = {}
    nodes = []
    for part in scene.parts:
        triangles = core.GeomTriangles(core.Geom.UH_static)
        triangles.set_index_type(core.Geom.NT_uint32)
        array = triangles.modify_vertices()
        array.unclean_set_num_rows(part.indices.size)
        memoryview(array).cast("B").cast("I")[:] = memoryview(part.indices.ravel())
        geom = core.Geom(data)
        geom.add_primitive(triangles)
        node = core.GeomNode("part")
        node.add_geom(geom)
        path = root.attach_new_node(node)
        key = id(part.image)
        if key not in images:
            images[key] = texture(part.image)
        path.set_texture(images[key])
        path.set_two_sided(part.cut_out)
        if part.cut_out:
            path.set_shader_input("alpha_test", core.LVecBase2f(1.0, 1e-4 - 128 / 255))
        nodes.append(path)
    return nodes


def texture(image: np.ndarray) -> core.Texture:
    """A trilinear sRGB texture; row 0 stays at v = 0."""
    made = core.Texture()
    height, width = image.shape[:2]
    made.setup_2d_texture(width, height, core.Texture.T_unsigned_byte, core.Texture.F_srgb_alpha)
    made.set_ram_image(np.ascontiguousarray(image[..., [2, 1, 0, 3]]).tobytes())
    made.set_minfilter(core.SamplerState.FT_linear_mipmap_linear)
    made.set_magfilter(core.SamplerState.FT_linear)
    made.set_wrap_u(core.SamplerState.WM_repeat)
    made.set_wrap_v(core.SamplerState.WM_repeat)
    return made


def shader(sources: dict[str, str], name: str) -> core.Shader:
    """One of followspot's programs."""
    stages = (adapted(sources[f"{name}.{stage}"]) for stage in ("vert", "frag"))
    return core.Shader.make(core.Shader.SL_GLSL, *stages)


def shadow_pass(
    base: ShowBase, scene: shared.Exported, root: core.NodePath, sources: dict[str, str]
) -> core.Texture:
    """A depth buffer drawn from the light in every frame; gives its texture."""
    size = scene.about["shadow_map_size"]
    depth = core.Texture("shadow")
    depth.set_format(core.Texture.F_depth_component24)
    depth.set_minfilter(core.SamplerState.FT_shadow)
    depth.set_magfilter(core.SamplerState.FT_shadow)
    properties = core.FrameBufferProperties()
    properties.set_depth_bits(24)
    buffer = base.graphicsEngine.make_output(
        base.pipe, "shadow", -2, properties, core.WindowProperties.size(size, size),
        core.GraphicsPipe.BF_refuse_window, base.win.gsg, base.win,
    )  # fmt: skip
    buffer.add_render_texture(
        depth, core.GraphicsOutput.RTM_bind_or_copy, core.GraphicsOutput.RTP_depth
    )
    camera = core.Camera("light")
    camera.set_scene(root)
    camera.set_cull_bounds(core.OmniBoundingVolume())
    state = core.NodePath("state")
    state.set_shader(shader(sources, "shadow"), 100)
    state.set_shader_input("clip_from_world", matrix(scene.about["light"]["clip_from_world"]), 100)
    state.set_shader_input("world_from_object", core.LMatrix4f.ident_mat())
    state.set_attrib(core.CullFaceAttrib.make(core.CullFaceAttrib.M_cull_counter_clockwise), 100)
    camera.set_initial_state(state.get_state())
    region = buffer.make_display_region()
    region.set_camera(root.attach_new_node(camera))
    buffer.set_clear_depth_active(True)
    return depth


def main() -> None:
    """Draw the picture, then measure frames."""
    scene, frames = shared.read()
    sources = scene.about["shaders"]
    base = ShowBase(windowType="none")
    base.make_default_pipe()
    properties = core.FrameBufferProperties()
    properties.set_rgba_bits(8, 8, 8, 8)
    properties.set_depth_bits(24)
    size = core.WindowProperties.size(*scene.about["size"])
    base.win = base.graphicsEngine.make_output(
        base.pipe, "picture", 0, properties, size, core.GraphicsPipe.BF_refuse_window
    )
    root = core.NodePath("root")
    nodes = parts(scene, root)
    root.set_shader_input("shadow_atlas", shadow_pass(base, scene, root, sources))
    root.set_shader_input("world_from_object", core.LMatrix4f.ident_mat())
    set_inputs(root, scene.about["frame_block"])
    opaque, cut_out = shader(sources, "surface"), shader(sources, "cut_out")
    for node, part in zip(nodes, scene.parts, strict=True):
        node.set_shader(cut_out if part.cut_out else opaque)
    camera = core.Camera("eye")
    lens = core.PerspectiveLens()
    about = scene.about["camera"]
    lens.set_aspect_ratio(scene.about["size"][0] / scene.about["size"][1])
    lens.set_min_fov(about["fov_y"])
    lens.set_near_far(about["near"], about["far"])
    camera.set_lens(lens)
    eye = root.attach_new_node(camera)
    eye.set_pos(*about["position"])
    eye.set_hpr(about["yaw"] - 90, -about["pitch"], 0)
    region = base.win.make_display_region()
    region.set_camera(eye)
    base.win.set_clear_color((0, 0, 0, 1))
    base.win.set_clear_color_active(True)
    base.win.set_clear_depth_active(True)
    shot = core.PNMImage()
    base.graphicsEngine.render_frame()
    base.graphicsEngine.render_frame()
    base.win.get_screenshot(shot)
    shot.write(core.Filename.from_os_specific(str(scene.folder / "panda3d.ppm")))
    shared.measure(base.graphicsEngine.render_frame, frames)


if __name__ == "__main__":
    main()
