"""Which stage is shown, under which switches; two of them side by side; lines over the picture."""

from dataclasses import replace

from imgui_bundle import imgui

from followspot.passes.overlay import Overlay
from followspot.passes.view import View
from followspot.present.viewer.state import Look, Seen, State

_OVERLAYS = {
    Overlay.BOXES: ((1.0, 0.45, 0.4, 1.0), "Of objects: models, doors, props, characters"),
    Overlay.SCENE: ((1.0, 0.9, 0.3, 1.0), "The box of everything"),
    Overlay.LIGHT_FRUSTUM: ((0.5, 0.7, 1.0, 1.0), "What the lights' shadow maps cover"),
    Overlay.CAMERA_FRUSTUM: (
        (1.0, 1.0, 1.0, 1.0),
        "What is seen by the camera that culling is frozen at",
    ),
}
"""Their names' colours, about those of the lines, and what they show."""


def show(state: State, seen: Seen) -> State:
    """Draw the panel."""
    state = replace(state, look=_look("##left", state.look))
    imgui.separator_text("Split")
    changed, is_split = imgui.checkbox("Side by side (V)", state.right is not None)
    if changed:
        state = replace(state, right=Look(View.NORMALS) if is_split else None)
    if state.right is not None:
        state = replace(state, right=_look("##right", state.right))
    imgui.separator_text("Overlays")
    changed, is_frozen = imgui.checkbox("Freeze culling (F)", state.culled_from is not None)
    if changed:
        state = replace(state, culled_from=state.camera if is_frozen else None)
    for number, (overlay, (colour, meaning)) in enumerate(_OVERLAYS.items()):
        if number % 2:
            imgui.same_line(imgui.get_content_region_avail().x / 2)
        imgui.push_style_color(imgui.Col_.text, colour)
        if imgui.checkbox(overlay.value, overlay in state.overlays)[0]:
            state = replace(state, overlays=state.overlays ^ {overlay})
        imgui.pop_style_color()
        imgui.set_item_tooltip(meaning)
    return state


def _look(id_: str, look: Look) -> Look:
    """A list of all stages and the three switches of one half."""
    imgui.push_id(id_)
    if imgui.begin_table("views", 2):
        for number, view in enumerate(View, 1):
            imgui.table_next_column()
            if imgui.selectable(f"{number} {view}", view is look.view)[0]:
                look = replace(look, view=view)
        imgui.end_table()
    _, shadows = imgui.checkbox("Shadows", look.shadows)
    imgui.same_line()
    _, sky_light = imgui.checkbox("Sky light", look.sky_light)
    imgui.same_line()
    _, textures = imgui.checkbox("Textures", look.textures)
    imgui.pop_id()
    return replace(look, shadows=shadows, sky_light=sky_light, textures=textures)
