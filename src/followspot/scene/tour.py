"""A tour of a level, from place to place worth passing, on its lattice of points with room.

Places are spawn points, and open ones far from all others to which one may walk from there. It goes
always on to the nearest that has not been passed, preferably by ways not yet gone, with ground
below, and out of fog: levels in space are mostly nothing, and in fog there is nothing to see.
"""

import numpy as np

from followspot.arrays import Floats, Ints, Mask
from followspot.errors import UsageError
from followspot.scene import fog
from followspot.scene.gaze import Lookout
from followspot.scene.lattice import Cells, Lattice
from followspot.scene.level import Level
from followspot.scene.open_space import corners_within, opaque
from followspot.scene.scene import Scene, spawn_cameras
from followspot.scene.voxels import Voxels

_NEAR_SPAWN = 160.0  # units from a spawn point to a lattice point that stands for it
_ROOMY = 4  # steps of the lattice to walls, beyond which more is no better
_LOW, _HIGH = 88.0, 264.0  # units over the ground that places and ways are at most, if they can
_PLACES = 12  # besides spawn points
_STARTS = 8  # spawn points with the most room, among which the view decides
_VOID, _TRODDEN = 4, 6  # what a step costs more without ground below, and where one has been
_HIDDEN = 40  # likewise in fog


def find(scene: Scene, lattice: Lattice, lookout: Lookout, length: float, passing: float) -> Floats:
    """(n, 3) lattice points on the way from place to place.

    Args:
        scene: What is toured.
        lattice: Its points with room.
        lookout: Of its level; the tour begins where much is seen.
        length: Units that are wanted, along the lattice.
        passing: Units from a place at which it counts as passed.

    Raises:
        UsageError: there is no place in the open.
    """
    clearance = lattice.clearance(_ROOMY)
    ground = _ground(scene.level, lattice)
    eyes = [camera.position for camera in spawn_cameras(scene.level.bsp).values()]
    snapped = [lattice.nearest(eye, _NEAR_SPAWN) for eye in eyes]
    spawns = list(dict.fromkeys(cell for cell in snapped if cell is not None))
    others = _open_places(lattice, clearance, _above(lattice, ground, _LOW), spawns)
    if not spawns and not len(others):
        raise UsageError(f"{scene.name}: no room for a camera to fly through; give it a path")
    spawns = spawns or [int(others[0])]
    roomiest = sorted(spawns, key=lambda cell: -clearance[cell])[:_STARTS]
    start = roomiest[int(lookout.best_view(lattice.points(np.array(roomiest))).argmax())]
    hidden = _in_fog(scene.level, lattice, np.array(eyes))
    stops = _with_far_ones(lattice, spawns, others, 2 * passing)
    stops = [stop for stop in stops if not hidden[stop] or stop == start]
    cost = np.where(lattice.open, _ROOMY + 1 - clearance, 0)
    cost += _VOID * (lattice.open & ~_above(lattice, ground, _HIGH)) + _HIDDEN * hidden
    return lattice.points(_route(lattice, cost, stops, start, length, passing))


def _ground(level: Level, lattice: Lattice) -> Mask:
    """(points,) open ones right above a floor that is drawn; levels may end in a floor of sky."""
    floor = np.flatnonzero(lattice.open & ~np.roll(lattice.open, lattice.steps[4]))
    surfaces = Voxels.of(corners_within(level, opaque(level)), lattice.spacing)
    below = lattice.points(floor) - (0.0, 0.0, lattice.spacing)
    drawn = surfaces.grown(lattice.spacing).hold(below)
    ground = np.zeros_like(lattice.open)
    ground[floor[drawn] if drawn.any() else floor] = True
    return ground


def _in_fog(level: Level, lattice: Lattice, eyes: Floats) -> Mask:
    """(points,) open ones in or near fog, but for that in which players begin."""
    found = np.zeros_like(lattice.open)
    cells = np.flatnonzero(lattice.open)
    points = lattice.points(cells)
    for each in level.fogs:
        if not fog.holds(each, eyes).any():
            found[cells] |= fog.holds(each, points, lattice.spacing)
    return found


def _above(lattice: Lattice, ground: Mask, units: float) -> Mask:
    """(points,) open ones that are at most so high above the ground."""
    above = ground
    for _ in range(round(units / lattice.spacing)):
        above = above | (np.roll(above, lattice.steps[4]) & lattice.open)
    return above


def _open_places(lattice: Lattice, clearance: Ints, low: Mask, spawns: list[int]) -> Cells:
    """Low points with room around, to which one may walk from spawn points.

    Roofs are not made to be seen from above; with no two spawn points they are better than nothing.
    """
    left, walked = low.copy(), np.zeros_like(low)
    for cell in spawns:
        if left[cell]:
            walked |= lattice.flood(cell, left)
    roomy = clearance >= min(_ROOMY - 1, clearance.max(initial=0))
    return np.flatnonzero(roomy & (walked if len(spawns) > 1 else low))


def _with_far_ones(lattice: Lattice, stops: list[int], others: Cells, apart: float) -> list[int]:
    """Stops, and of other points those that are farthest from all of them, one after another."""
    stops, places = list(stops), lattice.points(others)
    distance = np.full(len(others), np.inf)
    for place in lattice.points(np.array(stops)):
        distance = np.minimum(distance, np.linalg.norm(places - place, axis=1))
    for _ in range(_PLACES):
        if distance.max(initial=0) < apart:
            break
        farthest = int(distance.argmax())
        stops.append(int(others[farthest]))
        distance = np.minimum(distance, np.linalg.norm(places - places[farthest], axis=1))
    return stops


def _route(
    lattice: Lattice, cost: Ints, stops: list[int], start: int, length: float, passing: float
) -> Cells:
    """Points on the way from stop to stop; once all are passed, anew."""
    places = lattice.points(np.array(stops))
    passed = np.array(stops) == start
    route = [start]
    trodden = np.zeros_like(lattice.open)
    while len(route) * lattice.spacing < length and len(stops) > 1:
        if passed.all():
            passed = np.array(stops) == route[-1]
            trodden[:] = False
        again = _TRODDEN * (trodden & lattice.open)
        leg = lattice.way(cost + again, route[-1], np.array(stops)[~passed])
        route += leg[1:]
        on_leg = np.zeros_like(lattice.open)
        on_leg[leg] = True
        trodden |= lattice.grown(on_leg, 3)
        distance = np.linalg.norm(places[:, np.newaxis] - lattice.points(np.array(leg)), axis=2)
        passed |= distance.min(axis=1) < passing
        passed[stops.index(leg[-1])] = True
    return np.array(route)
