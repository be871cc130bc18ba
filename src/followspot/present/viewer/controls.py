"""Keys and mouse, as ImGui tells them, to a new state."""

from dataclasses import replace

from imgui_bundle import imgui
from imgui_bundle.imgui import Key

from followspot.passes.view import View
from followspot.present.viewer import lamps, saving
from followspot.present.viewer.flight import Steering
from followspot.present.viewer.state import Look, Mouse, Shot, State, Tool
from followspot.present.viewer.walking import Walking

DEGREES_PER_PIXEL = 0.15
FAST, SLOW = 4.0, 0.25
KEYS = (
    ("W A S D, arrows", "fly, or walk"),
    ("Space, C", "up, down; walking: jump, crouch"),
    ("Shift, Ctrl", "fast, slow"),
    ("N", "walk instead of flying"),
    ("Wheel", "flying speed"),
    ("Right button", "hold to look around"),
    ("Middle button", "ask a pixel for its values"),
    ("M", "look without a button; M or Esc ends it"),
    ("1 to 9", "stage; with Alt, of the right half"),
    ("V", "split the picture in two"),
    ("L", "a new light where you are"),
    ("G", "the light's gizmo moves it, or turns it"),
    ("F", "freeze culling and fly on"),
    ("X", "measure the exposure here"),
    ("P", "stop time, or let it run"),
    ("F2", "save what has changed to the scene file"),
    ("F12, F11", "a screenshot; one of all stages"),
    ("F9, F10", "record a film; the flight as a path"),
    ("Tab", "hide or show all panels"),
)
"""For people: a key and what it does."""

_FORWARD, _BACK = (Key.w, Key.up_arrow), (Key.s, Key.down_arrow)
_LEFT, _RIGHT = (Key.a, Key.left_arrow), (Key.d, Key.right_arrow)
_UP, _DOWN = (Key.space,), (Key.c,)
_VIEW_KEYS = tuple((Key(Key._1 + number), view) for number, view in enumerate(View))


def apply(state: State, seconds: float, walking: Walking) -> State:
    """The state after a frame's keys and mouse.

    Args:
        state: Before them.
        seconds: What the frame counts as.
        walking: Moves the camera, in place of its flight, of those who walk.
    """
    if not imgui.get_io().want_text_input:
        state = _after_keys(state)
    state = replace(state, mouse=_mouse(state.mouse), time=state.time + seconds * state.runs)
    steering = _steering(state.mouse)
    if state.walks:
        return walking.after(state, seconds, steering)
    return replace(state, flight=state.flight.after(seconds, steering))


def _mouse(now: Mouse) -> Mouse:
    """What moving the mouse does from now on."""
    io = imgui.get_io()
    right = imgui.MouseButton_.right
    if io.app_focus_lost:
        return Mouse.POINTS
    if now is Mouse.POINTS and imgui.is_mouse_clicked(right) and not io.want_capture_mouse:
        return Mouse.LOOKS_WHILE_HELD
    if now is Mouse.LOOKS_WHILE_HELD and not imgui.is_mouse_down(right):
        return Mouse.POINTS
    return now


def _steering(mouse: Mouse) -> Steering:
    io = imgui.get_io()
    looks = mouse is not Mouse.POINTS
    yaw, pitch = (-io.mouse_delta.x, io.mouse_delta.y) if looks else (0.0, 0.0)
    notches = 0.0 if io.want_capture_mouse else io.mouse_wheel
    if io.want_text_input:
        return Steering()
    return Steering(
        forward=_held(_FORWARD) - _held(_BACK),
        left=_held(_LEFT) - _held(_RIGHT),
        up=_held(_UP) - _held(_DOWN),
        yaw=yaw * DEGREES_PER_PIXEL,
        pitch=pitch * DEGREES_PER_PIXEL,
        pace=(FAST if io.key_shift else 1.0) * (SLOW if io.key_ctrl else 1.0),
        notches=notches,
    )


def _held(keys: tuple[Key, ...]) -> int:
    return any(imgui.is_key_down(key) for key in keys)


def _after_keys(state: State) -> State:
    """The state after the keys that were pressed in this frame."""
    for key, view in _VIEW_KEYS:
        if _pressed(key):
            if not imgui.get_io().key_alt:
                state = replace(state, look=replace(state.look, view=view))
            else:
                state = replace(state, right=replace(state.right or state.look, view=view))
    if _pressed(Key.v):
        state = replace(state, right=None if state.right else Look(View.NORMALS))
    if _pressed(Key.g):
        state = replace(state, tool=Tool.TURN if state.tool is Tool.MOVE else Tool.MOVE)
    if _pressed(Key.n):
        state = replace(state, walks=not state.walks)
    if _pressed(Key.l):
        state = lamps.added(state)
    if _pressed(Key.f):
        state = replace(state, culled_from=None if state.culled_from else state.camera)
    if _pressed(Key.x):
        state = state.with_settings(exposure=None)
        state = replace(state, measured_exposures={})
    if _pressed(Key.p):
        state = replace(state, runs=not state.runs)
    if _pressed(Key.f2):
        state = saving.saved(state)
    for key, shot in ((Key.f12, Shot.PICTURE), (Key.f11, Shot.STAGES)):
        if _pressed(key):
            state = state.with_recording(shot=shot)
    if _pressed(Key.f9):
        state = state.with_recording(films=not state.recording.films)
    if _pressed(Key.f10):
        state = state.with_recording(flies=not state.recording.flies)
    if _pressed(Key.tab):
        state = replace(state, panels=not state.panels)
    if _pressed(Key.m):
        looks = Mouse.POINTS if state.mouse is Mouse.LOOKS else Mouse.LOOKS
        state = replace(state, mouse=looks)
    if _pressed(Key.escape) and state.mouse is Mouse.LOOKS:
        state = replace(state, mouse=Mouse.POINTS)
    return state


def _pressed(key: Key) -> bool:
    return imgui.is_key_pressed(key, repeat=False)
