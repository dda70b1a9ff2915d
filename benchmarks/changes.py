"""What the benchmarks of robustness and of partial shapes share: pairs, meshes changed in known ways, errors."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import igl
import numpy as np
from scipy.spatial import cKDTree

from mobius_match.errors import FormatError
from mobius_match.evaluation import Case, Truth, find_dataset
from mobius_match.evaluation.scoring import Scorer, cached_diameter
from mobius_match.mesh import Mesh
from mobius_match.mesh.measure import areas, cross_products, vertex_sums
from mobius_match.mesh.topology import components, edge_table, used_vertices

FLATTEST = 0.1
"""Least height of a triangle that a flip makes, per longest edge."""
SHARPEST = 0.5
"""Least cosine between the normals of a triangle that a flip makes and of the two that were there."""

SAME_WAY = 0.5
"""Weight of a unit normal beside a place in space, in mean edge lengths."""


@dataclass(frozen=True, eq=False)
class Changed:
    """A changed mesh, and which of its vertices are those of the original.

    Parameters
    ----------
    vertices, faces
        (n', 3) and (m', 3) of the changed mesh.
    home
        (n,): the vertex that each vertex of the original is now, or is nearest to.
    apart
        (n,): how far it moved on the surface for that, in the units of the changed mesh.
    """

    vertices: np.ndarray
    faces: np.ndarray
    home: np.ndarray
    apart: np.ndarray

    def carry(self, truth: Truth) -> Truth:
        """The truth of a pair whose target was changed."""
        mirrored = None if truth.mirrored is None else self.home[truth.mirrored]
        return replace(truth, target=self.home[truth.target], mirrored=mirrored)


Change = Callable[[np.ndarray, np.ndarray, np.random.Generator], Changed]


def kept(vertices: np.ndarray, faces: np.ndarray, home: np.ndarray | None = None) -> Changed:
    """A mesh that still has the vertices of the original: under the same numbers, or under those given."""
    home = np.arange(len(vertices)) if home is None else home
    return Changed(vertices, faces, home, np.zeros(len(home)))


def replaced(vertices: np.ndarray, faces: np.ndarray, old_vertices: np.ndarray, old_faces: np.ndarray) -> Changed:
    """A mesh with other vertices: those of the original go to the nearest in space that looks the same way.

    Without the direction, points would go through thin places, such as an ear, to the other side.
    """
    normals = [_normals(vertices, faces), _normals(old_vertices, old_faces)]
    weight = SAME_WAY * _mean_edge(vertices, faces)
    tree = cKDTree(np.hstack([vertices, weight * normals[0]]))
    home = tree.query(np.hstack([old_vertices, weight * normals[1]]))[1]
    return Changed(vertices, faces, home, np.linalg.norm(vertices[home] - old_vertices, axis=1))


def _normals(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Unit normals (n, 3) at the vertices; 0 where the faces around have no area."""
    sums = vertex_sums(faces, cross_products(vertices, faces), len(vertices))
    length = np.linalg.norm(sums, axis=1, keepdims=True)
    return np.divide(sums, length, out=np.zeros_like(sums), where=length > 0)


def _mean_edge(vertices: np.ndarray, faces: np.ndarray) -> float:
    ends = vertices[edge_table(faces).edges]
    return float(np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1).mean())


def decimated(vertices: np.ndarray, faces: np.ndarray, rng: np.random.Generator, share: float) -> Changed:
    """Edges drawn together by least quadric error until that share of the faces is left."""
    points, triangles, *_ = igl.qslim(*_for_igl(vertices, faces), round(share * len(faces)))
    return replaced(points, triangles, vertices, faces)


def refined(vertices: np.ndarray, faces: np.ndarray, rng: np.random.Generator) -> Changed:
    """Each triangle cut into four at the middles of its edges."""
    points, triangles = igl.upsample(vertices, faces, 1)
    return kept(points, triangles, np.arange(len(vertices)))


def remeshed(vertices: np.ndarray, faces: np.ndarray, rng: np.random.Generator) -> Changed:
    """As many faces, but others: refined, then the shortest edge drawn together again and again."""
    fine, more = igl.upsample(vertices, faces, 1)
    points, triangles, *_ = igl.decimate(*_for_igl(fine, more), len(faces))
    return replaced(points, triangles, vertices, faces)


def _for_igl(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Its decimation takes no other types."""
    return np.asfortranarray(vertices, np.float64), np.asfortranarray(faces, np.int32)


def noisy(vertices: np.ndarray, faces: np.ndarray, rng: np.random.Generator, amount: float) -> Changed:
    """Each coordinate moved by Gaussian noise whose standard deviation is that part of the mean edge length."""
    scale = amount * _mean_edge(vertices, faces)
    return kept(vertices + rng.normal(scale=scale, size=vertices.shape), faces)


def flipped(vertices: np.ndarray, faces: np.ndarray, rng: np.random.Generator, share: float) -> Changed:
    """That share of the inner edges, chosen at random, turned to the other diagonal of their two faces.

    A face takes part in one flip at most. No flip makes an edge that is there already, a fold or a needle; where
    that leaves too few, fewer are made.
    """
    table, out = edge_table(faces), faces.copy()
    inner = np.flatnonzero(table.counts == 2)
    known = set(map(tuple, table.edges.tolist()))
    touched: set[int] = set()
    left = round(share * len(inner))
    for edge in rng.permutation(inner):
        if not left:
            break
        one, two = table.edge_faces[edge].tolist()
        if one in touched or two in touched:
            continue
        k = table.face_edges[one].tolist().index(edge)
        c, a, b = np.roll(faces[one], -k).tolist()
        d = int(faces[two].sum()) - a - b
        old, new = np.array([(a, b, c), (b, a, d)]), np.array([(a, d, c), (d, b, c)])
        if (min(c, d), max(c, d)) in known or _spoils(vertices, old, new):
            continue
        out[[one, two]] = new
        known.add((min(c, d), max(c, d)))
        touched |= {one, two}
        left -= 1
    return kept(vertices, out)


def _spoils(vertices: np.ndarray, old: np.ndarray, new: np.ndarray) -> bool:
    """Whether two faces put in the place of two others are needles or look elsewhere."""
    corners = vertices[np.concatenate([old, new])]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    size = np.linalg.norm(normals, axis=1)
    longest = (np.linalg.norm(corners - corners[:, [1, 2, 0]], axis=2) ** 2).max(axis=1)
    if (size[2:] < FLATTEST * longest[2:]).any() or (size == 0).any():
        return True
    normals /= size[:, None]
    return bool((normals[:2] @ normals[2:].T < SHARPEST).any())


def rotated(vertices: np.ndarray, faces: np.ndarray, rng: np.random.Generator) -> Changed:
    """Turned about the origin at random."""
    q, r = np.linalg.qr(rng.normal(size=(3, 3)))
    q *= np.sign(np.diag(r))
    return kept(vertices @ (q * np.linalg.det(q)), faces)


def renumbered(vertices: np.ndarray, faces: np.ndarray, rng: np.random.Generator) -> Changed:
    """Vertices and faces in another order."""
    order = rng.permutation(len(vertices))
    new = np.argsort(order)
    return kept(vertices[order], rng.permutation(new[faces]), new)


def mirrored(vertices: np.ndarray, faces: np.ndarray, rng: np.random.Generator, turned: bool) -> Changed:
    """The mirror image, with the faces turned so that they still look outwards, or left as they are."""
    return kept(vertices * (-1, 1, 1), faces[:, ::-1] if turned else faces)


CHANGES: dict[str, Change] = {
    "unchanged": lambda vertices, faces, rng: kept(vertices, faces),
    "decimated to 50 % of the faces": partial(decimated, share=0.5),
    "decimated to 25 % of the faces": partial(decimated, share=0.25),
    "refined to 4 times the faces": refined,
    "remeshed": remeshed,
    "noise, 1 % of an edge": partial(noisy, amount=0.01),
    "noise, 10 % of an edge": partial(noisy, amount=0.1),
    "5 % of the edges flipped": partial(flipped, share=0.05),
    "rotated": rotated,
    "scaled by 1000": lambda vertices, faces, rng: kept(1000 * vertices, faces),
    "vertices renumbered": renumbered,
    "inside out": lambda vertices, faces, rng: kept(vertices, faces[:, ::-1]),
    "mirrored": partial(mirrored, turned=True),
    "mirrored, inside out": partial(mirrored, turned=False),
}
"""What is done to a target, by the name it has on the page."""


def cut(
    vertices: np.ndarray, faces: np.ndarray, normal: tuple[float, float, float], offset: float = 0.0
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The largest piece of a mesh on one side of a plane, of whole faces alone.

    Parameters
    ----------
    vertices, faces
        (n, 3) and (m, 3) of the whole mesh.
    normal
        Points to the side that is kept.
    offset
        Where the plane is along the normal: 0 is the mean of the vertices, 1 is one extent of the mesh further.

    Returns
    -------
    vertices, faces
        Of the piece.
    numbers : numpy.ndarray
        The number in the whole mesh of each vertex of the piece, ascending.
    """
    height = vertices @ np.array(normal)
    there = height - height.mean() >= offset * np.ptp(height)
    part = faces[there[faces].all(axis=1)]
    if not len(part):
        raise ValueError("no face lies on that side of the plane")
    _, label = components(part)
    piece = part[label == np.bincount(label, areas(vertices, part)).argmax()]
    numbers = used_vertices(piece)
    return vertices[numbers], np.searchsorted(numbers, piece), numbers


def cases(folder: Path) -> list[Case]:
    """The pairs of a set, or of the sets in a folder, that have lists of points with left and right exchanged too.

    Raises
    ------
    FormatError
        There are none, or a set is damaged.
    """
    if not folder.is_dir():
        raise FormatError(f"{folder}: no such folder. Give the one that holds the evaluation sets.")
    sets = [folder] if (folder / "corres").is_dir() else sorted(path for path in folder.iterdir() if path.is_dir())
    found = [case for path in sets for case in find_dataset(path).cases if case.truth.mirrored is not None]
    if not found:
        raise FormatError(f"{folder}: no pairs with corres/NAME.vts and corres/NAME.sym.vts in it or in its folders.")
    return found


def errors(case: Case, source: Mesh, target: Mesh, pairs: np.ndarray) -> dict[str, Any]:
    """``direct`` and, if there is such a list, ``mirrored`` errors (Q,) of matches; else None.

    Heat distances per diameter of the repaired target.
    """
    scorer = Scorer(case, source, target, "heat", cached_diameter(target, "heat"))
    found = scorer.score(pairs, np.ones(len(pairs)))
    return {name: found[name] for name in ("direct", "mirrored")}
