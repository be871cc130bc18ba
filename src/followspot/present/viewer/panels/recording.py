"""Screenshots, films, and the camera's flight as a path; where their files go."""

from imgui_bundle import imgui

from followspot.present.viewer.state import Seen, Shot, State

SIZES = (None, (640, 480), (1280, 720), (1920, 1080), (3840, 2160))
"""Of films in pixels; none is the window's."""

_CLAMPED = imgui.SliderFlags_.always_clamp


def show(state: State, seen: Seen) -> State:
    """Draw the panel."""
    recording = state.recording
    imgui.set_next_item_width(imgui.get_content_region_avail().x * 0.82)
    changed, folder = imgui.input_text("folder", recording.folder)
    imgui.set_item_tooltip("Where files go; they get names that nothing has yet")
    if changed:
        state = state.with_recording(folder=folder)
    if imgui.button("Screenshot (F12)"):
        state = state.with_recording(shot=Shot.PICTURE)
    imgui.same_line()
    if imgui.button("All stages (F11)"):
        state = state.with_recording(shot=Shot.STAGES)
    imgui.separator_text("Film")
    state = _film(state)
    imgui.separator_text("Path for films")
    if imgui.button("End the path (F10)" if recording.flies else "Record a path (F10)"):
        state = state.with_recording(flies=not recording.flies)
    imgui.set_item_tooltip("How the camera flies, to be saved with the scene")
    return state


def _film(state: State) -> State:
    recording = state.recording
    if imgui.button("End the film (F9)" if recording.films else "Record a film (F9)"):
        state = state.with_recording(films=not recording.films)
    imgui.begin_disabled(recording.films)
    imgui.push_item_width(imgui.get_content_region_avail().x * 0.55)
    names = ["as the window" if size is None else f"{size[0]} x {size[1]}" for size in SIZES]
    changed, number = imgui.combo("size", SIZES.index(recording.size), names)
    if changed:
        state = state.with_recording(size=SIZES[number])
    changed, fps = imgui.slider_int("frames/s", recording.fps, 10, 120, "%d", _CLAMPED)
    if changed:
        state = state.with_recording(fps=fps)
    imgui.pop_item_width()
    for by_clock, label, meaning in (
        (False, "every frame", "Each frame of the window is one of the film: 1/fps of its time"),
        (True, "real time", "Frames are repeated or left out, as time goes by"),
    ):
        imgui.same_line() if by_clock else None
        if imgui.radio_button(label, recording.by_clock is by_clock):
            state = state.with_recording(by_clock=by_clock)
        imgui.set_item_tooltip(meaning)
    imgui.end_disabled()
    return state
