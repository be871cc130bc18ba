"""Ways that characters go: along a line, turning with it, at a speed that fits their steps."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from followspot.arrays import Floats, Mask
from followspot.assets.animation import Animation
from followspot.errors import UsageError
from followspot.game import RUN_SPEED
from followspot.scene.figure import Figure

SPACING = 8.0
"""Units between the places at which a way is known."""

TURN = 24.0
"""Units before and behind a place between which its heading is taken: corners are rounded."""

_SHARES = {"walk": 0.5, "walkcr": 0.25}
"""Of the running speed, in animations that the game plays at less: its walking button halves what
is asked for, and crouching quarters it (``pm_duckScale``)."""

MAX_LENGTH = 1e6
"""Units of the longest way."""

_CONTACT = 2.0
"""Units above the lowest vertex within which a foot stands on the floor."""

_SLOWEST = 10.0
"""Units a second, 0.3 m: what moves back more slowly is the swaying of who stands."""

_MOST_SLIDE = 0.9
"""Of the way that a figure makes: where standing feet slide farther, they are none."""


@dataclass(frozen=True, eq=False)
class Walk:
    """A way on the ground; standing is a way of one place.

    Attributes:
        places: (k, 4) x, y, z in units and yaw in degrees, evenly apart along the way; the yaw
            goes on without jumps.
        spacing: Units from place to place.
        speed: Units a second.
        is_closed: Whether the last place is the first one again; if not, the way ends there.
    """

    places: Floats
    spacing: float = SPACING
    speed: float = 0.0
    is_closed: bool = False

    @property
    def length(self) -> float:
        """Units of the whole way."""
        return self.spacing * (len(self.places) - 1)


def standing(position: ArrayLike, yaw: float = 0.0) -> Walk:
    """A way of one place."""
    return Walk(np.array([[*np.asarray(position, np.float64).reshape(3), yaw]]))


def along(points: ArrayLike, speed: float, *, is_closed: bool = False) -> Walk:
    """A way along straight lines between points; its heading follows it.

    Heights are the points' own, to be put on the ground by who makes it.

    Args:
        points: (n, 3) units.
        speed: Units a second.
        is_closed: Whether it leads back to the first point.

    Raises:
        UsageError: the points are in one place, or absurdly far apart.
    """
    points = np.asarray(points, np.float64).reshape(-1, 3)
    if is_closed:
        points = np.concatenate([points, points[:1]])
    steps = np.linalg.norm(np.diff(points[:, :2], axis=0), axis=1)
    ends = np.concatenate([[0.0], np.cumsum(steps)])
    length = float(ends[-1])
    if not 1.0 <= length <= MAX_LENGTH:
        raise UsageError(f"expected a path of 1 to {MAX_LENGTH:g} units, found {length:g}")
    count = max(round(length / SPACING), 1)
    at = np.linspace(0.0, length, count + 1)

    def point(distance: Floats) -> Floats:
        distance = distance % length if is_closed else np.clip(distance, 0.0, length)
        return np.stack([np.interp(distance, ends, points[:, k]) for k in range(3)], axis=1)

    ahead = point(at + TURN)[:, :2] - point(at - TURN)[:, :2]
    # A way that turns back on itself has no direction at its end: the last one goes on.
    has_none = np.linalg.norm(ahead, axis=1) < 1e-6
    source = np.maximum.accumulate(np.where(has_none, 0, np.arange(len(at))))
    yaw = np.unwrap(np.arctan2(ahead[:, 1], ahead[:, 0])[source])
    places = np.concatenate([point(at), np.degrees(yaw)[:, np.newaxis]], axis=1)
    return Walk(places, length / count, speed, is_closed)


def fitting_speed(figure: Figure, legs: Animation) -> float:
    """Units a second at which a figure goes: as its stride wants it, else as in the game."""
    named = (share for name, share in _SHARES.items() if _is_named(figure, legs, name))
    return stride_speed(figure, legs) or RUN_SPEED * next(named, 1.0)


def _is_named(figure: Figure, legs: Animation, name: str) -> bool:
    return legs in (figure.animations.get(full) for full in (name, f"legs_{name}"))


def stride_speed(figure: Figure, legs: Animation) -> float:
    """Units a second at which feet on the floor hardly slide; 0 where no foot tells.

    While a foot stands, it moves back under the body as fast as the body moves on. So what is next
    to the floor and moves back is looked at, from each key frame of the loop to the next one: the
    speed is the median over these steps of the medians within them. None counts where fewer than
    half of the steps have such a foot (hopping), or where feet slide nearly as far as the
    figure gets on (a tail that sweeps the floor).
    """
    lower = next((part for part in figure.parts if part.slot == 0), None)
    if lower is None or not lower.vertex_count or legs.count < 2:
        return 0.0
    # Frames before the loop are shown once; of what does not loop, none follows the last frame.
    loops = legs.looping >= 2
    first = legs.count - legs.looping if loops else 0
    steps = np.arange(first, legs.count - (not loops), dtype=np.float64)
    before, after = (
        lower.positions[legs.frame_at(k)].astype(np.float64) for k in (steps, steps + 1)
    )
    back = (before - after)[..., :2] * legs.fps
    height = np.maximum(before[..., 2], after[..., 2])
    lowest = height.min(axis=1, keepdims=True)
    stands = (height <= lowest + _CONTACT) & (back[..., 0] > 0)
    # In a run, both feet may be in the air; heights of standing feet differ a little, too.
    on_floor = (lowest <= np.quantile(lowest, 0.25) + _CONTACT)[:, 0]
    tells = on_floor & stands.any(axis=1)
    if 2 * np.count_nonzero(tells) < np.count_nonzero(on_floor):
        return 0.0
    stands, back = stands[tells], back[tells]
    speed = float(np.median(_medians(back[..., 0], stands)))
    slide = _medians(np.hypot(back[..., 0] - speed, back[..., 1]), stands).mean()
    return speed if speed >= _SLOWEST and slide <= _MOST_SLIDE * speed else 0.0


def _medians(values: Floats, chosen: Mask) -> Floats:
    """(n,) the median of each row of (n, vertices) values, of its chosen ones alone."""
    return np.asarray(np.nanmedian(np.where(chosen, values, np.nan), axis=1))
