"""What the scene is made of: materials with their images, and what is missing."""

from dataclasses import replace

from imgui_bundle import imgui

from followspot.present.viewer.inspection import THUMBNAIL
from followspot.present.viewer.state import Seen, State
from followspot.scene.material import Material


def show(state: State, seen: Seen) -> State:
    """Draw the panel."""
    scene = state.scene
    state = replace(state, asked=replace(state.asked, thumbnails=True))
    props = f", {len(scene.props)} props" if scene.props else ""
    imgui.text_wrapped(
        f"{scene.mesh.triangle_count:,} triangles, {len(scene.mesh.faces):,} faces, "
        f"{len(scene.crowd)} characters{props}"
    )
    _missing(state)
    imgui.set_next_item_width(-1)
    changed, search = imgui.input_text_with_hint("##find", "find a material", state.asset_search)
    if changed:
        state = replace(state, asset_search=search)
    worn = {m.name: m for m in (*scene.materials, *scene.crowd.materials)}
    shown = [m for name, m in worn.items() if search.lower() in name.lower()]
    imgui.text_disabled(f"{len(shown)} of {len(worn)} materials")
    if imgui.begin_child("materials"):
        clipper = imgui.ListClipper()
        clipper.begin(len(shown), THUMBNAIL + 4)
        while clipper.step():
            for number in range(clipper.display_start, clipper.display_end):
                _material(shown[number], seen)
    imgui.end_child()
    return state


def _missing(state: State) -> None:
    missing, problems = state.scene.missing, state.scene.problems
    if missing and imgui.tree_node(f"{len(missing)} images are missing###missing"):
        for each in missing:
            imgui.bullet_text(each.name)
            if imgui.is_item_hovered():
                imgui.set_tooltip("\n".join(each.tried))
        imgui.tree_pop()
    if problems and imgui.tree_node(f"{len(problems)} problems###problems"):
        for problem in problems:
            imgui.text_wrapped(str(problem))
        imgui.tree_pop()
    if not missing and not problems:
        imgui.text_disabled("Nothing is missing.")


def _material(material: Material, seen: Seen) -> None:
    texture = seen.found.thumbnails.get(material.image)
    if texture is None:
        imgui.dummy((THUMBNAIL, THUMBNAIL))
    else:
        imgui.image(imgui.ImTextureRef(texture.glo), (THUMBNAIL, THUMBNAIL))
    imgui.same_line()
    imgui.begin_group()
    imgui.text(material.name.rpartition("/")[2])
    imgui.text_disabled(_kind(material))
    imgui.end_group()
    if imgui.is_item_hovered():
        imgui.set_tooltip(f"{material.name}\n{material.image or 'no image: white'}")


def _kind(material: Material) -> str:
    kind = "blended" if material.blend else "cut out" if material.alpha_test else "solid"
    return f"{kind}, {'two sides' if material.is_two_sided else 'one side'}"
