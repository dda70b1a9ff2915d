"""The quadruped: a fox-like animal of our own, the smooth union of round cones along a skeleton."""

import numpy as np
from scipy.sparse import csr_array, diags_array, eye_array
from scipy.sparse.linalg import splu
from skimage.measure import marching_cubes
from template import Bone, Floats, Ints, Template

GRID = 0.007  # metres, of the marching cubes
SKIN = 0.035  # metres over which the hold of one bone gives way to that of the next
EMPTY = 10.0  # farther than anything

# name, bone it hangs from, head (x, y, z), radius there, tail (x, y, z), radius there, and the width of the
# seam to the bones above, in metres. A name that ends in ".L" stands for a bone on either side.
BONES = (
    ("chest", "", (0, 0.550, 0.00), 0.122, (0, 0.530, 0.19), 0.128, 0.00),
    ("loin", "chest", (0, 0.558, -0.02), 0.116, (0, 0.575, -0.24), 0.094, 0.02),
    ("rump", "loin", (0, 0.575, -0.24), 0.094, (0, 0.560, -0.37), 0.094, 0.01),
    ("neck", "chest", (0, 0.590, 0.21), 0.095, (0, 0.770, 0.37), 0.070, 0.07),
    ("head", "neck", (0, 0.800, 0.40), 0.082, (0, 0.800, 0.44), 0.074, 0.04),
    ("snout", "head", (0, 0.780, 0.47), 0.052, (0, 0.752, 0.61), 0.029, 0.05),
    ("nose", "snout", (0, 0.768, 0.62), 0.020, (0, 0.768, 0.63), 0.019, 0.012),
    ("tail1", "rump", (0, 0.600, -0.42), 0.036, (0, 0.550, -0.55), 0.046, 0.05),
    ("tail2", "tail1", (0, 0.550, -0.55), 0.046, (0, 0.470, -0.68), 0.054, 0.01),
    ("tail3", "tail2", (0, 0.470, -0.68), 0.054, (0, 0.385, -0.80), 0.018, 0.01),
    ("ear.L", "head", (0.048, 0.855, 0.39), 0.040, (0.076, 0.965, 0.375), 0.010, 0.025),
    ("shoulder.L", "chest", (0.070, 0.550, 0.18), 0.074, (0.088, 0.430, 0.22), 0.062, 0.03),
    ("upperarm.L", "shoulder.L", (0.088, 0.430, 0.22), 0.062, (0.096, 0.330, 0.150), 0.047, 0.01),
    ("forearm.L", "upperarm.L", (0.096, 0.330, 0.150), 0.047, (0.094, 0.150, 0.165), 0.032, 0.01),
    ("forepaw.L", "forearm.L", (0.094, 0.150, 0.165), 0.032, (0.094, 0.045, 0.165), 0.032, 0.00),
    ("foretoes.L", "forepaw.L", (0.094, 0.037, 0.175), 0.036, (0.094, 0.031, 0.220), 0.030, 0.02),
    ("thigh.L", "rump", (0.065, 0.530, -0.34), 0.094, (0.100, 0.370, -0.265), 0.062, 0.04),
    ("shin.L", "thigh.L", (0.100, 0.370, -0.265), 0.062, (0.096, 0.190, -0.400), 0.034, 0.01),
    ("hindpaw.L", "shin.L", (0.096, 0.190, -0.400), 0.034, (0.096, 0.045, -0.370), 0.031, 0.00),
    ("hindtoes.L", "hindpaw.L", (0.096, 0.037, -0.360), 0.035, (0.096, 0.031, -0.315), 0.030, 0.02),
)

SWELL = {"head": 1.35, "forepaw.L": 1.3, "forepaw.R": 1.3, "hindpaw.L": 1.3, "hindpaw.R": 1.3}

POSES: tuple[dict[str, tuple[float, float, float]], ...] = (
    {},
    {
        "chest": (-5, 0, 0), "loin": (6, 8, 0), "rump": (8, 6, 0),
        "neck": (8, 16, 0), "head": (12, 24, 6), "ear.R": (-10, 0, 0), "ear.L": (-10, 0, 0),
        "tail1": (32, 0, 0), "tail2": (25, 0, 12), "tail3": (20, 0, 12),
        "shoulder.L": (-18, 0, 0), "upperarm.L": (-16, 0, 0), "forearm.L": (14, 0, 0),
        "forepaw.L": (10, 0, 0),
        "shoulder.R": (8, 0, 0), "upperarm.R": (0, 0, 0), "forearm.R": (-46, 0, 0), "forepaw.R": (58, 0, 0),
        "thigh.L": (20, 0, 0), "shin.L": (-4, 0, 0), "hindpaw.L": (10, 0, 0),
        "thigh.R": (-32, 0, 0), "shin.R": (14, 0, 0), "hindpaw.R": (-6, 0, 0),
    },
)  # fmt: skip


def load() -> Template:
    """The animal at rest, symmetric, closed, in metres."""
    rows = [row for bone in BONES for row in (bone, _opposite(bone)) if row is not None]
    half, triangles = _polygonise(rows)
    evened = _even(*_double(half, triangles), rows)[: len(half)]
    evened[half[:, 0] == 0, 0] = 0
    vertices, faces = _double(evened, triangles)
    bones = {name: Bone(np.array(head), np.array(tail), parent) for name, parent, head, _, tail, _, _ in rows}
    depth = np.column_stack([_round_cone(vertices, *row[2:6]) for row in rows])
    return Template(vertices, faces, bones, _spread(faces, depth.argmin(axis=1), len(rows)), SWELL)


def _opposite(bone: tuple) -> tuple | None:
    """The bone on the right of one on the left; None for a bone in the middle."""
    name, parent, (x, y, z), radius, (u, v, w), end, seam = bone
    if not name.endswith(".L"):
        return None
    return name[:-1] + "R", parent.replace(".L", ".R"), (-x, y, z), radius, (-u, v, w), end, seam


def _round_cone(points: Floats, head: tuple, radius: float, tail: tuple, end: float) -> Floats:
    """Signed distance (..., 3) -> (...) to the hull of two balls, good where radii differ little."""
    axis = np.subtract(tail, head)
    along = np.clip((points - head) @ axis / (axis @ axis), 0, 1)
    distance = np.linalg.norm(points - head - along[..., None] * axis, axis=-1)
    return distance - (radius + along * (end - radius))


def _field(points: Floats, rows: list[tuple]) -> Floats:
    """Signed distance (..., 3) -> (...) to the smooth union of all cones, exact enough near the surface."""
    field = np.full(points.shape[:-1], EMPTY)
    for _, _, head, radius, tail, end, seam in rows:
        cone = _round_cone(points, head, radius, tail, end)
        overlap = np.maximum(seam - np.abs(field - cone), 0)
        field = np.minimum(field, cone) - (overlap**2 / (4 * seam) if seam else 0)
    return field


def _polygonise(rows: list[tuple]) -> tuple[Floats, Ints]:
    """The left half of the surface, open along the plane x = 0."""
    low, high = np.array([0, -0.05, -0.9]), np.array([0.25, 1.05, 0.75])
    grid = np.stack(np.meshgrid(*map(np.arange, low, high, [GRID] * 3), indexing="ij"), axis=-1)
    field = _field(grid, rows)
    field[np.abs(field) < 0.02 * GRID] = 0.02 * GRID  # no two vertices in one place
    vertices, faces, _, _ = marching_cubes(field, 0.0, spacing=(GRID,) * 3, gradient_direction="descent")
    return vertices.astype(float) + low, faces.astype(np.int64)


def _double(half: Floats, triangles: Ints) -> tuple[Floats, Ints]:
    """The half and its mirror image, joined along the plane x = 0."""
    seam = half[:, 0] == 0
    other = np.where(seam, np.arange(len(half)), len(half) + np.cumsum(~seam) - 1)
    return np.vstack([half, half[~seam] * [-1, 1, 1]]), np.vstack([triangles, other[triangles][:, ::-1]])


def _links(faces: Ints, n: int) -> csr_array:
    """Which vertices share an edge (n, n)."""
    sides = np.vstack([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    return csr_array((np.ones(len(sides)), sides.T), shape=(n, n))


def _even(vertices: Floats, faces: Ints, rows: list[tuple]) -> Floats:
    """Vertices spread evenly over the surface: the slivers of the marching cubes go."""
    links = _links(faces, len(vertices))
    mean = diags_array(1 / links.sum(axis=1)) @ links
    for _ in range(5):
        vertices = mean @ vertices
        for _ in range(2):
            height = _field(vertices, rows)
            slope = [(_field(vertices + step, rows) - height) / 1e-6 for step in 1e-6 * np.eye(3)]
            slope = np.column_stack(slope)
            vertices = vertices - (height / (slope**2).sum(axis=1))[:, None] * slope
    return vertices


def _spread(faces: Ints, nearest: Ints, count: int) -> Floats:
    """Skin weights (n, count): each vertex held by its nearest bone, then let flow over the surface."""
    n = len(nearest)
    links = _links(faces, n)
    flow = diags_array(links.sum(axis=1)) - links
    step = splu((eye_array(n) + (SKIN / GRID) ** 2 / 8 * flow).tocsc())
    weights = step.solve(step.solve(np.eye(count)[nearest]))
    return weights / weights.sum(axis=1, keepdims=True)
