"""What the camera sees: culled and sorted into draw lists, kept while they hold."""

import numpy as np
from numpy.typing import NDArray

from followspot import spaces
from followspot.arrays import Mask
from followspot.assets.shader_values import Sides
from followspot.passes import drawlist
from followspot.passes.drawlist import NOTHING, NearFirst
from followspot.passes.shadow_fit import Receivers
from followspot.scene import bsp_tree
from followspot.scene.mesh import FLAT
from followspot.scene.scene import Scene
from followspot.spaces import Mat4, Vec3

SORT_CELL = 256.0
"""Units: opaque faces are sorted as seen from the middle of the cell that the eye is in, so that
their order stays while the eye moves a little, and yet follows from where it is alone."""

CELLS_ACROSS, CELLS_DEEP = 3, 8
"""Cells of the frustum across and in depth, in which receivers of shadows are boxed."""

_SIDE = {Sides.FRONT: 1, Sides.BACK: -1, Sides.BOTH: 0}


class VisibleFaces:
    """The draw lists of one scene for one camera.

    Attributes:
        characters: (n,) which of the crowd the level does not hide for good.
        faces: Records of those drawn; a new object whenever they are new.
        opaque: Solid and cut-out faces, roughly front to back.
        blended: Blended faces, back to front; those between that only add, by material.
        receivers: Boxes of all visible faces, and of where characters go, within the camera's
            frustum; a new object whenever they are new.
    """

    def __init__(self, scene: Scene) -> None:
        self._mesh, self._visibility, self._crowd = scene.mesh, scene.visibility, scene.crowd
        materials = scene.materials
        self._crowd_box, self._crowd_leaf = bsp_tree.box_leafs_to_see(
            scene.visibility.bsp, self._crowd.mins, self._crowd.maxs
        )
        self.characters = np.ones(len(scene.crowd), bool)
        self._side = np.array([_SIDE[m.sides] for m in materials], np.float32)
        self._is_cut_out = np.array([m.alpha_test is not None for m in materials], bool)
        self._is_blended = np.array([m.blend is not None for m in materials], bool)
        self._adds = np.array([m.only_adds for m in materials], bool)
        self.faces = self._mesh.faces[:0]
        self.opaque, self.blended = NOTHING, NOTHING
        none, nowhere = np.zeros((0, 3), np.float32), np.zeros(0)
        self.receivers = Receivers(none, none, np.zeros((0, 8, 3)), nowhere, nowhere)
        self._listed: object = None
        self._cell = b""
        self._near_first = NearFirst(np.zeros(0, np.intp), np.zeros(0))
        self._opaque = np.zeros(0, bool)

    def update(
        self,
        eye: Vec3,
        clip_from_world: Mat4,
        *,
        cull: bool,
        looked_at_from: Vec3 | None = None,
    ) -> bool:
        """Cull and sort anew, but only when something that matters has changed.

        Args:
            eye: (3,) the camera's place in world units.
            clip_from_world: The camera's.
            cull: Whether faces that cannot be seen are left out of the draw lists.
            looked_at_from: (3,) where the picture is taken from, if not from the same place.

        Returns:
            Whether the draw lists are new.
        """
        viewpoint = eye if looked_at_from is None else looked_at_from
        wanted = clip_from_world.tobytes(), viewpoint.tobytes(), cull
        if wanted == self._listed:
            return False
        self._listed = wanted
        visible = self._seen_from(eye, clip_from_world)
        boxes = np.zeros(len(self._crowd.mins), bool)
        if len(boxes):
            boxes[self._crowd_box[self._visibility.leafs_from(eye)[self._crowd_leaf]]] = True
        self.characters = np.zeros(len(self._crowd), bool)
        self.characters[self._crowd.box_of[boxes]] = True
        self.faces = self._mesh.faces[visible]
        self.receivers = self._boxes_in_view(self.faces, boxes, clip_from_world)
        if not cull:
            self.faces, visible = self._mesh.faces, np.ones_like(visible)
        is_blended = self._is_blended[self._mesh.faces["material"]]
        opaque, blended = visible & ~is_blended, visible & is_blended
        cell = np.floor(viewpoint / SORT_CELL)
        is_sorted = cell.tobytes() == self._cell
        if not is_sorted:
            self._cell = cell.tobytes()
            middle = spaces.vec3((cell + 0.5) * SORT_CELL)
            self._near_first = NearFirst.seen_from(self._mesh, middle)
        same = is_sorted and np.array_equal(opaque, self._opaque)
        if not same:
            self._opaque = opaque
            self.opaque = drawlist.front_to_back(
                self._mesh, opaque, self._near_first, self._is_cut_out
            )
        nothing_blended = not blended.any() and not self.blended.batches
        self.blended = drawlist.back_to_front(self._mesh, blended, viewpoint, self._adds)
        return not (same and nothing_blended)

    def _seen_from(self, eye: Vec3, clip_from_world: Mat4) -> Mask:
        """(faces,) those in the frustum that face the eye and that the level's vis allows."""
        faces = self._mesh.faces
        planes = drawlist.frustum_planes(clip_from_world)
        seen = drawlist.boxes_in_frustum(planes, faces["mins"], faces["maxs"])
        height = drawlist.height_above(faces, eye)
        seen &= height * self._side[faces["material"]] >= -FLAT
        return seen & self._visibility.faces_from(eye)

    def _boxes_in_view(
        self, faces: NDArray[np.void], boxes: Mask, clip_from_world: Mat4
    ) -> Receivers:
        """Boxes that hold all visible faces and characters within the camera's frustum, tightly.

        The frustum is cut into cells; each cell has the box of what the faces' boxes have in
        common with the cell's own.
        """
        cells = _frustum_cells(clip_from_world)
        all_mins = np.concatenate([faces["mins"], self._crowd.mins[boxes]])
        all_maxs = np.concatenate([faces["maxs"], self._crowd.maxs[boxes]])
        lows, highs = np.ascontiguousarray(all_mins.T), np.ascontiguousarray(all_maxs.T)
        apart = np.zeros((len(cells.mins), len(all_mins)), bool)
        for axis in range(3):  # three flat arrays are faster than one with a last axis of three
            apart |= lows[axis] > cells.maxs[:, axis, np.newaxis]
            apart |= highs[axis] < cells.mins[:, axis, np.newaxis]
        holds = ~apart.all(axis=1)
        apart = apart[holds]
        mins = [np.where(apart, np.inf, x).min(axis=1, initial=np.inf) for x in lows]
        maxs = [np.where(apart, -np.inf, x).max(axis=1, initial=-np.inf) for x in highs]
        return Receivers(
            np.maximum(np.stack(mins, axis=1), cells.mins[holds]),
            np.minimum(np.stack(maxs, axis=1), cells.maxs[holds]),
            cells.corners[holds],
            cells.start[holds],
            cells.end[holds],
        )


def _frustum_cells(clip_from_world: Mat4) -> Receivers:
    """World boxes of a frustum's cells: CELLS_ACROSS squared times CELLS_DEEP of them."""
    across = np.linspace(-1, 1, CELLS_ACROSS + 1)
    ends = np.array([[x, y, z, 1] for z in (-1, 1) for y in across for x in across])
    world = np.linalg.solve(clip_from_world, ends.T).T
    near, far = (world[:, :3] / world[:, 3:]).reshape(2, 1, CELLS_ACROSS + 1, CELLS_ACROSS + 1, 3)
    deep = np.geomspace(1 / 64, 1, CELLS_DEEP + 1)
    deep[0] = 0
    grid = near + (far - near) * deep[:, np.newaxis, np.newaxis, np.newaxis]
    corners = np.stack(
        [
            grid[z : z + CELLS_DEEP, y : y + CELLS_ACROSS, x : x + CELLS_ACROSS]
            for z in (0, 1)
            for y in (0, 1)
            for x in (0, 1)
        ]
    ).reshape(8, -1, 3)
    distances = (grid[:, 0, 0] @ clip_from_world[3, :3] + clip_from_world[3, 3]).repeat(
        CELLS_ACROSS**2
    )
    mins, maxs = corners.min(axis=0).astype(np.float32), corners.max(axis=0).astype(np.float32)
    start, end = distances[: -(CELLS_ACROSS**2)], distances[CELLS_ACROSS**2 :]
    return Receivers(mins, maxs, corners.swapaxes(0, 1), start, end)
