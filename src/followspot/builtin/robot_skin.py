"""The robot's skin: paint, panel lines, vents, lamps, then wear and dust.

Everything is painted by where it lies on the robot, in units and in the pose at rest, not by where
that happens to be in the image. Colours are sRGB from 0 to 1. No light is painted in.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from followspot.arrays import Floats
from followspot.builtin.robot_atlas import Surface
from followspot.builtin.robot_model import Part
from followspot.builtin.texture_tools import mix, noise, smoothstep, tinted, to_image

PAINTS = {
    "teal": (0.10, 0.43, 0.47),
    "ivory": (0.86, 0.82, 0.71),
    "orange": (0.88, 0.42, 0.09),
    "steel": (0.36, 0.37, 0.39),
    "rubber": (0.15, 0.15, 0.165),
    "glass": (0.035, 0.05, 0.065),
    "lamp": (1.0, 0.84, 0.40),
}
_BARE = (0.60, 0.59, 0.57)
_SHADOW = (0.04, 0.05, 0.055)
_DUST = (0.63, 0.56, 0.44)
_GRIME = (0.13, 0.11, 0.09)
_GLOW = (1.0, 0.90, 0.55)
_RED, _GREEN = (0.95, 0.20, 0.12), (0.35, 0.95, 0.40)

_PAINTED = ("teal", "ivory", "orange")
"""Paints that chip off the metal below."""

_SOFT = 0.16
"""Units over which a painted border fades: about a texel."""


def _within(distance: Floats) -> Floats:
    """1 where a signed distance is below 0, 0 above, soft in between."""
    return smoothstep(_SOFT / 2, -_SOFT / 2, distance)


def _box(u: Floats, v: Floats, left: float, low: float, right: float, high: float) -> Floats:
    """Signed distance to a rectangle."""
    across = np.abs(u - (left + right) / 2) - (right - left) / 2
    up = np.abs(v - (low + high) / 2) - (high - low) / 2
    distance: Floats = np.maximum(across, up)
    return distance


class _Painter:
    """The skin under the brush; every method paints over what is there."""

    def __init__(self, parts: Sequence[Part], surface: Surface) -> None:
        self._names = [part.name for part in parts]
        self._surface = surface
        self.x, self.y, self.z = np.moveaxis(surface.place, 2, 0)
        paints = np.array([PAINTS[part.paint] for part in parts] + [(0.0, 0.0, 0.0)])
        self.colour = paints[surface.part]
        self.painted = np.array([p.paint in _PAINTED for p in parts] + [False])[surface.part]

    def on(self, name: str, axis: int | None = None, sign: int = 1) -> Floats:
        """1 on a part, or on its side that looks along an axis."""
        mask = self._surface.part == self._names.index(name)
        if axis is not None:
            mask &= self._surface.normal[..., axis] * sign > 0.72
        covered: Floats = mask.astype(np.float64)
        return covered

    def fill(self, mask: Floats, colour: Sequence[float]) -> None:
        """Paint an area."""
        self.colour = mix(self.colour, colour, mask)

    def groove(self, mask: Floats, distance: Floats, width: float = 0.22) -> None:
        """Cut a dark line where the distance is 0, its lower lip catching some light."""
        self.fill(mask * _within(np.abs(distance - width) - width / 2) * 0.22, (1, 1, 1))
        self.fill(mask * _within(np.abs(distance) - width / 2) * 0.85, _SHADOW)

    def dots(
        self, mask: Floats, u: Floats, v: Floats, places: Sequence[tuple[float, float]]
    ) -> None:
        """Set screws."""
        for a, b in places:
            distance = np.hypot(u - a, v - b)
            self.fill(mask * _within(distance - 0.48) * 0.8, _SHADOW)
            self.fill(mask * _within(distance - 0.33), _BARE)


def robot_skin(parts: Sequence[Part], surface: Surface) -> NDArray[np.uint8]:
    """Paint the skin.

    Args:
        parts: All parts.
        surface: What lies under each texel.

    Returns:
        (h, w, 3) uint8, sRGB.
    """
    painter = _Painter(parts, surface)
    _trunk(painter)
    _back(painter)
    _head(painter)
    _limbs(painter)
    _weather(painter, surface)
    _lamps(painter)
    painter.colour[surface.part < 0] = PAINTS["steel"]
    return to_image(painter.colour)


def _trunk(p: _Painter) -> None:
    trunk = p.on("trunk")
    p.fill(trunk * _within(_box(p.y, p.z, -99, 27.4, 99, 28.5)), PAINTS["ivory"])
    p.groove(trunk, p.z - 28.7)
    p.groove(trunk, p.z - 27.2)
    for sign in (1, -1):
        side = p.on("trunk", 1, sign)
        p.groove(side, p.x + 0.4)
        p.dots(side, p.x, p.z, [(-1.8, 30), (1, 30), (-1.8, 37.6), (1, 37.6)])
    p.groove(p.on("trunk", 2), np.hypot(p.x, p.y) - 4.2)
    front = p.on("trunk", 0)
    p.dots(front, p.y, p.z, [(-6.4, 30.2), (6.4, 30.2), (-6.8, 37.6), (6.8, 37.6)])

    panel = p.on("panel", 0)
    p.groove(panel, _box(p.y, p.z, -4.6, 30.2, 4.6, 37.0), 0.16)
    p.dots(panel, p.y, p.z, [(-4.0, 30.8), (4.0, 30.8), (-4.0, 36.4), (4.0, 36.4)])
    for low in (31.2, 32.3, 33.4):
        p.fill(panel * _within(_box(p.y, p.z, -2.9, low, 0.4, low + 0.55)), _SHADOW)
    dial = np.hypot(p.y - 2.3, p.z - 34.2)
    p.fill(panel * _within(dial - 1.75), _SHADOW)
    p.fill(panel * _within(dial - 1.4), (0.93, 0.91, 0.84))
    p.fill(panel * _within(np.abs(dial - 1.0) - 0.12) * (p.z > 33.8), (0.2, 0.2, 0.2))
    needle = np.abs((p.y - 2.3) - 0.5 * (p.z - 33.9)) - 0.13
    p.fill(panel * _within(needle) * (dial < 1.2) * (p.z > 33.9), PAINTS["orange"])
    p.fill(panel * _within(_box(p.y, p.z, -2.9, 35.0, 0.4, 36.3)), PAINTS["teal"])


def _back(p: _Painter) -> None:
    pack = p.on("pack", 0, -1)
    p.groove(pack, _box(p.y, p.z, -4.3, 29.8, 4.3, 37.7), 0.2)
    for low in (32.8, 34.0, 35.2, 36.4):
        p.fill(pack * _within(_box(p.y, p.z, -3.2, low, 3.2, low + 0.6)), _SHADOW)
    stripes = np.sin((p.y + p.z) * np.pi / 0.85)
    band = pack * _within(_box(p.y, p.z, -3.6, 30.4, 3.6, 31.7))
    p.fill(band, PAINTS["orange"])
    p.fill(band * smoothstep(-0.25, 0.25, stripes), _SHADOW)
    pelvis = p.on("pelvis", 0) + p.on("pelvis", 0, -1)
    p.groove(pelvis, np.abs(p.y) - 3.4)
    p.dots(pelvis, p.y, p.z, [(-4.4, 22.9), (4.4, 22.9)])


def _head(p: _Painter) -> None:
    skull = p.on("skull")
    upward = skull - p.on("skull", 2, -1)
    p.fill(upward * _within(np.abs(p.y) - 1.5) * (p.z > 48), PAINTS["ivory"])
    p.groove(skull, p.x - 2.6)
    p.groove(skull, p.z - 43.2)
    for sign in (1, -1):
        p.dots(p.on("skull", 1, sign), p.x, p.z, [(1.6, 50.2), (-3.4, 50.2), (-3.4, 44.4)])
    p.dots(p.on("skull", 2), p.x, p.y, [(1.6, 4.6), (1.6, -4.6), (-3.4, 4.6), (-3.4, -4.6)])
    back = p.on("skull", 0, -1)
    for low in (44.6, 45.7, 46.8):
        p.fill(back * _within(_box(p.y, p.z, -3.2, low, 3.2, low + 0.55)), _SHADOW)
    corners = [(y, z) for y in (-6.1, 6.1) for z in (43.4, 51.0)]
    p.dots(p.on("frame", 0), p.y, p.z, corners)
    ear = p.on("ear")
    away = np.hypot(p.x + 0.3, p.z - 47)
    p.groove(ear * (p.y > 9.2), away - 1.75, 0.3)
    p.fill(ear * (p.y > 9.2) * _within(away - 0.85), PAINTS["steel"])


def _limbs(p: _Painter) -> None:
    shoulder = p.on("shoulder")
    p.groove(shoulder, p.y - 11.4, 0.24)
    p.fill(shoulder * _within(np.hypot(p.x, p.z - 36.4) - 1.3) * (p.y > 12), PAINTS["steel"])
    forearm = p.on("forearm")
    p.fill(forearm * _within(_box(p.y, p.z, -99, 21.2, 99, 22.6)), PAINTS["ivory"])
    p.groove(forearm, p.z - 25.4)
    p.groove(p.on("knee"), np.hypot(p.x - 0.2, p.z - 13.4) - 1.5, 0.26)
    shin = p.on("shin", 0)
    p.fill(shin * _within(_box(p.y, p.z, 3.7, 5.6, 5.1, 10.8)), PAINTS["ivory"])
    p.groove(p.on("shin"), p.z - 5.5)
    foot = p.on("foot")
    p.fill(foot * smoothstep(4.0, 4.2, p.x), PAINTS["orange"])
    p.groove(foot, p.x - 4.0)
    p.fill(foot * _within(p.z - 0.95), PAINTS["rubber"])


def _weather(p: _Painter, surface: Surface) -> None:
    """Chip the paint along edges, streak and smear, and dust what is near the floor."""
    shape = surface.part.shape
    fine = noise(shape, 71, slope=0.7, coarsest=20)
    cloud = noise(shape, 72, slope=1.5, coarsest=120)
    ragged = noise(shape, 73, slope=1.15, coarsest=40)
    p.colour = tinted(p.colour, 0.022 * fine, 0.035 * cloud)
    rub = surface.edge - 0.28 * ragged
    p.fill(0.13 * p.painted * smoothstep(1.0, 0.1, rub), (1, 1, 1))
    chips = np.maximum(smoothstep(0.08, -0.08, rub), smoothstep(2.5, 2.7, ragged))
    p.fill(0.85 * p.painted * chips, _BARE)
    p.fill(0.35 * ~p.painted * smoothstep(0.5, 0, rub), _BARE)
    grime = smoothstep(0.5, 2.2, cloud) + 0.6 * smoothstep(0.2, -0.9, surface.normal[..., 2])
    p.fill(0.30 * grime, _GRIME)
    dust = smoothstep(13, -1, p.z) * (0.5 + 0.22 * cloud + 0.10 * fine)
    settled = 0.10 * smoothstep(0.7, 1.0, surface.normal[..., 2]) * (1 + 0.5 * cloud)
    p.fill(0.75 * dust + settled, _DUST)


def _lamps(p: _Painter) -> None:
    """What shines is clean and bright: eyes, mouth, the aerial's tip and the panel's lamps."""
    visor = p.on("visor", 0)
    p.fill(p.on("visor"), PAINTS["glass"])
    gloss = _within(np.abs(p.y + 0.5 * (p.z - 47) + 4.2) - 0.5)
    p.fill(visor * gloss * 0.16, (0.6, 0.8, 0.9))
    mouth = np.hypot(p.y, p.z - 46.9)
    p.fill(visor * _within(np.abs(mouth - 2.15) - 0.24) * (p.z < 45.55), _GLOW)
    for sign in (1, -1):  # a halo round each eye
        halo = np.hypot(p.y - 2.7 * sign, p.z - 47.3)
        p.fill(visor * 0.55 * smoothstep(3.4, 1.6, halo) ** 1.5, (0.75, 0.42, 0.08))
    eye = np.hypot(p.y - 2.7, p.z - 47.3)
    p.fill(p.on("eye"), (1.0, 0.66, 0.15))
    p.fill(p.on("eye") * smoothstep(1.75, 1.2, eye), (1.0, 0.93, 0.62))
    p.fill(p.on("eye") * smoothstep(1.0, 0.5, eye), (1.0, 1.0, 0.93))
    p.fill(p.on("tip"), _RED)
    panel = p.on("panel", 0)
    for y, colour in ((-2.3, _RED), (-1.25, _GLOW), (-0.2, _GREEN)):
        p.fill(panel * _within(np.hypot(p.y - y, p.z - 35.65) - 0.38), colour)
