"""A kind of body: its bones and solids at rest, how they vary, and how its surface follows them.

All instances of a kind are images of one template surface. That is what makes the truth exact: a point of the template
(a face and barycentric coordinates) has a place in every instance.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from dataclasses import field as default

import igl
import numpy as np
from implicit import BOX, CONE, surface
from implicit import field as values_of
from relax import Floats, Ints, relaxed
from scipy.sparse import coo_array, csr_array, diags_array, eye_array
from scipy.sparse.linalg import splu
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from mobius_match.mesh.simplify import simplify

Range = float | tuple[float, float]  # degrees: up to so many in both directions, or from one to the other
FINE = 2.5  # times as many vertices as the largest instance has, in the marching cubes
ROUNDS = 5  # of the relaxation of a pose
INHERITED, OWN = 0.5, 0.75  # share of the parent's proportions in those of a bone, and of its own


@dataclass(frozen=True)
class Bone:
    """A bone with the solid around it. A name that ends in ".L" stands for one on either side of the plane x = 0."""

    name: str
    parent: str
    head: Sequence[float]
    tail: Sequence[float]
    radius: float  # at the head; of a box: half its width along ``flat``
    end: float | None = None  # at the tail; of a box: half its width across
    seam: float = 0.02  # width of the fillet to the solids above it
    flat: Sequence[float] = (0, 0, 1)  # direction in which the solid is flattened
    flatness: float = 1.0  # to this factor
    joint: tuple[Range, Range, Range] = (0, 0, 0)  # turns about x, y, z
    hinge: tuple[Sequence[float], float, float] | None = None  # one more turn: axis, from, to
    together: str = ""  # bones of one word take the same turns, mirrored on the other side; "-word" the opposite
    size: str = ""  # bones of one word share their proportions; else the name without side and number
    carved: bool = False  # taken away instead of added
    box: float = 0.0  # rounding of a box, 0 for a round cone

    def opposite(self) -> "Bone | None":
        """The bone on the other side; None for a bone in the middle."""
        if not self.name.endswith(".L"):
            return None
        mirror = [-1, 1, 1]
        other = {key: tuple(np.multiply(getattr(self, key), mirror)) for key in ("head", "tail", "flat")}
        rest = {key: value for key, value in self.__dict__.items() if key not in other}
        names = {"name": self.name[:-1] + "R", "parent": self.parent.replace(".L", ".R")}
        return Bone(**(rest | other | names))

    def solid(self) -> list[float]:
        """Its row for the kernel of ``implicit``."""
        end = self.radius if self.end is None else self.end
        kind, sign = (BOX if self.box else CONE), (-1 if self.carved else 1)
        flat = np.divide(self.flat, np.linalg.norm(self.flat))
        return [kind, sign, *self.head, *self.tail, self.radius, end, self.seam, *flat, self.flatness, self.box, 0.0]

    def group(self) -> str:
        """The word under which its proportions are drawn."""
        return self.size or self.name.removesuffix(".L").removesuffix(".R").rstrip("0123456789")


@dataclass(frozen=True)
class Kind:
    """A kind of body at rest, about one unit large; x points to its left, y up, z forward."""

    name: str
    bones: Sequence[Bone]
    landmarks: dict[str, Sequence[float]] = default(default_factory=dict)  # named places near the surface at rest
    mirror: bool = True  # whether the plane x = 0 mirrors it
    turns: int = 1  # order of its near-symmetry about an axis through the origin
    axis: Sequence[float] = (0, 1, 0)
    smooth: bool = False  # whether every turn about the axis is a symmetry
    length: float = 1.5  # proportions vary up to this factor, both ways
    thickness: float = 1.4
    variety: Sequence[float] = (8, 8, 8)  # degrees about x, y, z by which bones of individuals are turned at rest
    bumps: float = 0.2  # height of local bumps in radii of the solid below
    genus: int = 0
    cut: float | None = None  # an open kind: what lies below this height is cut off
    reach: float = 0.3  # stiffness of the skin in poses: how far a bend spreads

    def all_bones(self) -> list[Bone]:
        """Bones on both sides, parents before children."""
        return [one for bone in self.bones for one in (bone, bone.opposite()) if one is not None]


def projected(points: Floats, solids: Floats) -> Floats:
    """Points near the surface moved onto it."""
    for _ in range(2):
        height = values_of(points, solids)
        slope = np.column_stack([(values_of(points + step, solids) - height) / 1e-6 for step in 1e-6 * np.eye(3)])
        squared = np.maximum((slope**2).sum(axis=1), 0.3)
        points = points - (height / squared)[:, None] * slope
    return points


class Template:
    """The surface of a kind at rest, with skin."""

    def __init__(self, kind: Kind, count: int) -> None:
        """``count`` is the number of vertices, and the most that an instance has."""
        self.kind = kind
        self.bones = kind.all_bones()
        self.solids = np.array([bone.solid() for bone in self.bones])
        still = np.eye(3), np.full(3, 0.5)
        step = 0.02
        for _ in range(2):  # so fine that the surface has so many vertices, about
            vertices, faces = surface(self.solids, step, *still)
            step *= np.sqrt(len(vertices) / (FINE * count))
        self.step = step
        vertices, faces = surface(self.solids, step, *still)
        kept, self.faces, _ = simplify(vertices, faces, count)
        self.vertices = projected(vertices[kept], self.solids)
        depth = np.column_stack([_depth(self.vertices, row) for row in self.solids])
        nearest = depth.argmin(axis=1)
        ends = self.solids[:, 8:10]
        thick = np.where(self.solids[:, 0] == BOX, ends.min(axis=1), ends.max(axis=1) * self.solids[:, 14])
        smooth = _smoother(self.vertices, self.faces, thick[nearest])
        self.weights = smooth(np.eye(len(self.bones))[nearest])
        self.weights /= self.weights.sum(axis=1, keepdims=True)
        self.radius = self.weights @ thick  # of the body around each vertex
        self.directions = smooth(igl.per_vertex_normals(self.vertices, self.faces))  # in which bumps rise

    def locate(self, points: Floats, normals: Floats) -> tuple[Ints, Floats]:
        """Face (k,) and barycentric coordinates (k, 3) of the nearest point that faces the same way."""
        return locate(points, normals, self.vertices, self.faces)

    def image(self, word: str) -> Floats:
        """The vertices under a symmetry of the rest pose: "sym" is the mirror, "turnK" the K-th part of a turn."""
        return self.vertices @ symmetry(self.kind, word).T


def symmetry(kind: Kind, word: str) -> Floats:
    """The matrix of a symmetry at rest."""
    if word == "sym":
        return np.diag([-1.0, 1, 1])
    angle = 2 * np.pi * int(word.removeprefix("turn")) / kind.turns
    axis = np.divide(kind.axis, np.linalg.norm(kind.axis))
    return Rotation.from_rotvec(angle * axis).as_matrix()


def locate(points: Floats, normals: Floats, vertices: Floats, faces: Ints) -> tuple[Ints, Floats]:
    """Face (k,) and barycentric coordinates (k, 3) of the nearest point of a mesh whose normal agrees."""
    _, found, closest = igl.point_mesh_squared_distance(points, vertices, faces)
    corners = vertices[faces]
    crossed = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(crossed, axis=1, keepdims=True)
    facing = crossed / np.maximum(lengths, 1e-30)
    wrong = np.flatnonzero(np.einsum("ij,ij->i", facing[found], normals) < 0)
    if len(wrong):
        edge = np.sqrt(lengths.mean())
        tree = cKDTree(np.hstack([corners.mean(axis=1), 3 * edge * facing]))
        _, near = tree.query(np.hstack([points[wrong], 3 * edge * normals[wrong]]), k=12)
        for i, candidates in zip(wrong, near, strict=True):
            _, which, place = igl.point_mesh_squared_distance(points[i : i + 1], vertices, faces[candidates])
            found[i], closest[i] = candidates[which.item()], place
    return found, barycentric(closest, corners[found])


def barycentric(points: Floats, corners: Floats) -> Floats:
    """Barycentric coordinates (k, 3) of points (k, 3) in triangles (k, 3, 3), none of them negative."""
    found = igl.barycentric_coordinates(points, *(np.ascontiguousarray(corners[:, i]) for i in range(3)))
    found = np.clip(np.nan_to_num(found, nan=1 / 3), 0, 1)
    return found / found.sum(axis=1, keepdims=True)


def _depth(points: Floats, solid: Floats) -> Floats:
    """Distance of points from one solid alone; carved ones count with their wall."""
    alone = solid.copy()
    alone[1], alone[10] = 1, 0
    distance = values_of(points, alone[None])
    return np.abs(distance) if solid[1] < 0 else distance


def _smoother(vertices: Floats, faces: Ints, radius: Floats) -> Callable[[Floats], Floats]:
    """Spreads values (n, k) at the vertices over the surface, by about the radius of the body there."""
    n = len(radius)
    edges = igl.edges(faces)
    start, end = np.vstack([edges, edges[:, ::-1]]).T
    length = np.linalg.norm(vertices[start] - vertices[end], axis=1)
    weight = radius[start] * radius[end] / (length**2 * 5)
    links = csr_array(coo_array((weight, (start, end)), shape=(n, n)))
    step = splu((eye_array(n) + diags_array(links.sum(axis=1)) - links).tocsc())
    return lambda values: step.solve(step.solve(values))


@dataclass(frozen=True)
class Proportions:
    """How an individual differs from the mean of its kind."""

    scale: dict[str, tuple[float, float]]  # of a group of bones: length, thickness
    turns: dict[str, Floats]  # of bones at rest, rotation vectors in degrees
    bumps: Floats  # (n,) heights at the vertices of the template


def draw_proportions(template: Template, rng: np.random.Generator, strength: float = 1.0) -> Proportions:
    """An individual: lengths and thicknesses of groups of bones, and bumps, as symmetric as the kind."""
    kind = template.kind
    powers: dict[str, Floats] = {"": rng.uniform(-0.6, 0.6, 2)}  # of the factors of length and thickness
    scale: dict[str, tuple[float, float]] = {}
    group = {bone.name: bone.group() for bone in template.bones}
    for bone in template.bones:  # what hangs together is alike
        power = INHERITED * powers[group.get(bone.parent, "")] + OWN * rng.uniform(-1, 1, 2)
        along, across = strength * powers.setdefault(bone.group(), power)
        scale.setdefault(bone.group(), (kind.length**along, kind.thickness**across))
    turns: dict[str, Floats] = {}
    for bone in template.bones:
        turn = strength * np.multiply(kind.variety, rng.uniform(-1, 1, 3))
        if bone.name.endswith(".R"):
            turn = turns[bone.name[:-1] + "L"] * [1, -1, -1]
        elif kind.mirror and not bone.name.endswith(".L"):
            turn = turn * [1, 0, 0]
        turns[bone.name] = turn * (not bone.carved)
    bumps = np.zeros(len(template.vertices))
    words = ["turn0"] if kind.turns == 1 or kind.smooth else [f"turn{k}" for k in range(kind.turns)]
    words += ["sym"] if kind.mirror else []
    for centre in rng.choice(len(bumps), 12, replace=False):
        spread = template.radius[centre] * rng.uniform(0.7, 1.6)
        height = kind.bumps * rng.uniform(-1, 1)
        places = [symmetry(kind, word) @ template.vertices[centre] for word in words]
        if not kind.smooth:
            bumps += height * np.max([_bump(template.vertices - place, spread) for place in places], axis=0)
    return Proportions(scale, turns, bumps * template.radius)


def _bump(away: Floats, spread: float) -> Floats:
    return np.exp(-(away**2).sum(axis=1) / (2 * spread**2))


def draw_pose(template: Template, rng: np.random.Generator) -> dict[str, Floats]:
    """Turns of the bones within their ranges, as rotation vectors in degrees."""
    turns: dict[str, Floats] = {}
    shared: dict[str, Floats] = {}
    for bone in template.bones:
        ranges = [(-one, one) if isinstance(one, int | float) else one for one in bone.joint]
        turn = np.array([rng.uniform(low, high) for low, high in ranges])
        if bone.hinge is not None:
            axis, low, high = bone.hinge
            turn = turn + rng.uniform(low, high) * np.divide(axis, np.linalg.norm(axis))
        if bone.together:
            sign = -1 if bone.together.startswith("-") else 1
            turn = sign * shared.setdefault(bone.together.removeprefix("-"), sign * turn)
        turns[bone.name] = turn * [1, -1, -1] if bone.name.endswith(".R") else turn
    return turns


def posed(template: Template, proportions: Proportions, turns: dict[str, Floats]) -> Floats:
    """Vertices (n, 3) of the template as an individual in a pose."""
    start = template.vertices + proportions.bumps[:, None] * template.directions
    rest = _skinned(template, start, proportions.scale, proportions.turns)
    if not turns:
        return rest
    both = {name: turn + proportions.turns[name] for name, turn in turns.items()}
    bent = _skinned(template, start, proportions.scale, both)
    return relaxed(rest, bent, template.faces, template.kind.reach, ROUNDS)


def _skinned(
    template: Template, start: Floats, scale: dict[str, tuple[float, float]], turns: dict[str, Floats]
) -> Floats:
    """Linear blend skinning with bones that are scaled along and across their axis."""
    rotation: dict[str, Floats] = {"": np.eye(3)}
    linear: dict[str, Floats] = {"": np.eye(3)}
    offset: dict[str, Floats] = {"": np.zeros(3)}
    moved = np.zeros_like(start)
    for column, bone in enumerate(template.bones):
        turn = Rotation.from_rotvec(turns[bone.name], degrees=True).as_matrix()
        rotation[bone.name] = rotation[bone.parent] @ turn
        length, thickness = scale[bone.group()]
        axis = np.subtract(bone.tail, bone.head)
        along = np.outer(axis, axis) / max(axis @ axis, 1e-30)
        linear[bone.name] = rotation[bone.name] @ (thickness * np.eye(3) + (length - thickness) * along)
        head = linear[bone.parent] @ bone.head + offset[bone.parent]
        offset[bone.name] = head - linear[bone.name] @ bone.head
        moved += template.weights[:, column, None] * (start @ linear[bone.name].T + offset[bone.name])
    return moved
