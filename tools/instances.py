"""One instance of a kind: an individual in a pose, meshed on its own."""

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import igl
import numpy as np
import trimesh
from bodies import Kind, Proportions, Template, draw_pose, draw_proportions, posed
from implicit import surface
from relax import Floats, Ints
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from mobius_match.mesh.simplify import simplify

CALMER = 0.7  # how much less a pose bends after one in which parts of the body overlap
FOLDED = 0.001  # of the faces may lie inside others, in creases of the skin
MILDER = 0.9  # the same for proportions
SHARPEST = np.radians(0.2)  # angle of a triangle
TRIES = 8


@dataclass(frozen=True)
class Instance:
    """A mesh, and what is known of it."""

    vertices: Floats  # (k, 3) float32 values
    faces: Ints  # (l, 3), outward
    template_faces: Ints  # (k,) the template's face that each vertex lies on
    barycentric: Floats  # (k, 3) and where on it
    posed: Floats  # (n, 3) vertices of the template in the place of this instance

    def vertices_at(self, points: Floats, normals: Floats) -> Ints:
        """The vertex nearest to each point (j, 3) whose normal agrees with the point's."""
        tree, scale = self._tree
        return tree.query(np.hstack([points, scale * normals]))[1].astype(np.int64)

    @cached_property
    def _tree(self) -> tuple[cKDTree, float]:
        """The vertices with their normals, which count as much as two edges."""
        scale = 2 * np.sqrt(trimesh.triangles.area(self.vertices[self.faces]).sum() / len(self.vertices))
        return cKDTree(np.hstack([self.vertices, scale * igl.per_vertex_normals(self.vertices, self.faces)])), scale


def individual(template: Template, rng: np.random.Generator) -> Proportions:
    """Proportions, nearer to the mean where parts of the body would overlap."""
    for tried in range(2 * TRIES):
        proportions = draw_proportions(template, rng, MILDER**tried)
        if not overlaps(posed(template, proportions, {}), template.faces):
            return proportions
    raise RuntimeError(f"{template.kind.name}: parts of the body overlap in all proportions")


def make(template: Template, proportions: Proportions, count: int, rng: np.random.Generator) -> Instance:
    """An individual in a new pose and place, on a new triangulation of so many vertices."""
    turns = draw_pose(template, rng)
    for _ in range(TRIES):
        placed = posed(template, proportions, turns)
        if not overlaps(placed, template.faces):
            break
        turns = {name: CALMER * turn for name, turn in turns.items()}
    else:
        raise RuntimeError(f"{template.kind.name}: parts of the body overlap in every pose")
    placed = placed @ Rotation.random(rng=rng).as_matrix().T * rng.uniform(0.5, 2)
    for _ in range(TRIES):
        vertices, faces, at, where = _triangulated(template, placed, count, rng)
        if _is_sound(vertices, faces, template.kind):
            return Instance(vertices, faces, at, where, placed)
    raise RuntimeError(f"{template.kind.name}: no sound mesh was found")


def _triangulated(
    template: Template, placed: Floats, count: int, rng: np.random.Generator
) -> tuple[Floats, Ints, Ints, Floats]:
    """A triangulation that owes nothing to the template's, all vertices on the template's surface."""
    rest, faces = surface(template.solids, template.step, Rotation.random(rng=rng).as_matrix(), rng.random(3))
    if template.kind.cut is not None:
        rest, faces = clipped(rest, faces, template.kind.cut, 0.3 * template.step)
    at, where = template.locate(rest, igl.per_vertex_normals(rest, faces))
    fine = np.einsum("ki,kij->kj", where, placed[template.faces[at]])
    kept, faces, _ = simplify(fine, faces, count)
    order = rng.permutation(len(kept))
    faces = rng.permutation(np.argsort(order)[faces])
    kept = kept[order]
    return fine[kept].astype(np.float32).astype(float), faces, at[kept], where[kept]


def overlaps(vertices: Floats, faces: Ints) -> bool:
    """Whether parts of a closed surface lie inside others: just outside of it the winding number is not 0."""
    edge = np.sqrt(trimesh.triangles.area(vertices[faces]).mean())
    centres = vertices[faces].mean(axis=1)
    normals = igl.per_face_normals(vertices, faces, np.zeros(3))
    inside = igl.fast_winding_number(vertices, faces, centres + 0.1 * edge * normals) > 0.5
    return bool(inside.mean() > FOLDED)


def _is_sound(vertices: Floats, faces: Ints, kind: Kind) -> bool:
    """Closed, or with one boundary where the kind is open; in one piece, of its genus, outward, without slivers."""
    mesh = trimesh.Trimesh(vertices, faces, process=False)
    euler = 2 - 2 * kind.genus - (kind.cut is not None)
    if mesh.euler_number != euler or mesh.body_count != 1 or not mesh.is_winding_consistent:
        return False
    if mesh.face_angles.min() < SHARPEST:
        return False
    return kind.cut is not None or (mesh.is_watertight and mesh.volume > 0)


def clipped(vertices: Floats, faces: Ints, height: float, snap: float) -> tuple[Floats, Ints]:
    """What lies above a height y; vertices within ``snap`` of it come to lie on it."""
    vertices = vertices.copy()
    vertices[np.abs(vertices[:, 1] - height) < snap, 1] = height
    above = vertices[:, 1] - height
    points, cuts = list(vertices), dict[tuple[int, int], int]()
    lowest = above[faces].min(axis=1)
    triangles = faces[lowest >= 0].tolist()
    for face in faces[(lowest < 0) & (above[faces].max(axis=1) > 0)].tolist():
        polygon = []
        for a, b in zip(face, face[1:] + face[:1], strict=True):
            if above[a] >= 0:
                polygon.append(a)
            if above[a] * above[b] < 0:
                key = (min(a, b), max(a, b))
                if key not in cuts:
                    share = above[key[0]] / (above[key[0]] - above[key[1]])
                    cuts[key] = len(points)
                    points.append(vertices[key[0]] + share * (vertices[key[1]] - vertices[key[0]]))
                polygon.append(cuts[key])
        triangles += [(polygon[0], b, c) for b, c in pairwise(polygon[1:])]
    used, numbered = np.unique(np.array(triangles), return_inverse=True)
    return np.array(points)[used], numbered.reshape(-1, 3)
