"""Which keys do what."""

from imgui_bundle import imgui

from followspot.present.viewer.controls import KEYS
from followspot.present.viewer.state import Seen, State


def show(state: State, seen: Seen) -> State:
    """Draw the panel."""
    if imgui.begin_table("keys", 2):
        imgui.table_setup_column("key", imgui.TableColumnFlags_.width_fixed)
        imgui.table_setup_column("meaning", imgui.TableColumnFlags_.width_stretch)
        for key, meaning in KEYS:
            imgui.table_next_column()
            imgui.text(key)
            imgui.table_next_column()
            imgui.text_wrapped(meaning)
        imgui.end_table()
    return state
