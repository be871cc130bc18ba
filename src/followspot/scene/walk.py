"""Ways that characters go: along a line, turning with it, at a speed that fits their steps."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from followspot.assets.animation import Animation
from followspot.errors import UsageError
from followspot.scene.figure import Figure

SPACING = 8.0
"""Units between the places at which a way is known."""

TURN = 24.0
"""Units before and behind a place between which its heading is taken: corners are rounded."""

RUN_SPEED = 320.0
"""Units a second of a player in the game (``g_speed``), for animations without steps."""

MAX_LENGTH = 1e6
"""Units of the longest way."""

_CONTACT = 2.0
"""Units above the lowest vertex within which a foot stands on the floor."""

_SLOWEST = 60.0
"""Units a second: what moves back more slowly is no foot, but the hem of something that floats."""


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

    places: NDArray[np.float64]
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

    Heights are the points' own, to be put on the ground with `dropped`.

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

    def point(distance: NDArray[np.float64]) -> NDArray[np.float64]:
        distance = distance % length if is_closed else np.clip(distance, 0.0, length)
        return np.stack([np.interp(distance, ends, points[:, k]) for k in range(3)], axis=1)

    ahead = point(at + TURN)[:, :2] - point(at - TURN)[:, :2]
    # A way that turns back on itself has no direction at its end: the last one goes on.
    has_none = np.linalg.norm(ahead, axis=1) < 1e-6
    source = np.maximum.accumulate(np.where(has_none, 0, np.arange(len(at))))
    yaw = np.unwrap(np.arctan2(ahead[:, 1], ahead[:, 0])[source])
    places = np.concatenate([point(at), np.degrees(yaw)[:, np.newaxis]], axis=1)
    return Walk(places, length / count, speed, is_closed)


def stride_speed(figure: Figure, legs: Animation) -> float:
    """Units a second at which feet on the floor don't slide; 0 where no foot tells.

    While a foot stands, it moves back under the body as fast as the body moves on. So of each two
    neighbouring frames the vertices next to the floor are looked at: the median of the speeds at
    which they move back, if they do, is the figure's.
    """
    lower = next((part for part in figure.parts if part.slot == 0), None)
    if lower is None or not lower.vertex_count or legs.count < 2:
        return 0.0
    steps = np.arange(legs.count if legs.looping == legs.count else legs.count - 1)
    pose = legs.pose((steps + 0.5) / legs.fps)  # in the middle, where rounding moves no frame
    a, b = (lower.positions[f].astype(np.float64) for f in (pose.frame, pose.next_frame))
    height = np.maximum(a[..., 2], b[..., 2])
    back = (a - b)[height <= height.min() + _CONTACT][:, 0] * legs.fps
    speed = float(np.median(back[back > 0])) if (back > 0).any() else 0.0
    return speed if speed >= _SLOWEST else 0.0
