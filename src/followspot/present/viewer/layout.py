"""The window and its panels: which there are, and where they are at first."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from imgui_bundle import hello_imgui, imgui

from followspot.present.viewer.panels import (
    assets,
    environment,
    frame,
    keys,
    level,
    lights,
    pixel,
    places,
    recording,
    saving,
    shadow_map,
    stages,
)
from followspot.present.viewer.state import Seen, State

Show = Callable[[State, Seen], State]

INI = "followspot/viewer.ini"
"""Below the user's folder of settings; it remembers where the panels are."""

_LEFT, _LEFT_LOW, _RIGHT, _RIGHT_LOW = "Left", "LeftLow", "Right", "RightLow"


@dataclass(frozen=True)
class Panel:
    """One dockable window.

    Attributes:
        name: Its title.
        dock: The place that it has at first.
        show: Draws it.
    """

    name: str
    dock: str
    show: Show


PANELS = (
    Panel("Stages", _LEFT, stages.show),
    Panel("Shadow map", _LEFT, shadow_map.show),
    Panel("Save", _LEFT, saving.show),
    Panel("Places", _LEFT_LOW, places.show),
    Panel("Level", _LEFT_LOW, level.show),
    Panel("Assets", _LEFT_LOW, assets.show),
    Panel("Lights", _RIGHT, lights.show),
    Panel("Recording", _RIGHT, recording.show),
    Panel("Keys", _RIGHT, keys.show),
    Panel("Frame", _RIGHT_LOW, frame.show),
    Panel("Environment", _RIGHT_LOW, environment.show),
    Panel("Pixel", _RIGHT_LOW, pixel.show),
)


def runner_params(size: tuple[int, int], show: Callable[[Panel], None]) -> hello_imgui.RunnerParams:
    """A window of a size, with all panels; `show` begins, fills and ends one."""
    params = hello_imgui.RunnerParams()
    params.app_window_params.window_title = "followspot"
    params.app_window_params.window_geometry.size = size
    params.renderer_backend_options.open_gl_options.anti_aliasing_samples = 0
    params.fps_idling.enable_idling = False
    params.ini_folder_type = hello_imgui.IniFolderType.app_user_config_folder
    params.ini_filename = INI
    params.ini_disable = not _has_folder_for_ini()
    window_type = hello_imgui.DefaultImGuiWindowType.provide_full_screen_dock_space
    params.imgui_window_params.default_imgui_window_type = window_type
    params.imgui_window_params.show_status_fps = False
    params.imgui_window_params.remember_status_bar_settings = False
    params.docking_params.docking_splits = _splits()
    params.docking_params.dockable_windows = [_window(panel, show) for panel in PANELS]
    return params


def _has_folder_for_ini() -> bool:
    """Make sure of it; Hello ImGui would end the program if it cannot."""
    config = hello_imgui.ini_folder_location(hello_imgui.IniFolderType.app_user_config_folder)
    try:
        (Path(config) / INI).parent.mkdir(parents=True, exist_ok=True)
    except OSError:
        return False
    return True


def show_bars(params: hello_imgui.RunnerParams, *, are_shown: bool) -> None:
    """Show or hide menu and status bar."""
    bars = params.imgui_window_params
    bars.show_menu_bar = bars.show_status_bar = are_shown


def _splits() -> list[hello_imgui.DockingSplit]:
    main = "MainDockSpace"
    return [
        hello_imgui.DockingSplit(main, _LEFT, imgui.Dir.left, 0.23),
        hello_imgui.DockingSplit(_LEFT, _LEFT_LOW, imgui.Dir.down, 0.39),
        hello_imgui.DockingSplit(main, _RIGHT, imgui.Dir.right, 0.3),
        hello_imgui.DockingSplit(_RIGHT, _RIGHT_LOW, imgui.Dir.down, 0.6),
    ]


def _window(panel: Panel, show: Callable[[Panel], None]) -> hello_imgui.DockableWindow:
    """A dockable window that `show` begins and ends; left out of a frame it keeps its place."""
    window = hello_imgui.DockableWindow(panel.name, panel.dock, lambda: show(panel))
    window.call_begin_end = False
    return window
