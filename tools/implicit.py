"""Bodies as smooth unions of simple solids, and their surfaces by marching cubes near the surface only."""

import igl
import numpy as np
from relax import Floats, Ints

from mobius_match._core.compiling import jit

BLOCK = 4  # cells along the side of a block that is looked at or skipped as a whole
CONE, BOX = 0.0, 1.0  # kinds of solids
WIDTH = 17  # numbers of one solid: kind, sign, head, tail, radii at both ends, seam, flat axis, flatness, rounding


@jit
def _smooth_union(points: np.ndarray, solids: np.ndarray, balls: np.ndarray, field: np.ndarray) -> None:
    """The field of ``solids``, one after another, at each of the points; ``balls`` (k, 5) contain them."""
    for i in range(len(points)):
        value = 10.0  # farther than anything
        for k in range(len(solids)):
            seam = solids[k, 10]
            # What is farther away than the fillet is wide changes nothing.
            x, y, z = points[i, 0] - balls[k, 0], points[i, 1] - balls[k, 1], points[i, 2] - balls[k, 2]
            reach = seam + (value if solids[k, 1] > 0 else -value)
            reach = balls[k, 3] + (reach * balls[k, 4] if reach > 0 else reach)
            if reach < 0 or x * x + y * y + z * z > reach * reach:
                continue
            one = _solid(points[i, 0], points[i, 1], points[i, 2], solids[k])
            if solids[k, 1] > 0:
                overlap = max(seam - abs(value - one), 0.0)
                value = min(value, one)
                if seam > 0:
                    value -= overlap * overlap / (4 * seam)
            else:  # taken away
                overlap = max(seam - abs(value + one), 0.0)
                value = max(value, -one)
                if seam > 0:
                    value += overlap * overlap / (4 * seam)
        field[i] = value


@jit
def _solid(x: float, y: float, z: float, solid: np.ndarray) -> float:
    """Signed distance to a solid, of first order near its surface."""
    hx, hy, hz = solid[2], solid[3], solid[4]
    ax, ay, az = solid[5] - hx, solid[6] - hy, solid[7] - hz
    nx, ny, nz = solid[11], solid[12], solid[13]
    px, py, pz = x - hx, y - hy, z - hz
    if solid[0] == BOX:
        length = np.sqrt(ax * ax + ay * ay + az * az)
        ax, ay, az = ax / length, ay / length, az / length
        bx, by, bz = ay * nz - az * ny, az * nx - ax * nz, ax * ny - ay * nx
        rounding = solid[15]
        u = abs(px * ax + py * ay + pz * az - length / 2) - length / 2 + rounding
        v = abs(px * nx + py * ny + pz * nz) - solid[8] + rounding
        w = abs(px * bx + py * by + pz * bz) - solid[9] + rounding
        outside = np.sqrt(max(u, 0.0) ** 2 + max(v, 0.0) ** 2 + max(w, 0.0) ** 2)
        return outside + min(max(u, v, w), 0.0) - rounding
    # A cone with round ends, in space stretched along the flat axis.
    stretch = 1 / solid[14] - 1
    s = (px * nx + py * ny + pz * nz) * stretch
    t = (ax * nx + ay * ny + az * nz) * stretch
    px, py, pz = px + s * nx, py + s * ny, pz + s * nz
    ax, ay, az = ax + t * nx, ay + t * ny, az + t * nz
    squared = ax * ax + ay * ay + az * az
    along = 0.0
    if squared > 0:
        along = min(max((px * ax + py * ay + pz * az) / squared, 0.0), 1.0)
    dx, dy, dz = px - along * ax, py - along * ay, pz - along * az
    distance = np.sqrt(dx * dx + dy * dy + dz * dz)
    value = distance - (solid[8] + along * (solid[9] - solid[8]))
    # The stretch makes the slope steeper; inside, the surface may be near in the flat direction.
    if value < 0:
        value /= 1 + stretch
    elif distance > 0:
        across = (dx * nx + dy * ny + dz * nz) / distance
        value /= np.sqrt(1 + ((1 + stretch) ** 2 - 1) * across * across)
    return value


def field(points: Floats, solids: Floats) -> Floats:
    """Signed distance, of first order near the surface, of points (n, 3) to the smooth union of solids (k, WIDTH)."""
    values = np.empty(len(points))
    _smooth_union(np.ascontiguousarray(points), solids, _balls(solids), values)
    return values


def _balls(solids: Floats) -> Floats:
    """Centre and radius of a ball around each solid, and how much its field may fall short of the distance."""
    head, tail = solids[:, 2:5], solids[:, 5:8]
    wide = np.where(solids[:, 0] == BOX, np.hypot(solids[:, 8], solids[:, 9]), solids[:, 8:10].max(axis=1))
    radius = np.linalg.norm(tail - head, axis=1) / 2 + wide
    return np.column_stack([(head + tail) / 2, radius, np.maximum(1, 0.6 / solids[:, 14])])


def surface(solids: Floats, step: float, turn: Floats, shift: Floats) -> tuple[Floats, Ints]:
    """The surface of the union: vertices (n, 3), faces (m, 3) outward.

    ``turn`` (3, 3) and ``shift`` (3,), in steps, are how the grid of the marching cubes lies: another grid,
    another triangulation.
    """
    reach = np.maximum(solids[:, 8], solids[:, 9])[:, None] + 3 * step
    boxes = solids[:, 0] == BOX
    reach[boxes] += np.linalg.norm(solids[boxes, 5:8] - solids[boxes, 2:5], axis=1)[:, None]
    ends = np.concatenate([solids[:, 2:5] @ turn, solids[:, 5:8] @ turn])
    low, high = (ends - np.tile(reach, (2, 1))).min(axis=0), (ends + np.tile(reach, (2, 1))).max(axis=0)
    low = low + (shift - 1) * step
    counts = np.ceil((high - low) / (BLOCK * step)).astype(int) + 1
    blocks = np.stack(np.meshgrid(*map(np.arange, counts), indexing="ij"), axis=-1).reshape(-1, 3)
    centres = ((blocks + 0.5) * BLOCK * step + low) @ turn.T
    blocks = blocks[np.abs(field(centres, solids)) < 1.1 * BLOCK * step]
    inside = np.stack(np.meshgrid(*[np.arange(BLOCK)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    cells = (blocks[:, None] * BLOCK + inside).reshape(-1, 3)
    corners = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)])
    size = counts * BLOCK + 2
    lattice = (cells[:, None] + corners).reshape(-1, 3)
    keys, cubes = np.unique((lattice[:, 0] * size[1] + lattice[:, 1]) * size[2] + lattice[:, 2], return_inverse=True)
    lattice = np.stack([keys // (size[1] * size[2]), keys // size[2] % size[1], keys % size[2]], axis=1)
    points = (lattice * step + low) @ turn.T
    values = field(points, solids)
    least = 0.05 * step
    values = np.where(np.abs(values) < least, np.copysign(least, values), values)  # no two vertices in one place
    vertices, faces, _ = igl.marching_cubes(values, points, cubes.reshape(-1, 8), 0.0)
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    if np.einsum("ij,ij->", a, np.cross(b, c)) < 0:
        faces = faces[:, ::-1]
    return vertices, np.ascontiguousarray(faces)
