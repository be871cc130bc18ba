"""What a camera and a light see of a scene, by rays in float64 instead of rasters and maps.

The rules are the game's and the same as in `present.raytracer`: the camera does not see the backs
of one-sided faces, blended surfaces and sprites throw no shadow, everything else stops light from
both sides, and leaves and grates do both only where their texture says so. What throws none is not
seen, either, and characters are left out.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from followspot.arrays import Floats, Mask
from followspot.assets.shader_values import Sides
from followspot.passes.shadow_fit import ShadowFrustum
from followspot.passes.shadow_tiles import ShadowTiles, near_reach
from followspot.passes.visible import VisibleFaces
from followspot.present.cut_outs import CutOuts
from followspot.scene.camera import Camera
from followspot.scene.light import SpotLight
from followspot.scene.scene import Scene
from followspot.scene.settings import Settings
from followspot.scene.triangle_tree import Hits, TriangleTree
from followspot.spaces import vertical_fov

CLEARANCE = 0.05
"""Units that a ray starts off its surface: of faces that lie in one plane none hides the other."""


@dataclass(frozen=True, eq=False)
class Places:
    """What a picture's pixels show at their middles; n of them, surfaces only.

    Attributes:
        pixel: (n,) numbers of pixels, row by row from the top.
        position: (n, 3) world, units.
        normal: (n, 3) unit, of shading, towards the viewer's side.
        face_normal: (n, 3) unit, of the triangle, towards the viewer's side.
        depth: (n,) units along the view axis.
        cut_out: (n,) whether the surface is leaves, a grate or the like.
        two_sided: (n,) whether it is drawn from both sides.
    """

    pixel: np.ndarray
    position: Floats
    normal: Floats
    face_normal: Floats
    depth: Floats
    cut_out: Mask
    two_sided: Mask

    def __len__(self) -> int:
        return len(self.pixel)

    def chosen(self, which: np.ndarray) -> "Places":
        """Some of them, by a mask or by numbers."""
        return Places(*(each[which] for each in vars(self).values()))


class Rays:
    """A scene's shadow casters as triangles that rays meet."""

    def __init__(self, scene: Scene) -> None:
        mesh, materials = scene.mesh, scene.materials
        material = mesh.material_of_triangle
        table = np.array(
            [
                (
                    m.casts,
                    m.alpha_test is not None,
                    m.is_two_sided,
                    m.sides is not Sides.BACK,
                    m.sides is not Sides.FRONT,
                )
                for m in materials
            ],
            bool,
        ).reshape(-1, 5)
        casts, self.is_cut_out, self.is_two_sided, self._has_front, self._has_back = table[
            material
        ].T
        self._mesh = mesh
        self._cut_outs = CutOuts(scene)
        self._tree = TriangleTree(mesh, casts)

    def crossings(self, start: Floats, end: Floats) -> Iterator[Hits]:
        """Where lines (n, 3) to (n, 3) cross casters that are there; see `TriangleTree`."""
        for hits in self._tree.crossings(start, end):
            cut_out = np.flatnonzero(self.is_cut_out[hits.triangle])
            kept = np.ones(len(hits.line), bool)
            kept[cut_out] = self._cut_outs.are_there(hits.triangle[cut_out], hits.weights[cut_out])
            yield hits if kept.all() else hits.chosen(kept)

    def are_blocked(self, start: Floats, end: Floats) -> Mask:
        """(n,) whether anything is between (n, 3) and (n, 3)."""
        blocked = np.zeros(len(start), bool)
        for hits in self.crossings(start, end):
            blocked[hits.line] = True
        return blocked

    def reach(self, points: Floats, normals: Floats, light: Floats) -> Mask:
        """(n,) whether points (n, 3) on faces of some unit normals (n, 3) see a point (3,)."""
        facing = np.copysign(1.0, ((light - points) * normals).sum(axis=1, keepdims=True))
        start = points + normals * facing * CLEARANCE
        return ~self.are_blocked(start, np.broadcast_to(light, start.shape))

    def seen_by(self, camera: Camera, size: tuple[int, int], far: float) -> Places:
        """What a camera sees through the middles of a (width, height) picture's pixels.

        Args:
            camera: Nothing nearer than its near plane is seen.
            size: In pixels.
            far: Units along the view axis that are looked through.
        """
        way = ways(camera, size)
        start, end = camera.position + way * camera.near, camera.position + way * far
        nearest = np.full(len(way), np.inf)
        triangle = np.full(len(way), -1)
        weights, front = np.zeros((len(way), 3)), np.zeros(len(way), bool)
        for hits in self.crossings(start, end):
            drawn = np.where(
                hits.from_front, self._has_front[hits.triangle], self._has_back[hits.triangle]
            )
            order = np.flatnonzero(drawn)
            order = order[np.lexsort((hits.fraction[order], hits.line[order]))]
            first = order[np.flatnonzero(np.diff(hits.line[order], prepend=-1))]
            line = hits.line[first]
            nearest[line], triangle[line] = hits.fraction[first], hits.triangle[first]
            weights[line], front[line] = hits.weights[first], hits.from_front[first]
        pixel = np.flatnonzero(np.isfinite(nearest))
        triangle, weights = triangle[pixel], weights[pixel]
        vertices = self._mesh.vertices[self._mesh.indices.reshape(-1, 3)[triangle]]
        a, b, c = vertices["position"].astype(np.float64).transpose(1, 0, 2)
        side = np.where(front[pixel], 1.0, -1.0)[:, np.newaxis]
        depth = camera.near + nearest[pixel] * (far - camera.near)
        smooth = (vertices["normal"] * weights[..., np.newaxis]).sum(axis=1)
        return Places(
            pixel,
            camera.position + way[pixel] * depth[:, np.newaxis],
            _unit(smooth) * side,
            _unit(np.cross(c - a, b - a)) * side,  # clockwise
            depth,
            self.is_cut_out[triangle],
            self.is_two_sided[triangle],
        )


@dataclass(frozen=True, eq=False)
class Fitted:
    """What a light's tiles cover.

    Attributes:
        cone: What the wide one would, were it not fitted: the whole cone.
        wide: What it does cover.
        near: What the near one covers, if there is one.
        reach: Share of the near one's edge from its middle up to which it is looked at.
    """

    cone: ShadowFrustum
    wide: ShadowFrustum
    near: ShadowFrustum | None
    reach: float

    def texels(self, places: Floats) -> Floats:
        """(n,) edges, longer ones, of a texel at distance 1, in the tiles for (n, 3) places."""
        texels = np.full(len(places), self.wide.texel)
        if self.near is not None:
            matrix = self.near.clip_from_world[[0, 1, 3]]
            x_y_w = places @ matrix[:, :3].T + matrix[:, 3]
            reach = 2 * self.reach * x_y_w[:, 2:]
            texels[(np.abs(x_y_w[:, :2]) < reach).all(axis=1)] = self.near.texel
        return texels


def fitted(
    scene: Scene, camera: Camera, size: tuple[int, int], light: SpotLight, settings: Settings
) -> Fitted:
    """What the frame makes of a light's shadow map."""
    aspect, far = size[0] / size[1], camera.far_for(*scene.bounds)
    clip_from_world = camera.clip_from_view(aspect, far) @ camera.view_from_world
    visible = VisibleFaces(scene)
    visible.update(camera.position, clip_from_world, cull=True)
    tiles = ShadowTiles(scene)
    tiles.fit((light,), settings, None)
    cone = tiles.tiles[0].frustum
    if settings.shadow_fit:
        tiles.fit((light,), settings, visible.receivers)
    found = {tile.is_near: tile.frustum for tile in tiles.tiles}
    return Fitted(cone, found[False], found.get(True), near_reach(settings))


def ways(camera: Camera, size: tuple[int, int]) -> Floats:
    """(pixels, 3) world directions through their middles, 1 long along the view axis."""
    width, height = size
    half = np.tan(np.radians([camera.fov, vertical_fov(camera.fov, width / height)]) / 2)
    x, y = np.meshgrid(
        ((np.arange(width) + 0.5) / width * 2 - 1) * half[0],
        (1 - (np.arange(height) + 0.5) / height * 2) * half[1],
    )
    view = np.stack([x.ravel(), y.ravel(), -np.ones(x.size)], axis=1)
    return np.asarray(view @ camera.view_from_world[:3, :3])


def _unit(vectors: Floats) -> Floats:
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.asarray(vectors / np.maximum(length, 1e-12))
