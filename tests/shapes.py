"""Analytic shapes for the tests, as (vertices, faces)."""

from __future__ import annotations

import numpy as np

Arrays = tuple[np.ndarray, np.ndarray]


def icosphere(subdivisions: int = 3) -> Arrays:
    """A unit sphere of nearly even triangles, 10 * 4**subdivisions + 2 vertices."""
    import trimesh

    mesh = trimesh.creation.icosphere(subdivisions=subdivisions)
    return np.array(mesh.vertices), np.array(mesh.faces)


def ellipsoid(axes: tuple[float, float, float] = (1.0, 0.8, 1.7), subdivisions: int = 3) -> Arrays:
    """An ellipsoid with three different axes."""
    vertices, faces = icosphere(subdivisions)
    return vertices * axes, faces


def lump(subdivisions: int = 3) -> Arrays:
    """A closed shape without any symmetry: a sphere with bumps of different height and width."""
    vertices, faces = icosphere(subdivisions)
    directions = np.array([[1, 0.2, 0.1], [-0.5, 1, 0.3], [0.1, -0.6, 1], [-0.3, -0.4, -1], [0.3, -1, -0.3]])
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    radius = np.ones(len(vertices))
    for direction, height, width in zip(
        directions, (1.5, 1.0, 0.7, 1.2, 0.9), (0.2, 0.3, 0.25, 0.4, 0.15), strict=True
    ):
        radius += height * np.exp((vertices @ direction - 1) / width**2)
    return vertices * radius[:, None], faces


def grid(width: int = 12, height: int = 9, holes: tuple[tuple[int, int], ...] = ()) -> Arrays:
    """A flat rectangle of width by height unit squares, two triangles each, without the squares named in holes."""
    x, y = np.meshgrid(np.arange(width + 1), np.arange(height + 1))
    vertices = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1).astype(float)
    faces = []
    for row in range(height):
        for column in range(width):
            if (column, row) in holes:
                continue
            a = row * (width + 1) + column
            b, c, d = a + 1, a + width + 2, a + width + 1
            faces += [(a, b, c), (a, c, d)] if (row + column) % 2 else [(a, b, d), (b, c, d)]
    return vertices, np.array(faces)


def bent(arrays: Arrays) -> Arrays:
    """A sheet in the plane rolled onto a wave: a surface in space, no longer flat in each point's ring."""
    vertices, faces = arrays
    lifted = vertices.copy()
    lifted[:, 2] = np.sin(vertices[:, 0] * 0.7) + 0.3 * np.cos(vertices[:, 1] * 0.9)
    return lifted, faces


def tube(around: int = 24, along: int = 20, radius: float = 1.0, length: float = 4.0) -> Arrays:
    """An open cylinder: two boundary loops, outward faces."""
    angle, height = np.meshgrid(2 * np.pi * np.arange(around) / around, np.linspace(0, length, along + 1))
    vertices = np.stack([radius * np.cos(angle), radius * np.sin(angle), height], axis=-1).reshape(-1, 3)
    faces = []
    for row in range(along):
        for column in range(around):
            a, b = row * around + column, row * around + (column + 1) % around
            c, d = b + around, a + around
            faces += [(a, b, c), (a, c, d)]
    return vertices, np.array(faces)


def torus(major: float = 3.0, minor: float = 1.0, around: int = 40, across: int = 16) -> Arrays:
    """A torus of around by across quadrilaterals, two triangles each; vertex i * across + j."""
    i, j = np.divmod(np.arange(around * across), across)
    u, v = 2 * np.pi * i / around, 2 * np.pi * j / across
    radius = major + minor * np.cos(v)
    vertices = np.stack([radius * np.cos(u), radius * np.sin(u), minor * np.sin(v)], axis=1)
    right, up = (i + 1) % around * across, (j + 1) % across
    a, b, c, d = i * across + j, right + j, right + up, i * across + up
    return vertices, np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])


def bumpy_torus(proportion: float, turn: float, around: int, across: int) -> tuple[Arrays, np.ndarray]:
    """A torus of uneven thickness without symmetry, and the two angles of each vertex, (n, 2).

    The angles name the point: they are the same for all proportions (major radius per minor) and meshes; `turn` is the
    angle at which the mesh begins.
    """
    _, faces = torus(around=around, across=across)
    i, j = np.divmod(np.arange(around * across), across)
    u, v = 2 * np.pi * i / around + turn, 2 * np.pi * (j + 0.5 * (i % 2)) / across + turn
    minor = 1 + 0.35 * np.cos(u) + 0.2 * np.sin(2 * u) + 0.15 * np.cos(3 * u + v + 1)
    radius = proportion + minor * np.cos(v)
    vertices = np.stack([radius * np.cos(u), radius * np.sin(u), minor * np.sin(v) + 0.4 * np.cos(2 * u)], axis=1)
    return (vertices, faces), np.stack([u, v], axis=1)


def snake(bend: float, along: int, across: int, *, touching: bool = False) -> tuple[Arrays, np.ndarray]:
    """A closed tube of uneven thickness with thin ends, bent to an arc of an angle, and where each vertex is, (n, 3).

    The places are the same for all bends and meshes: a share of the length and the cosine and sine around the tube.
    Bent to a full circle, its ends may be joined where they are touching.
    """
    i, j = np.divmod(np.arange(along * across), across)
    part, v = (i + 0.5) / along, 2 * np.pi * (j + 0.5 * (i % 2)) / across
    thin = 0.2 + 0.8 * np.sin(np.pi * part) ** 0.7
    radius = thin * (1 + 0.3 * np.sin(2 * np.pi * part) + 0.2 * np.cos(v + 1) * part)
    angle = bend * (part - 0.5)
    height = 18 / bend + radius * np.cos(v)
    vertices = np.stack([height * np.cos(angle), height * np.sin(angle), radius * np.sin(v)], axis=1)
    places = np.stack([part, 0.1 * np.cos(v), 0.1 * np.sin(v)], axis=1)
    faces = torus(around=along, across=across)[1]
    if touching:
        return (vertices, faces), places
    last = across * (along - 1)
    faces = faces[~((faces < across).any(axis=1) & (faces >= last).any(axis=1))]
    n, ring = len(vertices), np.arange(across)
    after = np.roll(ring, -1)
    caps = (
        np.stack([ring, after, 0 * ring + n], axis=1),
        np.stack([after + last, ring + last, 0 * ring + n + 1], axis=1),
    )
    ends = np.stack([vertices[:across].mean(axis=0), vertices[last:].mean(axis=0)])
    everything = np.concatenate([vertices, ends]), np.concatenate([faces, *caps])
    return everything, np.concatenate([places, [[0, 0, 0], [1, 0, 0]]])


def mug(size: int, seed: int = 0) -> Arrays:
    """A hollow cup with a handle, about 1 wide and 2 high, by marching cubes in a turned grid of size**3 points."""
    import igl

    side = np.linspace(-1.9, 1.9, size)
    grid_points = np.stack(np.meshgrid(side, side, side, indexing="ij"), axis=-1).transpose(2, 1, 0, 3).reshape(-1, 3)
    x, y, z = (grid_points @ rotation(seed).T).T
    around = np.hypot(x, y)
    outside = np.maximum(around - 0.7 - 0.1 * z, np.abs(z) - 1)
    inside = np.maximum(around - 0.52 - 0.1 * z, -0.7 - z)
    handle = np.hypot(np.hypot(x - 0.75, z - 0.05) - 0.6, y) - 0.16
    blend = np.clip(0.5 + (handle - outside) / 0.2, 0, 1)
    solid = handle * (1 - blend) + outside * blend - 0.1 * blend * (1 - blend)
    found = igl.marching_cubes(np.maximum(solid, -inside), grid_points, size, size, size, 0.0)
    vertices, faces = found[0] @ rotation(seed).T, found[1]
    volume = np.einsum("ij,ij->", vertices[faces[:, 0]], np.cross(vertices[faces[:, 1]], vertices[faces[:, 2]]))
    faces = faces if volume > 0 else faces[:, ::-1]
    used = np.unique(faces)
    return vertices[used], np.searchsorted(used, faces)


def with_handle(arrays: Arrays, one: int, two: int, rings: int = 3) -> Arrays:
    """A shape with a tube of three sides from one face to another, in place of both; it may run through the shape.

    The first vertices and all other faces keep their order.
    """
    vertices, faces = arrays
    assert not set(faces[one]) & set(faces[two])
    first, second = faces[one], faces[two][::-1]
    second = min(
        (np.roll(second, k) for k in range(3)),
        key=lambda corners: np.linalg.norm(vertices[first] - vertices[corners], axis=1).sum(),
    )
    part = np.linspace(0, 1, rings + 2)[1:-1, None, None]
    middle = (1 - part) * vertices[first] + part * vertices[second]
    ring = np.concatenate([first[None], len(vertices) + np.arange(3 * rings).reshape(-1, 3), second[None]])
    a, b = ring, np.roll(ring, -1, axis=1)
    sides = [np.stack([a[:-1], b[:-1], b[1:]], axis=-1), np.stack([a[:-1], b[1:], a[1:]], axis=-1)]
    tube = np.concatenate([side.reshape(-1, 3) for side in sides])
    kept = np.delete(faces, [one, two], axis=0)
    return np.concatenate([vertices, middle.reshape(-1, 3)]), np.concatenate([kept, tube])


def disc(count: int = 1200, hole: float = 0.0, seed: int = 0) -> Arrays:
    """The flat unit disc, counter-clockwise, meshed at random by the seed; with a hole of that radius around 0."""
    from scipy.spatial import Delaunay

    rng, spacing = np.random.default_rng(seed), np.sqrt(np.pi / count)

    def circle(radius: float) -> np.ndarray:
        number = round(2 * np.pi * radius / spacing)
        return radius * np.exp(1j * (2 * np.pi * np.arange(number) / number + rng.uniform(0, np.pi)))

    k = np.arange(count)
    inner = np.sqrt((k + 0.5) / count) * np.exp(1j * (k * np.pi * (3 - np.sqrt(5)) + rng.uniform(0, np.pi)))
    inner += 0.2 * spacing * (rng.uniform(-1, 1, count) + 1j * rng.uniform(-1, 1, count))
    inner = inner[(np.abs(inner) < 1 - 0.6 * spacing) & (np.abs(inner) > hole + 0.6 * spacing * (hole > 0))]
    z = np.concatenate([inner, circle(1.0), circle(hole)])
    points = np.stack([z.real, z.imag], axis=1)
    faces = Delaunay(points).simplices
    faces = faces[~(np.abs(z[faces]) < hole * (1 + 1e-9)).all(axis=1)]
    one, two = points[faces[:, 1]] - points[faces[:, 0]], points[faces[:, 2]] - points[faces[:, 0]]
    turned = one[:, 0] * two[:, 1] < one[:, 1] * two[:, 0]
    faces[turned] = faces[turned][:, ::-1]
    return np.column_stack([points, np.zeros(len(points))]), faces


def true_places(name: str, *, mirrored: bool = False, reverse: bool = False) -> np.ndarray:
    """Where each vertex of a shipped pose lies on the other pose, (n, 3), in the coordinates of the other's file."""
    import mobius_match as mm
    from mobius_match.evaluation import examples

    mesh = mm.read_mesh(examples.paths(name)[0 if reverse else 1])
    faces, barycentric = examples.truth(name, mirrored=mirrored, reverse=reverse)
    return np.einsum("ijk,ij->ik", mesh.vertices[mesh.faces[faces]], barycentric)


def renumbered(arrays: Arrays, seed: int = 0) -> tuple[Arrays, np.ndarray]:
    """The same surface with vertices and faces in another order, and the new number of each old vertex."""
    vertices, faces = arrays
    rng = np.random.default_rng(seed)
    order = rng.permutation(len(vertices))
    new = np.empty_like(order)
    new[order] = np.arange(len(order))
    turned = np.array(
        [np.roll(face, shift) for face, shift in zip(new[faces], rng.integers(0, 3, len(faces)), strict=True)]
    )
    return (vertices[order], turned[rng.permutation(len(faces))]), new


def rotation(seed: int = 0) -> np.ndarray:
    """A random rotation matrix."""
    q, r = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    q *= np.sign(np.diag(r))
    return q if np.linalg.det(q) > 0 else -q


def cap(seed: int = 0, *, bend: float = 0.0, count: int = 1500) -> Arrays:
    """A disc with three bumps of different height, counter-clockwise from above, meshed by the seed.

    The first two coordinates without a bend are those of the flat disc; with it, that many radians are rolled up.
    """
    vertices, faces = disc(count, seed=seed)
    x, y = vertices[:, 0], vertices[:, 1]
    z = 0.4 * (1 - x**2 - y**2)
    for height, width, at in ((0.5, 0.2, (0.45, 0.1)), (0.3, 0.25, (-0.2, 0.5)), (0.35, 0.15, (-0.3, -0.4))):
        z += height * np.exp(-((x - at[0]) ** 2 + (y - at[1]) ** 2) / width**2)
    if bend:
        angle, radius = bend * x / 2, 2 / bend
        return np.column_stack([(radius - z) * np.sin(angle), y, radius - (radius - z) * np.cos(angle)]), faces
    return np.column_stack([x, y, z]), faces
