"""Runs of key frames, the moments between them, and Quake III's ``animation.cfg``.

Sources: ``CG_ParseAnimationFile`` and ``CG_RunLerpFrame`` of ioquake3's ``cg_players.c``; where
they leave open what is legal, the players of OpenArena decided.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from followspot.arrays import Floats
from followspot.errors import AssetError

MAX_POSED_VERTICES = 1 << 22
"""Most vertices times frames of one model, either format.

The models of the games stay below a tenth of it. A small file could name more by letting its
lumps overlap, and would ask for any amount of memory when they are decoded.
"""

ANIMATION_NAMES = (
    *("both_death1", "both_dead1", "both_death2", "both_dead2", "both_death3", "both_dead3"),
    *("torso_gesture", "torso_attack", "torso_attack2", "torso_drop", "torso_raise"),
    *("torso_stand", "torso_stand2"),
    *("legs_walkcr", "legs_walk", "legs_run", "legs_back", "legs_swim", "legs_jump", "legs_land"),
    *("legs_jumpb", "legs_landb", "legs_idle", "legs_idlecr", "legs_turn"),
)
"""What the rows of an ``animation.cfg`` are, in their order: `b` is backward, `cr` crouched."""

TEAM_ANIMATION_NAMES = (
    *("torso_getflag", "torso_guardbase", "torso_patrol", "torso_followme"),
    *("torso_affirmative", "torso_negative"),
)
"""Rows that Team Arena's players have behind the others."""

_TOKEN = re.compile(
    r"""(?P<comment> //[^\n]* | /\*.*?(?:\*/|\Z) )
      | "(?P<quoted> [^"\n]* )"?
      | (?P<word> (?:(?!//)[^\s"])+ )""",
    re.VERBOSE | re.DOTALL,
)
_WHOLE = re.compile(r"[+-]?[0-9]{1,9}")
_DECIMAL = re.compile(r"[+-]?([0-9]{1,9}(\.[0-9]{0,9})?|\.[0-9]{1,9})")
_FLAGS = {"fixedlegs": "fixed_legs", "fixedtorso": "fixed_torso"}


class Pose(NamedTuple):
    """A moment between two key frames, of one figure or of n.

    Any two frames make a pose, also one of an old and one of a new animation while the one
    changes into the other.
    """

    frame: NDArray[np.intp]
    """() or (n,) key frame before the moment."""
    next_frame: NDArray[np.intp]
    """() or (n,) key frame behind it."""
    blend: Floats
    """() or (n,) from 0, at ``frame``, to 1, at ``next_frame``."""


@dataclass(frozen=True)
class Animation:
    """A run of key frames and how it is played.

    Args:
        first: Number of its first frame in the model.
        count: Number of frames, at least 1.
        looping: Number of last frames that repeat, 0 to ``count``; 0 holds the last frame.
        fps: Key frames a second, above 0.
        is_reversed: Whether the run is played from its last frame to its first.
    """

    first: int
    count: int
    looping: int
    fps: float
    is_reversed: bool = False

    @property
    def seconds(self) -> float:
        """How long one pass takes."""
        return self.count / self.fps

    def pose(self, seconds: ArrayLike) -> Pose:
        """Find the frames to show some time after the start.

        Args:
            seconds: () or (n,) time since the start; before it, the first frame is held.

        Returns:
            The pose, of the shape of ``seconds``. Where the run repeats, its last frame moves on
            to the one that follows it.
        """
        step = np.maximum(np.asarray(seconds, np.float64) * self.fps, 0.0)
        whole = np.floor(step)
        return Pose(self.frame_at(whole), self.frame_at(whole + 1), step - whole)

    def clipped(self, frame_count: int) -> Self:
        """Keep what lies within a model's frames, at least one."""
        first = min(self.first, frame_count - 1)
        count = min(self.count, frame_count - first)
        return replace(self, first=first, count=count, looping=min(self.looping, count))

    def frame_at(self, step: float | Floats) -> NDArray[np.intp]:
        """() or (n,) frames that are shown in whole steps from the start, which is step 0."""
        over = np.asarray(step - self.count)
        held = over % self.looping - self.looping if self.looping else -1.0
        place = np.where(over < 0, step, self.count + held)
        place = self.count - 1 - place if self.is_reversed else place
        return self.first + place.astype(np.intp)


@dataclass(frozen=True)
class AnimationConfig:
    """What an ``animation.cfg`` says.

    Args:
        animations: By the names in `ANIMATION_NAMES` and perhaps `TEAM_ANIMATION_NAMES`. Frames
            are those of the part that plays them: legs' frames count as in ``lower.md3``.
        sex: ``m``, ``f`` or ``n``; chooses voices.
        footsteps: Which sound they make.
        head_offset: Units by which the head is moved in the status bar; not in the world.
        fixed_legs: Whether the legs stay level under a turning view.
        fixed_torso: Whether the torso does.
    """

    animations: dict[str, Animation]
    sex: str = "m"
    footsteps: str = "default"
    head_offset: tuple[float, float, float] = (0.0, 0.0, 0.0)
    fixed_legs: bool = False
    fixed_torso: bool = False


class _Tokens:
    """The words of a text without its comments, each with its line."""

    def __init__(self, text: str, source: str) -> None:
        self.text = text
        self.source = source
        self._start = 0
        self._matches: Iterator[re.Match[str]] = _TOKEN.finditer(text)

    def next(self, expected: str | None = None) -> str | None:
        """The next word; at the end None, or an error where something is ``expected``."""
        for match in self._matches:
            word = match["word"] if match["quoted"] is None else match["quoted"]
            if word is not None:
                self._start = match.start()
                return word
        if expected is not None:
            self._start = len(self.text)
            raise self.error(expected, "the end of the file")
        return None

    def number(self, pattern: re.Pattern[str], expected: str) -> float:
        """The next word as a number of the pattern's kind."""
        word = self.next(expected) or ""
        if not pattern.fullmatch(word):
            raise self.error(expected, word[:40])
        return float(word)

    def error(self, expected: str, found: str) -> AssetError:
        line = self.text.count("\n", 0, self._start) + 1
        return AssetError(self.source, place=f"line {line}", expected=expected, found=found)


def parse_animation_config(text: str, source: str) -> AnimationConfig:
    """Parse an ``animation.cfg``: words about the player, then four numbers an animation.

    The numbers are first frame, count (negative: played backwards), looping frames and frames a
    second. The file counts the frames of all parts as one sequence, legs' behind the torso's;
    what the torso alone has is taken off the legs' frames here, as the game does.

    Args:
        text: The whole file.
        source: Its name for errors.

    Raises:
        AssetError: Fewer than 25 animations, or numbers that are none or make no sense; with the
            line. Unknown words in front of the numbers are passed over, as in the game.
    """
    tokens = _Tokens(text, source)
    said: dict[str, Any] = {}
    while (word := tokens.next()) is not None and not word[0:1].isdecimal():
        match word.lower():
            case "sex":
                said["sex"] = (tokens.next("m, f or n") or "")[:1].lower()
            case "footsteps":
                said["footsteps"] = (tokens.next("a kind of footsteps") or "").lower()
            case "headoffset":
                axes = (tokens.number(_DECIMAL, "a number of units") for _ in range(3))
                said["head_offset"] = tuple(axes)
            case "fixedlegs" | "fixedtorso" as flag:
                said[_FLAGS[flag]] = True
    return AnimationConfig(animations=_rows(tokens, word), **said)


def _rows(tokens: _Tokens, word: str | None) -> dict[str, Animation]:
    """Read the animations, the first word of which has been read already."""
    animations: dict[str, Animation] = {}
    skip = 0
    for name in (*ANIMATION_NAMES, *TEAM_ANIMATION_NAMES):
        if word is None:
            break
        if not _WHOLE.fullmatch(word) or int(word) < 0:
            raise tokens.error(f"the first frame of {name}", word[:40])
        first = int(word)
        if name == "legs_walkcr":
            skip = first - animations["torso_gesture"].first
        if name.startswith("legs_"):
            first -= skip
        if first < 0:
            found = f"{word}, which is {-first} too low"
            raise tokens.error(f"a frame of the legs for {name}", found)
        count = int(tokens.number(_WHOLE, f"the number of frames of {name}"))
        looping = int(tokens.number(_WHOLE, f"the number of looping frames of {name}"))
        fps = tokens.number(_DECIMAL, f"the frames a second of {name}")
        if looping < 0 or fps < 0:
            expected = f"looping frames and frames a second of {name} not below 0"
            raise tokens.error(expected, f"{looping} and {fps:g}")
        # OpenArena's merman has a turn of no frames at no frames a second.
        frames = max(abs(count), 1)
        animations[name] = Animation(first, frames, min(looping, frames), fps or 1.0, count < 0)
        word = tokens.next()
    if len(animations) < len(ANIMATION_NAMES):
        expected = f"{len(ANIMATION_NAMES)} animations"
        raise tokens.error(expected, f"{len(animations)}")
    return animations
