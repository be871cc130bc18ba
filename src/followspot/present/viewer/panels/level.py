"""All levels and scenes that can be opened, with a field to search them."""

from dataclasses import replace

from imgui_bundle import imgui

from followspot.present.viewer.state import Seen, State


def show(state: State, seen: Seen) -> State:
    """Draw the panel."""
    imgui.text(f"{state.scene.name}: {state.scene.triangle_count:,} triangles")
    imgui.set_next_item_width(-1)
    entered, search = imgui.input_text_with_hint(
        "##search",
        "search, or a file; Enter opens",
        state.search,
        imgui.InputTextFlags_.enter_returns_true,
    )
    state = replace(state, search=search)
    found = matching(search, seen.levels)
    if entered:
        return replace(state, wanted=found[0] if found else search.strip() or None)
    if imgui.begin_child("levels"):
        for name in found:
            if imgui.selectable(name, name == state.scene.name)[0]:
                state = replace(state, wanted=name)
    imgui.end_child()
    return state


def matching(search: str, levels: tuple[str, ...]) -> list[str]:
    """Those that hold what was typed, those that begin with it in front."""
    typed = search.strip().lower()
    found = [name for name in levels if typed in name.lower()]
    return sorted(found, key=lambda name: not name.lower().startswith(typed))
