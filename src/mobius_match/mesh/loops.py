"""Kernels that find short loops around the handles of a surface, by tree and cotree (Erickson and Whittlesey 2005).

From a root, the shortest paths to all vertices are a tree. The triangles, joined across edges that are not in the tree,
have a spanning tree as well, the cotree; it takes the edges that would make the longest loops first. Each edge that is
in neither closes a loop with the tree, and the loop separates nothing, since the cotree joins all triangles without
crossing it. On a closed surface of genus g there are 2 g of them, the shortest ones through the root.
"""

from __future__ import annotations

import numpy as np

from .._core.compiling import inlined, jit
from .links import join, root_of


@inlined
def _push(keys: np.ndarray, nodes: np.ndarray, size: int, key: float, node: int) -> None:
    """Add an entry to a binary heap of so many entries."""
    at = size
    while at > 0 and keys[(at - 1) // 2] > key:
        keys[at], nodes[at] = keys[(at - 1) // 2], nodes[(at - 1) // 2]
        at = (at - 1) // 2
    keys[at], nodes[at] = key, node


@inlined
def _drop_first(keys: np.ndarray, nodes: np.ndarray, size: int) -> None:
    """Remove the least entry from a binary heap that has so many entries afterwards."""
    key, node, at = keys[size], nodes[size], 0
    while 2 * at + 1 < size:
        child = 2 * at + 1
        if child + 1 < size and keys[child + 1] < keys[child]:
            child += 1
        if keys[child] >= key:
            break
        keys[at], nodes[at] = keys[child], nodes[child]
        at = child
    keys[at], nodes[at] = key, node


@jit
def shortest_tree(
    root: int,
    limit: float,
    start: np.ndarray,
    half_edges: np.ndarray,
    edges: np.ndarray,
    lengths: np.ndarray,
    blocked: np.ndarray,
    distance: np.ndarray,
    parent: np.ndarray,
) -> None:
    """Write the distance of each vertex along edges from a root, and the edge that leads back; by Dijkstra.

    Vertices that are blocked or farther than the limit get an infinite distance. The edges at vertex v are
    ``half_edges[start[v] : start[v + 1]]``.
    """
    distance[:] = np.inf
    parent[:] = -1
    keys, nodes = np.empty(len(half_edges) + 1), np.empty(len(half_edges) + 1, np.int64)
    distance[root] = 0.0
    keys[0], nodes[0], size = 0.0, root, 1
    while size > 0:
        key, at = keys[0], nodes[0]
        size -= 1
        _drop_first(keys, nodes, size)
        if key > distance[at]:
            continue
        for place in range(start[at], start[at + 1]):
            edge = half_edges[place]
            other = edges[edge, 0] + edges[edge, 1] - at
            far = key + lengths[edge]
            if far < distance[other] and far <= limit and not blocked[other]:
                distance[other] = far
                parent[other] = edge
                _push(keys, nodes, size, far, other)
                size += 1


@jit
def closing_edges(
    limit: float,
    edges: np.ndarray,
    lengths: np.ndarray,
    sides: np.ndarray,
    n_sides: int,
    cut: np.ndarray,
    distance: np.ndarray,
    parent: np.ndarray,
) -> np.ndarray:
    """The edges in neither tree nor cotree whose loops through the root are not longer than the limit.

    ``sides`` (E, 2) are the triangles on both sides of each edge; a boundary loop counts as one more triangle. Edges
    that are ``cut`` are not crossed.
    """
    labels = np.arange(n_sides)
    number = 0
    near, loop = np.empty(len(edges), np.int64), np.empty(len(edges))
    for edge in range(len(edges)):
        u, v = edges[edge, 0], edges[edge, 1]
        if cut[edge] or parent[u] == edge or parent[v] == edge:
            continue
        length = distance[u] + distance[v] + lengths[edge]
        if length <= limit:
            near[number], loop[number] = edge, -length
            number += 1
        else:  # the longest come first
            join(labels, sides[edge, 0], sides[edge, 1])
    order = np.argsort(loop[:number], kind="mergesort")
    found = np.empty(number, np.int64)
    count = 0
    for k in range(number):
        edge = near[order[k]]
        if root_of(labels, sides[edge, 0]) == root_of(labels, sides[edge, 1]):
            found[count] = edge
            count += 1
        else:
            join(labels, sides[edge, 0], sides[edge, 1])
    return found[:count]


@jit
def _path_to_root(vertex: int, edges: np.ndarray, parent: np.ndarray) -> np.ndarray:
    """The vertices from one to the root of the tree, both included."""
    at, number = vertex, 1
    while parent[at] >= 0:
        at = edges[parent[at], 0] + edges[parent[at], 1] - at
        number += 1
    path = np.empty(number, np.int64)
    path[0] = vertex
    for k in range(1, number):
        path[k] = edges[parent[path[k - 1]], 0] + edges[parent[path[k - 1]], 1] - path[k - 1]
    return path


@jit
def loop_of(edge: int, edges: np.ndarray, distance: np.ndarray, parent: np.ndarray) -> np.ndarray:
    """The vertices of the loop that an edge closes with the tree, without what is common to both paths."""
    one, two = _path_to_root(edges[edge, 0], edges, parent), _path_to_root(edges[edge, 1], edges, parent)
    i, j = len(one), len(two)
    while i > 1 and j > 1 and one[i - 2] == two[j - 2]:  # both end at the root
        i, j = i - 1, j - 1
    return np.concatenate((one[:i], two[: j - 1][::-1]))
