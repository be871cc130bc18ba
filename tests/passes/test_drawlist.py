"""Culling and sorting in pure NumPy: culling never drops what could be seen."""

import numpy as np
from hypothesis import assume, given
from hypothesis import strategies as st
from numpy.typing import NDArray

from followspot.arrays import Mask
from followspot.assets.shader_values import BlendFactor
from followspot.passes import drawlist
from followspot.passes.drawlist import (
    DrawList,
    NearFirst,
    boxes_in_frustum,
    cubes_in_frustum,
    frustum_planes,
)
from followspot.scene.camera import Camera
from followspot.scene.material import Material
from followspot.scene.mesh import Mesh
from followspot.spaces import Mat4, Vec3, box_corners, clip_from_view, vec3, view_from_world
from synthetic import box, camera, floor, make_mesh, of, quad, sphere

numbers = st.floats(-4096, 4096)
points = st.tuples(numbers, numbers, numbers).map(np.array)
cameras = st.builds(
    Camera,
    points.map(vec3),
    yaw=st.floats(-180, 180),
    pitch=st.floats(-90, 90),
    fov=st.floats(2, 160),
)
GLASS = Material("glass", blend=(BlendFactor.SRC_ALPHA, BlendFactor.ONE_MINUS_SRC_ALPHA))


def clip_matrix(view: Camera) -> Mat4:
    return view.clip_from_view(4 / 3, 20000.0) @ view.view_from_world


@given(
    cameras,
    st.tuples(st.floats(-1, 1), st.floats(-1, 1), st.floats(-1, 1)),
    points.map(np.abs),
    st.tuples(*[st.floats(0, 1)] * 3).map(np.array),
)
def test_a_box_with_a_point_in_sight_is_kept(
    view: Camera,
    seen: tuple[float, float, float],
    extent: NDArray[np.float64],
    share: NDArray[np.float64],
) -> None:
    """Boxes of all sizes round a point whose clip coordinates are within the cube."""
    inside = np.linalg.solve(clip_matrix(view), (*seen, 1))
    inside = inside[:3] / inside[3]
    low = (inside - extent * share).astype(np.float32)
    high = (inside + extent * (1 - share)).astype(np.float32)
    low, high = np.nextafter(low, -np.inf), np.nextafter(high, np.inf)
    assert ((low <= inside) & (inside <= high)).all()
    planes = frustum_planes(clip_matrix(view))
    assert boxes_in_frustum(planes, low[np.newaxis], high[np.newaxis]).all()


@given(cameras, points, st.floats(0, 1000))
def test_a_point_in_sight_is_a_point_in_front_of_all_planes(
    view: Camera, target: NDArray[np.float64], size: float
) -> None:
    matrix = clip_matrix(view)
    clip = matrix @ (*target, 1)
    margin = 1e-3 * abs(clip[3])
    assume((np.abs(np.abs(clip[:3]) - abs(clip[3])) > margin).all() and abs(clip[3]) > 1)
    planes = frustum_planes(matrix)
    in_sight = bool((np.abs(clip[:3]) < clip[3]).all())
    assert bool((planes @ (*target, 1) > 0).all()) == in_sight


@given(cameras, points, st.floats(1, 500))
def test_a_box_beyond_one_plane_is_left_out(
    view: Camera, target: NDArray[np.float64], half: float
) -> None:
    """Culling does cull: boxes whose corners all miss the same plane by a margin go."""
    low, high = (target - half).astype(np.float32), (target + half).astype(np.float32)
    corners = box_corners(low.astype(np.float64), high.astype(np.float64))
    planes = frustum_planes(clip_matrix(view))
    heights = planes[:, :3] @ corners.T + planes[:, 3:]
    slack = 2e-3 * np.abs(planes[:, 3:]) + 1e-2 * np.linalg.norm(planes[:, :3], axis=1)[:, None]
    assume((heights < -slack).all(axis=1).any())
    assert not boxes_in_frustum(planes, low[np.newaxis], high[np.newaxis]).any()


@given(st.integers(0, 2**32 - 1))
def test_many_boxes_at_once_are_the_same_as_one_by_one(seed: int) -> None:
    random = np.random.default_rng(seed)
    low = random.uniform(-2000, 2000, (50, 3)).astype(np.float32)
    high = low + random.uniform(0, 500, (50, 3)).astype(np.float32)
    planes = frustum_planes(clip_matrix(camera((0, 0, 0), random.uniform(-180, 180))))
    single = [boxes_in_frustum(planes, a[None], b[None])[0] for a, b in zip(low, high, strict=True)]
    np.testing.assert_array_equal(boxes_in_frustum(planes, low, high), single)


@given(cameras, st.integers(0, 2**32 - 1))
def test_a_cube_stays_where_any_of_its_corners_is_in_front_of_each_plane(
    view: Camera, seed: int
) -> None:
    random = np.random.default_rng(seed)
    centres, reach = random.uniform(-4096, 4096, (50, 3)), random.uniform(0, 500, 50)
    planes = frustum_planes(clip_matrix(view))
    corners = np.stack(
        [box_corners(c - r, c + r) for c, r in zip(centres, reach, strict=True)]
    )  # (50, 8, 3)
    heights = (corners @ planes[:, :3].T + planes[:, 3]).max(axis=1)
    sure = (np.abs(heights) > 1e-9 * np.abs(planes[:, 3]).max()).all(axis=1)
    found = cubes_in_frustum(planes, centres, reach)
    np.testing.assert_array_equal(found[sure], (heights >= 0).all(axis=1)[sure])


def some_mesh() -> tuple[Mesh, tuple[Material, ...]]:
    pieces = [
        *of(Material("b"), *box((-10, -10, 0), (10, 10, 20)), sphere((90, 0, 0), 5, rings=4)),
        *of(Material("a"), floor()),
        *of(GLASS, *(quad((x, 0, 5), (0, 5, 0), (0, 0, 5)) for x in (30, -40, 80, 10))),
    ]
    return make_mesh(pieces)


def triangles(mesh: Mesh, chosen: NDArray[np.bool_]) -> NDArray[np.uint32]:
    """(n, 4) of the chosen faces, material in front; sorted."""
    runs = [
        np.column_stack([
            np.full(f["index_count"] // 3, f["material"], np.uint32),
            mesh.indices[f["first_index"] : f["first_index"] + f["index_count"]].reshape(-1, 3),
        ])
        for f in mesh.faces[chosen]
    ]  # fmt: skip
    joined = np.concatenate(runs) if runs else np.empty((0, 4), np.uint32)
    return joined[np.lexsort(joined.T[::-1])]


def drawn(faces: DrawList) -> NDArray[np.uint32]:
    """What a draw list draws, likewise."""
    runs = [
        np.column_stack([
            np.full(batch.count // 3, batch.material, np.uint32),
            faces.indices[batch.first : batch.first + batch.count].reshape(-1, 3),
        ])
        for batch in faces.batches
    ]  # fmt: skip
    joined = np.concatenate(runs) if runs else np.empty((0, 4), np.uint32)
    return joined[np.lexsort(joined.T[::-1])]


FINE = 1 << 30
"""Texels of a map so fine that no triangle passes between them."""

EVERYWHERE = np.diag([1e-6, 1e-6, 1e-6, 1.0])
EVERYWHERE[:3, :3] @= np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
"""A clip_from_world that has the whole world inside and sees no triangle from its edge."""


def casters(
    mesh: Mesh,
    chosen: Mask,
    key: NDArray[np.int32],
    clip_from_world: Mat4,
    keep_side: NDArray[np.float32],
    eye: Vec3,
    size: int,
) -> DrawList:
    seen = drawlist.projected(mesh, chosen, clip_from_world, eye)
    return drawlist.casters(mesh, seen, chosen, key, keep_side, size)


def all_casters(mesh: Mesh, chosen: Mask, key: NDArray[np.int32]) -> DrawList:
    both = np.zeros(len(key), np.float32)
    return casters(mesh, chosen, key, EVERYWHERE, both, vec3((0, 0, 0)), FINE)


@given(
    st.tuples(*[st.floats(-90, 90)] * 3),
    st.sampled_from([-1, 1]),
    st.floats(1, 179),
    st.floats(-180, 180),
)
def test_casters_are_the_triangles_on_one_side_and_inside(
    eye: tuple[float, float, float], side: int, fov: float, yaw: float
) -> None:
    """Against one triangle after another, in plain Python; what is close to call may be kept."""
    mesh, materials = some_mesh()
    count = len(materials)
    clip = clip_from_view(fov, fov, 1, 500) @ view_from_world(vec3(eye), yaw, 0)
    faces = casters(
        mesh,
        np.ones(len(mesh.faces), bool),
        np.arange(count, dtype=np.int32),
        clip,
        np.full(count, side, np.float32),
        vec3(eye),
        FINE,
    )
    kept = {tuple(t) for t in faces.indices.reshape(-1, 3).tolist()}
    for triangle in mesh.indices.reshape(-1, 3).tolist():
        a, b, c = mesh.vertices["position"][triangle].astype(float)
        height = np.cross(c - a, b - a) @ (np.array(eye) - a)  # clockwise front
        x, y, _, w = clip @ np.c_[np.stack([a, b, c]), np.ones(3)].T
        outside = max((x - w).min(), (-w - x).min(), (y - w).min(), (-w - y).min())
        if abs(height) > 1e-2 and abs(outside) > 1e-2 and abs(w.max()) > 1e-2:
            assert (tuple(triangle) in kept) == (height * side > 0 > outside and w.max() > 0)


@given(st.tuples(*[st.floats(-90, 90)] * 3), st.floats(20, 120), st.integers(2, 40))
def test_casters_between_the_middles_of_texels_are_left_out(
    eye: tuple[float, float, float], fov: float, size: int
) -> None:
    mesh, materials = some_mesh()
    key = np.arange(len(materials), dtype=np.int32)
    clip = clip_from_view(fov, fov, 1, 500) @ view_from_world(vec3(eye), 30, 0)
    both = np.zeros(len(key), np.float32)
    every = np.ones(len(mesh.faces), bool)
    fine, coarse = (
        {
            tuple(triangle)
            for triangle in casters(mesh, every, key, clip, both, vec3(eye), texels)
            .indices.reshape(-1, 3)
            .tolist()
        }
        for texels in (FINE, size)
    )

    middles = np.arange(-4000, 4000) + 0.5  # the map's own, and those beside it
    for triangle in fine | coarse:
        corners = np.c_[mesh.vertices["position"][list(triangle)].astype(float), np.ones(3)]
        x, y, _, w = clip @ corners.T
        if w.min() <= 0:
            assert triangle in coarse
            continue
        lows, highs = (
            bound((np.stack([x, y]) / w + 1) / 2 * size, axis=1) for bound in (np.min, np.max)
        )
        if np.abs([lows, highs]).max() > 3999:
            continue
        marks = [
            bool(((middles > low) & (middles < high)).any())
            for low, high in zip(lows, highs, strict=True)
        ]
        if all(marks):
            assert triangle in coarse
        far = [
            not ((middles > low - 0.1) & (middles < high + 0.1)).any()
            for low, high in zip(lows, highs, strict=True)
        ]
        if any(far):
            assert triangle not in coarse


@given(st.data())
def test_lists_draw_every_chosen_triangle_once_with_its_material(data: st.DataObject) -> None:
    mesh, materials = some_mesh()
    count = len(mesh.faces)
    chosen = np.array(data.draw(st.lists(st.booleans(), min_size=count, max_size=count)), bool)
    eye = vec3((5, 6, 7))
    every, none_last = np.arange(len(materials), dtype=np.int32), np.zeros(len(materials), bool)
    kinds = len(set(mesh.faces["material"][chosen].tolist()))
    for faces in (
        all_casters(mesh, chosen, every),
        drawlist.front_to_back(mesh, chosen, NearFirst.seen_from(mesh, eye), none_last),
        drawlist.back_to_front(mesh, chosen, eye, none_last),
    ):
        np.testing.assert_array_equal(drawn(faces), triangles(mesh, chosen))
        assert faces.triangle_count == mesh.faces["index_count"][chosen].sum() // 3
        ends = [batch.first + batch.count for batch in faces.batches]
        assert [batch.first for batch in faces.batches] == [0, *ends][: len(ends)]
        assert len(faces.batches) >= kinds
    assert len(all_casters(mesh, chosen, every).batches) == kinds
    assert (
        len(drawlist.front_to_back(mesh, chosen, NearFirst.seen_from(mesh, eye), none_last).batches)
        == kinds
    )


def test_back_to_front() -> None:
    mesh, materials = some_mesh()
    glass = materials.index(GLASS)
    panes = mesh.faces["material"] == glass
    faces = drawlist.back_to_front(mesh, panes, vec3((0, 0, 0)), np.zeros(len(materials), bool))
    corners = mesh.vertices["position"][faces.indices[::6]]
    assert np.abs(corners[:, 0]).tolist() == [80, 40, 30, 10]
    assert len(faces.batches) == 1 and faces.batches[0].material == glass


def test_sums_are_drawn_by_material_between_what_covers() -> None:
    """What is before and what is behind a pane stays there; lights on one side of it are mixed."""
    flame, beam = Material("flame"), Material("beam")
    places = {flame: (80, 60, 30), beam: (70, 40, 20), GLASS: (50, 10)}
    mesh, materials = make_mesh(
        [
            piece
            for material, xs in places.items()
            for piece in of(material, *(quad((x, 0, 5), (0, 5, 0), (0, 0, 5)) for x in xs))
        ]
    )
    adds = np.array([material is not GLASS for material in materials])
    every = np.ones(len(mesh.faces), bool)
    faces = drawlist.back_to_front(mesh, every, vec3((0, 0, 5)), adds)
    first, second = sorted((flame, beam), key=materials.index)
    names = [materials[batch.material].name for batch in faces.batches]
    assert names == [m.name for m in (first, second, GLASS, first, second, GLASS)]
    far, near = {flame: [80, 60], beam: [70]}, {flame: [30], beam: [40, 20]}
    corners = mesh.vertices["position"][faces.indices[::6]]
    expected = [*far[first], *far[second], 50, *near[first], *near[second], 10]
    assert corners[:, 0].tolist() == expected


def test_front_to_back() -> None:
    """Faces of a material by their distance, materials by their middle one, some at the end."""
    near, far, leaf = Material("near"), Material("far"), Material("leaf")
    pieces = [quad((x, 0, 5), (0, 5, 0), (0, 0, 5)) for x in (60, -20, 40)]
    mesh, materials = make_mesh(
        [
            *of(near, *pieces),
            *of(far, quad((-300, 0, 5), (0, 5, 0), (0, 0, 5))),
            *of(leaf, quad((10, 0, 5), (0, 5, 0), (0, 0, 5))),
        ]
    )
    last = np.array([material is leaf for material in materials])
    every = np.ones(len(mesh.faces), bool)
    faces = drawlist.front_to_back(mesh, every, NearFirst.seen_from(mesh, vec3((0, 0, 5))), last)
    assert [materials[batch.material] for batch in faces.batches] == [near, far, leaf]
    corners = mesh.vertices["position"][faces.indices[::6]]
    assert corners[:, 0].tolist() == [-20, 40, 60, -300, 10]


def test_solid_casters_of_one_key_are_one_draw() -> None:
    mesh, _ = some_mesh()
    every = np.ones(len(mesh.faces), bool)
    faces = all_casters(mesh, every, np.array([0, 0, 2], np.int32))
    assert [batch.material for batch in faces.batches] == [0, 2]
    assert faces.triangle_count == mesh.triangle_count


def test_nothing_chosen() -> None:
    mesh, materials = some_mesh()
    none = np.zeros(len(mesh.faces), bool)
    for empty in (
        all_casters(mesh, none, np.arange(3, dtype=np.int32)),
        drawlist.front_to_back(
            mesh,
            none,
            NearFirst.seen_from(mesh, vec3((0, 0, 0))),
            np.zeros(len(materials), bool),
        ),
        drawlist.back_to_front(mesh, none, vec3((0, 0, 0)), np.zeros(len(materials), bool)),
    ):
        assert empty.batches == () and empty.triangle_count == 0
