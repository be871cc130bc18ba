"""The scene file: what is kept of the present state, and under which name."""

from dataclasses import replace

from imgui_bundle import imgui

from followspot.present.viewer import saving
from followspot.present.viewer.state import Seen, State


def show(state: State, seen: Seen) -> State:
    """Draw the panel."""
    file = saving.own_file(state)
    if file is not None:
        imgui.text_wrapped(f"{file}")
    else:
        imgui.text_wrapped(f"{state.scene.name} gets a scene file of its own")
        imgui.set_next_item_width(-1)
        hint = str(saving.new_file(state).name)
        changed, save_as = imgui.input_text_with_hint("##file", hint, state.save_as)
        if changed:
            state = replace(state, save_as=save_as)
    if imgui.button("Save (F2)"):
        state = saving.saved(state)
    imgui.set_item_tooltip("Writes settings, lights, views and paths that have changed")
    imgui.separator_text("Views")
    imgui.set_next_item_width(imgui.get_content_region_avail().x * 0.55)
    changed, name = imgui.input_text_with_hint("##view", "name of this view", state.view_name)
    if changed:
        state = replace(state, view_name=name)
    imgui.same_line()
    imgui.begin_disabled(not state.view_name.strip())
    if imgui.button("Keep"):
        name = state.view_name.strip()
        state = replace(state.with_view(name), view_name="", notice=f"Kept {name}; now save it.")
    imgui.end_disabled()
    return state
