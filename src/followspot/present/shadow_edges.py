"""Where a shadow's true edge is near, as rays tell: no shadow map of some size can know better."""

import math
from collections.abc import Callable

import numpy as np

from followspot.arrays import Floats, Mask
from followspot.scene.light import SpotLight

EDGE_TEXELS = 2.0
"""Texels of the map: half a one of rounding, one of the bilinear comparison, half to spare."""

Reached = Callable[[Floats, Floats], Mask]
"""Points (n, 3) on faces of unit normals (n, 3) to (n,) whether they see the light's centre."""


def near_edge(
    position: Floats,
    face_normal: Floats,
    lit: Mask,
    light: SpotLight,
    radii: tuple[Floats, ...],
    reached: Reached,
) -> Mask:
    """Places with one nearby that is lit unlike them.

    Looked for on rings round each place as the light sees it, on the plane of the triangle. Where a
    ring leaves the plane before the light, the map's texels see it edge-on. A dark place is near an
    edge, too, if light passes by at its own distance from the light.

    Args:
        position: (n, 3) world, units.
        face_normal: (n, 3) unit, of the triangles.
        lit: (n,) whether they see the light's centre.
        light: Its centre and axis are looked at.
        radii: For each ring (n,) units across the axis.
        reached: Traces the rays; it is asked only of places not yet known to be near an edge.

    Returns:
        (n,).
    """
    right = np.cross(light.direction, np.eye(3)[np.abs(light.direction).argmin()])
    right /= np.linalg.norm(right)
    up = np.cross(light.direction, right)
    near = np.zeros(len(position), bool)
    for radius in radii:
        for angle in np.arange(8) * (math.pi / 4):
            left = np.flatnonzero(~near)
            normal = face_normal[left]
            away = position[left] - light.position
            aside = right * math.cos(angle) + up * math.sin(angle)
            ray = away + aside * radius[left, np.newaxis]
            with np.errstate(divide="ignore", invalid="ignore"):
                stretch = (away * normal).sum(axis=1) / (ray * normal).sum(axis=1)
            on_plane = (stretch > 0) & (stretch < 2)
            beside = light.position + ray * np.where(on_plane, stretch, 1)[:, np.newaxis]
            near[left] = ~on_plane | (reached(beside, normal) != lit[left])
            dark = np.flatnonzero(~near[left] & ~lit[left])
            near[left[dark]] = reached(light.position + ray[dark], normal[dark])
    return near
