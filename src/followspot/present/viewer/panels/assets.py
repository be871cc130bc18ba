"""What the scene is made of: materials with their images, and what is missing."""

from dataclasses import replace

from imgui_bundle import imgui

from followspot.present.viewer.panels import thumbnail
from followspot.present.viewer.state import Seen, State
from followspot.scene.material import Laid, Material
from followspot.scene.scene import Scene

_EDGE = 40.0
"""Of a thumbnail."""


def show(state: State, seen: Seen) -> State:
    """Draw the panel."""
    scene = state.scene
    imgui.text(f"{scene.mesh.triangle_count:,} triangles, {len(scene.images)} images")
    imgui.text(f"{len(scene.crowd)} characters, {len(scene.props)} props")
    _problems(scene)
    if any(m.layer and m.layer.laid is Laid.GRAIN for m in scene.materials):
        changed, grain = imgui.checkbox("grain", state.settings.grain)
        imgui.set_item_tooltip("Images that make surfaces rougher when seen from near")
        if changed:
            state = state.with_settings(grain=grain)
    imgui.set_next_item_width(-1)
    changed, search = imgui.input_text_with_hint("##find", "find a material", state.asset_search)
    if changed:
        state = replace(state, asset_search=search)
    worn = dict.fromkeys(scene.worn)
    shown = [m for m in worn if search.strip().lower() in m.name.lower()]
    imgui.text_disabled(f"{len(shown)} of {len(worn)} materials")
    visible: list[Material] = []
    if imgui.begin_child("materials"):
        clipper = imgui.ListClipper()
        clipper.begin(len(shown), _EDGE + imgui.get_style().item_spacing.y)
        while clipper.step():
            visible += shown[clipper.display_start : clipper.display_end]
            for number in range(clipper.display_start, clipper.display_end):
                _material(shown[number], seen)
    imgui.end_child()
    asked = (*state.asked.thumbnails, *visible)
    return replace(state, asked=replace(state.asked, thumbnails=asked))


def _problems(scene: Scene) -> None:
    """What is missing, each with where it was looked for, and what else is wrong."""
    if scene.missing and imgui.tree_node(f"{len(scene.missing)} images are missing###missing"):
        for each in scene.missing:
            if imgui.tree_node(each.name):
                imgui.text_wrapped("\n".join(each.tried))
                imgui.tree_pop()
        imgui.tree_pop()
    if scene.problems and imgui.tree_node(f"{len(scene.problems)} problems###problems"):
        for problem in scene.problems:
            imgui.text_wrapped(str(problem))
        imgui.tree_pop()


def _material(material: Material, seen: Seen) -> None:
    thumbnail.show(material, _EDGE, seen.found)
    layer = material.layer.image if material.layer else None
    images = [image for image in (material.image, layer) if image is not None]
    imgui.set_item_tooltip(" + ".join(images) or "no image: white")
    imgui.same_line()
    imgui.begin_group()
    imgui.text(material.name)
    known = seen.found.thumbnails.get(material)
    size = "" if known is None or material.image is None else f", {known.size[0]} x {known.size[1]}"
    imgui.text_disabled(f"{_kind(material)}{size}")
    imgui.end_group()


def _kind(material: Material) -> str:
    kind = "blended" if material.blend else "cut out" if material.alpha_test else "solid"
    return f"{kind}, {'two sides' if material.is_two_sided else 'one side'}"
