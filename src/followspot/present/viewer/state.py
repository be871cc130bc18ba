"""What a person has chosen in the window, and what was seen of the last frames: plain data."""

import enum
import os
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Self

import msgspec

from followspot.passes.frame import FrameInput, FrameReport
from followspot.passes.overlay import Overlay
from followspot.passes.view import View
from followspot.present.viewer.asking import Asked, Found
from followspot.present.viewer.flight import Flight
from followspot.present.viewer.history import History
from followspot.scene.camera import Camera
from followspot.scene.light import Light
from followspot.scene.scene import Scene
from followspot.scene.settings import Settings

LONGEST_FRAME = 0.1
"""Seconds that a frame counts as at most: nobody wants to be elsewhere after a hitch."""

PLAIN_ALBEDO = 0.5
"""What everything reflects where textures are off."""


class Mouse(enum.Enum):
    """What moving the mouse does."""

    POINTS = "points"
    LOOKS_WHILE_HELD = "looks while held"
    LOOKS = "looks"


class Tool(enum.Enum):
    """What dragging a light's gizmo does."""

    MOVE = "move"
    TURN = "turn"


@dataclass(frozen=True)
class Look:
    """How one half of a split picture differs from what the settings say.

    Attributes:
        view: The stage that it shows.
        shadows: Whether lights are tested against their shadow maps.
        sky_light: Whether the environment lights surfaces.
        textures: Whether surfaces have them; else they reflect `PLAIN_ALBEDO`.
    """

    view: View = View.FINAL
    shadows: bool = True
    sky_light: bool = True
    textures: bool = True

    def settings(self, common: Settings) -> Settings:
        """The settings with this look's own switches."""
        plain = PLAIN_ALBEDO if common.albedo is None else common.albedo
        albedo = None if self.textures else plain
        return msgspec.structs.replace(
            common, shadows=self.shadows, sky_light=self.sky_light, albedo=albedo
        )


@dataclass(frozen=True)
class Lamp:
    """A light that can be switched off and is still there.

    Attributes:
        light: As it is now.
        is_on: Whether it shines.
        number: Of the scene file's light that it was; none if it was not in one.
    """

    light: Light
    is_on: bool = True
    number: int | None = None


class Shot(enum.Enum):
    """What a screenshot has."""

    PICTURE = "picture"
    STAGES = "all stages"


@dataclass(frozen=True)
class Recording:
    """What is recorded, and how.

    Attributes:
        folder: Where files go.
        size: (width, height) of a film in pixels; none is the window's.
        fps: Frames a second of a film.
        by_clock: Whether a film shows what the window showed as time went by. Else each frame of
            the window is one of the film, and however long it took, 1/fps passes in it.
        films: Whether a film is being recorded.
        flies: Whether the camera's flight is, as a path.
        shot: A screenshot to take next.
    """

    folder: str = field(default_factory=os.getcwd)
    size: tuple[int, int] | None = None
    fps: int = 30
    by_clock: bool = False
    films: bool = False
    flies: bool = False
    shot: Shot | None = None

    @property
    def place(self) -> Path:
        """The folder, in which a tilde is the user's home."""
        return Path(os.path.expanduser(self.folder))  # noqa: PTH111 - pathlib's may raise

    @property
    def is_stepped(self) -> bool:
        """Whether time goes on by the film's frames."""
        return self.films and not self.by_clock

    def seconds(self, passed: float) -> float:
        """What a frame counts as, if so many seconds have passed by the clock."""
        return 1 / self.fps if self.is_stepped else min(passed, LONGEST_FRAME)


@dataclass(frozen=True, eq=False)
class State:
    """All that keys, mouse and panels choose. They give back a new one; nothing else changes it.

    Attributes:
        scene: As it was opened.
        settings: The scene's, as changed since.
        lamps: The scene's lights, as changed since.
        environment_constant: The scene's, as changed since.
        flight: The camera.
        walks: Whether it is the eye of somebody who walks instead of flying.
        look: What is shown; with a split, in its left half.
        right: What the right half shows; none is no split.
        divider: Share of the width that is left of the split.
        overlays: Lines drawn over the picture.
        culled_from: A camera that decides in place of the flying one what is drawn.
        measured_exposures: What suited the views that are metered when they were measured last;
            they hold while the settings give none.
        time: Seconds by which characters and surfaces move.
        runs: Whether that time goes on.
        selected: Number of the lamp that is being edited.
        tool: What its gizmo does.
        recording: What is recorded.
        asked: What panels want to know.
        follows_pixel: Whether the pixel that was picked is looked at again as things change.
        map_view: Of the shadow map's panel: its middle across and down, and how much it is zoomed.
        map_light: Number of the light whose map that is.
        sky_level: MIP level of the sky that its panel shows.
        asset_search: Typed over the list of materials.
        frame_limit: Frames a second at most.
        panels: Whether the panels are there.
        mouse: What moving it does.
        assets: Game folders and pk3 files that levels are looked for in first.
        items: Whether the scene was opened with its level's pick-ups.
        animation: What the scene's model was told to do, if it was.
        wanted: Name of a level or scene to open next.
        search: Typed over the list of levels.
        view_name: Typed for a view that is to be kept.
        save_as: Typed for the file of a scene that has none.
        notice: One line for the person: what went wrong, or what was done.
    """

    scene: Scene
    settings: Settings
    lamps: tuple[Lamp, ...]
    environment_constant: float
    flight: Flight
    look: Look = Look()
    walks: bool = False
    right: Look | None = None
    divider: float = 0.5
    overlays: frozenset[Overlay] = frozenset()
    culled_from: Camera | None = None
    measured_exposures: Mapping[View, float] = field(default_factory=dict)
    time: float = 0.0
    runs: bool = True
    selected: int | None = None
    tool: Tool = Tool.MOVE
    recording: Recording = field(default_factory=Recording)
    asked: Asked = field(default_factory=Asked)
    follows_pixel: bool = False
    map_view: tuple[float, float, float] = (0.5, 0.5, 1.0)
    map_light: int = 0
    sky_level: int = 0
    asset_search: str = ""
    frame_limit: int = 60
    panels: bool = True
    mouse: Mouse = Mouse.POINTS
    assets: tuple[Path, ...] = ()
    items: bool = False
    animation: str | None = None
    wanted: str | None = None
    search: str = ""
    view_name: str = ""
    save_as: str = ""
    notice: str = ""

    @classmethod
    def of(cls, scene: Scene, camera: Camera) -> Self:
        """What a scene starts with."""
        look = Look(
            shadows=scene.settings.shadows,
            sky_light=scene.settings.sky_light,
            textures=scene.settings.albedo is None,
        )
        lamps = tuple(
            Lamp(light, number=None if scene.lights_chosen else number)
            for number, light in enumerate(scene.lights)
        )
        flight = Flight(camera).at(camera)
        return cls(scene, scene.settings, lamps, scene.environment_constant, flight, look)

    def opened(self, scene: Scene) -> "State":
        """Another scene from its first view on, looked at as this one is."""
        new = State.of(scene, scene.camera())
        return replace(
            self,
            scene=scene,
            settings=new.settings,
            lamps=new.lamps,
            environment_constant=new.environment_constant,
            flight=replace(new.flight, speed=self.flight.speed),
            culled_from=None,
            measured_exposures={},
            time=0.0,
            selected=None,
            asked=Asked(),
            map_light=0,
            items=False,
            animation=None,
            wanted=None,
            save_as="",
            notice="",
            recording=replace(self.recording, flies=False),
        )

    def jumped(self, camera: Camera) -> "State":
        """The camera elsewhere; the exposure is measured anew there."""
        return replace(self, flight=self.flight.at(camera), measured_exposures={})

    def with_view(self, name: str) -> "State":
        """The camera as one of the scene's views, which may be there already."""
        camera = replace(self.camera, name=name)
        scene = replace(self.scene, cameras={**self.scene.cameras, name: camera})
        return replace(self, scene=scene, flight=replace(self.flight, camera=camera))

    def with_lamp(self, number: int, lamp: Lamp) -> "State":
        """One lamp in place of another."""
        return replace(self, lamps=(*self.lamps[:number], lamp, *self.lamps[number + 1 :]))

    def with_settings(self, **changes: object) -> "State":
        """Some settings changed."""
        return replace(self, settings=msgspec.structs.replace(self.settings, **changes))

    def with_recording(self, **changes: object) -> "State":
        """Some of what is recorded changed."""
        recording = replace(self.recording, **changes)  # type: ignore[arg-type]
        return replace(self, recording=recording)

    @property
    def looks(self) -> tuple[Look, ...]:
        """What the picture or its halves show, from left to right."""
        return (self.look,) if self.right is None else (self.look, self.right)

    def look_at(self, across: float) -> Look:
        """What is shown at a share of the picture's width."""
        return self.look if self.right is None or across < self.divider else self.right

    @property
    def camera(self) -> Camera:
        """Where the picture is taken from."""
        return self.flight.camera

    @property
    def frame_rate_limit(self) -> int:
        """Frames a second at most; no more than those of a film that time goes by."""
        fps, limit = self.recording.fps, self.frame_limit
        return min(fps, limit) if self.recording.is_stepped else limit

    def exposure_of(self, view: View) -> float:
        """Display value per radiance."""
        return self.settings.exposure or self.measured_exposures.get(view.metered, 1.0)

    @property
    def lit(self) -> Scene:
        """The scene under the lamps that are on."""
        return replace(
            self.scene,
            lights=tuple(lamp.light for lamp in self.lamps if lamp.is_on),
            environment_constant=self.environment_constant,
            settings=self.settings,
        )

    def frame(self, look: Look) -> FrameInput:
        """What the pipeline is to draw for one look."""
        return FrameInput(
            scene=self.lit,
            camera=self.camera,
            settings=look.settings(self.settings),
            exposure=self.exposure_of(look.view),
            view=look.view,
            time=self.time,
            overlays=self.overlays,
            culled_from=self.culled_from,
        )


@dataclass(frozen=True, eq=False)
class Seen:
    """What the last frames were like.

    Attributes:
        size: (width, height) of the picture in pixels.
        report: Of the last frame; with a split, of its left half.
        history: Times of the frames before it.
        recorded: What is being recorded, in words.
        levels: All levels and scenes that can be opened by name.
        found: What has been asked for.
    """

    size: tuple[int, int]
    report: FrameReport
    history: History
    recorded: str
    levels: tuple[str, ...]
    found: Found
