"""What grows in the courtyard: an olive tree, a vine on its pergola, ivy, tufts in pots."""

import numpy as np

from followspot.arrays import Floats
from followspot.builtin.courtyard_materials import Materials
from followspot.levelbuilder import Brush, Material, Mesh, Patch, arc, box, quads

Part = Brush | Patch | Mesh


def tube(material: Material, path: Floats, radii: Floats) -> Patch:
    """Return a bent tube about a path's controls, (n, 3), with a radius, (n,), at each."""
    tangents = np.gradient(path, axis=0)
    tangents /= np.linalg.norm(tangents, axis=1, keepdims=True)
    right = np.cross(tangents, [0.0, 1.0, 0.1])
    right /= np.linalg.norm(right, axis=1, keepdims=True)
    ahead = np.cross(tangents, right)
    circle = arc(0, 360, 6)
    rings = circle[None, :, :1] * right[:, None] + circle[None, :, 1:] * ahead[:, None]
    points = path[:, None] + rings * radii[:, None, None]
    run = np.concatenate([[0], np.linalg.norm(np.diff(path, axis=0), axis=1).cumsum()])
    s, t = np.meshgrid(np.linspace(0, 1, len(circle)), -run / 64)
    return Patch(material, points, np.stack([s, t], axis=2))


def cards(
    material: Material, centres: Floats, normals: Floats, sizes: Floats, rng: np.random.Generator
) -> Mesh:
    """Return square cards at centres, (n, 3), across normals, (n, 3), each turned at random."""
    helper = rng.standard_normal(centres.shape)
    u = np.cross(normals, helper)
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    v = np.cross(normals, u)
    v /= np.linalg.norm(v, axis=1, keepdims=True)
    half = sizes[:, None] / 2
    corners = np.stack([-u + v, u + v, u - v, -u - v], axis=1) * half[:, None]
    return quads(material, centres[:, None] + corners)


def with_normals(mesh: Mesh, normals: Floats) -> Mesh:
    """Return a mesh of quads with one normal, (n, 3), for each quad.

    Leaves lit as if they were the surface of the whole crown look like foliage, not like cards.
    """
    unit = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    return Mesh(mesh.material, mesh.points, mesh.st, np.repeat(unit, 4, axis=0), mesh.triangles)


def olive_tree(m: Materials, x: float, y: float) -> list[Part]:
    """Return an old olive tree in a square stone bed."""
    rng = np.random.default_rng(7)
    parts: list[Part] = []
    for low, high in (
        ((-44, -44), (44, -34)),
        ((-44, 34), (44, 44)),
        ((-44, -34), (-34, 34)),
        ((34, -34), (44, 34)),
    ):
        parts.append(
            box((x + low[0], y + low[1], 0), (x + high[0], y + high[1], 20), m.stone, detail=True)
        )
    parts.append(box((x - 34, y - 34, 0), (x + 34, y + 34, 15), m.soil, detail=True))
    fork = np.array([x + 6, y - 4, 84.0])
    trunk = np.array([[x - 2, y, 12], [x - 9, y + 5, 48], fork])
    parts.append(tube(m.bark, trunk, np.array([15.0, 8.5, 8.0])))
    tips = np.array(
        [[-52, -22, 150], [46, -40, 158], [34, 50, 166], [-30, 48, 148], [0, -4, 182]], dtype=float
    )
    for tip in tips:
        end = np.array([x, y, 0.0]) + tip
        bend = (fork + end) / 2 + [0, 0, -12]
        parts.append(
            tube(m.bark, np.stack([fork - [0, 0, 8], bend, end]), np.array([7.0, 4.5, 1.5]))
        )
    clusters = np.concatenate([tips, tips * [1.35, 1.35, 1.0] + [0, 0, 14], [[10, 0, 200]]])
    centre = np.array([x, y, 150.0])
    which = rng.integers(len(clusters), size=150)
    spread = rng.standard_normal((150, 3))
    spread *= (rng.uniform(0.4, 1.0, 150) ** 0.5 * 32 / np.linalg.norm(spread, axis=1))[:, None]
    centres = clusters[which] + spread * [1.0, 1.0, 0.75] + [x, y, 6]
    sizes = rng.uniform(38, 56, 150)
    outward = (centres - centre) / [1.2, 1.2, 1.0] + [0, 0, 12]
    facing = outward / np.linalg.norm(outward, axis=1, keepdims=True)
    facing = facing + 0.8 * rng.standard_normal(facing.shape)
    leaves = cards(m.leaves, centres, facing, sizes, rng)
    parts.append(with_normals(leaves, outward))
    return parts


def pergola(m: Materials, mins: tuple[float, float], maxs: tuple[float, float]) -> list[Part]:
    """Return a pergola of wooden posts and beams over a rectangle, overgrown with a vine."""
    (x0, y0), (x1, y1) = mins, maxs
    rng = np.random.default_rng(9)
    parts: list[Part] = []
    for x in (x0, x1 - 8):
        for y in np.linspace(y0, y1 - 8, 3):
            parts.append(box((x - 3, y - 3, 0), (x + 11, y + 11, 8), m.stone, detail=True))
            parts.append(box((x, y, 8), (x + 8, y + 8, 112), m.wood, detail=True))
        parts.append(box((x - 1, y0 - 14, 112), (x + 9, y1 + 14, 121), m.wood, detail=True))
    for y in np.linspace(y0 - 8, y1 + 2, 9):
        parts.append(box((x0 - 16, y, 121), (x1 + 12, y + 6, 128), m.wood, detail=True))
    count = 120
    centres = rng.uniform([x0 - 8, y0 - 8, 128], [x1 + 8, y1 + 8, 140], (count, 3))
    hangs = rng.uniform(size=count) < 0.3
    centres[hangs, 2] -= rng.uniform(8, 26, hangs.sum())
    facing = np.where(hangs[:, None], [0.6, 0.6, 0.3], [0.0, 0.0, 1.0])
    facing = facing + 0.45 * rng.standard_normal((count, 3))
    leaves = cards(m.leaves, centres, facing, rng.uniform(26, 42, count), rng)
    parts.append(with_normals(leaves, facing * 0.4 + [0.0, 0.0, 1.0]))
    return parts


def ivy(
    m: Materials,
    foot: tuple[float, float, float],
    along: tuple[float, float],
    size: tuple[float, float],
    seed: int,
    count: int = 110,
) -> list[Part]:
    """Return ivy on a wall: densest at the foot's middle, thinning upwards and sideways.

    Args:
        m: The materials.
        foot: Middle of its lower edge on the wall.
        along: Unit vector (x, y) rightwards as seen from the front.
        size: Width and height that it reaches.
        seed: Of the random numbers.
        count: Number of leaf cards.
    """
    rng = np.random.default_rng(seed)
    right = np.array([*along, 0.0])
    front = np.array([along[1], -along[0], 0.0])
    up = rng.uniform(0, 1, count) ** 1.3
    strand = rng.choice(np.linspace(-0.45, 0.45, 6), count) * (0.5 + 0.7 * up)
    sideways = strand + rng.normal(0, 0.07, count)
    lift = rng.uniform(1.5, 7.0, count)
    centres = np.array(foot) + np.outer(sideways * size[0], right) + np.outer(lift, front)
    centres[:, 2] += up * size[1] + 6
    facing = front + 0.35 * rng.standard_normal((count, 3))
    leaves = cards(m.leaves, centres, facing, rng.uniform(18, 30, count), rng)
    return [with_normals(leaves, np.tile(front + np.array([0.0, 0.0, 0.5]), (count, 1)))]


def cascade(
    m: Materials,
    top: tuple[float, float, float],
    along: tuple[float, float],
    size: tuple[float, float],
    seed: int,
    count: int = 110,
) -> list[Part]:
    """Return bougainvillea that hangs down over an edge: fullest there, ending in tails.

    Args:
        m: The materials.
        top: Middle of the edge, on the wall's face.
        along: Unit vector (x, y) rightwards as seen from the front.
        size: Width of the edge and length of the longest tail.
        seed: Of the random numbers.
        count: Number of leaf cards.
    """
    rng = np.random.default_rng(seed)
    right = np.array([*along, 0.0])
    front = np.array([along[1], -along[0], 0.0])
    sideways = rng.normal(0, 0.24, count).clip(-0.5, 0.5)
    tail = 0.25 + 0.75 * np.abs(np.cos(9 * sideways)) * np.exp(-6 * sideways**2)
    down = rng.uniform(0, 1, count) ** 1.4 * tail
    lift = rng.uniform(3.0, 11.0, count) * (1 - 0.5 * down)
    centres = np.array(top) + np.outer(sideways * size[0], right) + np.outer(lift, front)
    centres[:, 2] += 8 - down * size[1] + rng.normal(0, 3, count)
    facing = front + 0.5 * rng.standard_normal((count, 3))
    outward = np.tile(front + np.array([0.0, 0.0, 0.6]), (count, 1))
    sizes = rng.uniform(18, 30, count)
    green = rng.uniform(size=count) < 0.3
    parts: list[Part] = []
    for material, chosen in ((m.leaves, green), (m.blossom, ~green)):
        sprays = cards(material, centres[chosen], facing[chosen], sizes[chosen], rng)
        parts.append(with_normals(sprays, outward[chosen]))
    return parts


def tuft(
    m: Materials, x: float, y: float, z: float, size: float, seed: int, blooms: bool = False
) -> list[Part]:
    """Return a ball of leaves for a pot, in bloom or not."""
    rng = np.random.default_rng(seed)
    outward = rng.standard_normal((16, 3)) + np.array([0.0, 0.0, 0.8])
    outward /= np.linalg.norm(outward, axis=1, keepdims=True)
    centres = np.array([x, y, z]) + outward * size * 0.35
    facing = outward + 0.7 * rng.standard_normal((16, 3))
    material = m.blossom if blooms else m.leaves
    leaves = cards(material, centres, facing, rng.uniform(0.6, 0.9, 16) * size, rng)
    return [with_normals(leaves, outward)]
