"""Shapes with known topology, as (vertices, faces)."""

from types import SimpleNamespace

import numpy as np
import pytest
import trimesh


def sphere(level=2):
    ball = trimesh.creation.icosphere(level)
    return np.array(ball.vertices), np.array(ball.faces)


def grid(nu, nv, wrap_u=False, wrap_v=False, twist=False):
    """Faces of nu x nv quads cut in two, the ends of u (and v) joined where asked, u with a half turn."""
    rows, columns = (nu if wrap_u else nu + 1), (nv if wrap_v else nv + 1)

    def at(i, j):
        if wrap_u and i == nu:
            i, j = 0, (nv - j if twist else j)
        return i * columns + (j % nv if wrap_v else j)

    faces = []
    for i in range(nu):
        for j in range(nv):
            a, b, c, d = at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)
            faces += [[a, b, c], [a, c, d]]
    i, j = np.divmod(np.arange(rows * columns), columns)
    return i / nu, j / nv, np.array(faces)


def disc():
    u, v, faces = grid(6, 6)
    return np.stack([u, v, 0.1 * u * v], axis=1), faces


def cylinder():
    u, v, faces = grid(10, 4, wrap_u=True)
    return np.stack([np.cos(2 * np.pi * u), np.sin(2 * np.pi * u), v], axis=1), faces


def torus(shift=0.0):
    u, v, faces = grid(10, 8, wrap_u=True, wrap_v=True)
    r = 2 + np.cos(2 * np.pi * v)
    return np.stack(
        [r * np.cos(2 * np.pi * u) + shift, r * np.sin(2 * np.pi * u), np.sin(2 * np.pi * v)], 1
    ), faces


def moebius():
    u, v, faces = grid(20, 3, wrap_u=True, twist=True)
    r = 1 + (v - 0.5) * np.cos(np.pi * u)
    return np.stack(
        [r * np.cos(2 * np.pi * u), r * np.sin(2 * np.pi * u), (v - 0.5) * np.sin(np.pi * u)], 1
    ), faces


def holed_sphere(holes=2):
    """An icosphere without the faces around its first, mutually distant, vertices."""
    vertices, faces = sphere(2)
    return vertices, faces[~np.isin(faces, np.arange(holes)).any(axis=1)]


def union(*parts):
    """Several (vertices, faces) in one, numbered on."""
    start = np.cumsum([0] + [len(v) for v, _ in parts])
    return np.concatenate([v for v, _ in parts]), np.concatenate(
        [f + s for (_, f), s in zip(parts, start, strict=False)]
    )


def bowtie():
    """Two discs that share one vertex: number 0 of both."""
    v, f = disc()
    vertices, faces = union((v, f), (-v, f))
    faces = np.where(faces == len(v), 0, faces)
    return vertices, faces


def book(pages=3):
    """Square sheets that share one edge of 6 segments."""
    u, v, faces = grid(6, 6)
    sheets, spine = [], np.flatnonzero(v == 0)
    for k in range(pages):
        angle = 2 * np.pi * k / pages
        sheets.append((np.stack([v * np.cos(angle), v * np.sin(angle), u], axis=1), faces))
    vertices, faces = union(*sheets)
    number = np.arange(len(vertices))
    for k in range(1, pages):
        number[spine + k * len(u)] = spine
    return vertices, number[faces]


@pytest.fixture(scope="session")
def shapes():
    return SimpleNamespace(
        sphere=sphere, grid=grid, disc=disc, cylinder=cylinder, torus=torus, moebius=moebius,
        holed_sphere=holed_sphere, union=union, bowtie=bowtie, book=book,
    )  # fmt: skip
