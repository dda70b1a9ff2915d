"""Make docs/images/transfer.png and docs/images/morph.png from the shapes that ship with the package.

python benchmarks/pictures.py [--folder docs/images]
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

import mobius_match as mm
from mobius_match.evaluation import examples
from mobius_match.exporting.figures import draw_shapes, png
from mobius_match.mesh.topology import edges_of
from mobius_match.transfer.morph import morph
from mobius_match.transfer.transfer import Transfer

SIZE = 420


def texture(size=512):
    """Coloured squares with darker lines between them; continues from its right side to its left."""
    x, y = np.meshgrid(np.arange(size) / size, np.arange(size) / size)
    checks = (np.floor(x * 16) + np.floor(y * 24)) % 2
    hue = 2 * np.pi * (x[..., None] + [0, 1 / 3, 2 / 3])
    picture = (0.62 + 0.3 * np.cos(hue)) * (0.55 + 0.45 * checks[..., None])
    return np.clip(picture + 0.15 * (y[..., None] - 0.5), 0, 1)


def around(vertices, faces):
    """Texture coordinates (m, 3, 2) of a cylinder around the upright axis, torn along a line at the back."""
    x, y, z = (vertices - (vertices.min(axis=0) + vertices.max(axis=0)) / 2).T
    u = (np.arctan2(x, z) / (2 * np.pi) + 0.5)[faces]
    torn = np.ptp(u, axis=1) > 0.5
    u[torn] += u[torn] < 0.5
    return np.stack([u, ((y - y.min()) / np.ptp(y))[faces]], axis=2)


def finer(vertices, faces, uv):
    """Each face cut in four, with its texture coordinates."""
    edges = edges_of(faces)
    size = len(vertices)
    keys = edges @ [size, 1]
    sides = np.sort(np.stack([faces, np.roll(faces, -1, axis=1)], axis=2), axis=2)
    middle = size + np.searchsorted(keys, sides @ [size, 1])
    between = (uv + np.roll(uv, -1, axis=1)) / 2
    corners, places = [], []
    for k in range(3):
        corners.append(np.stack([faces[:, k], middle[:, k], middle[:, k - 1]], axis=1))
        places.append(np.stack([uv[:, k], between[:, k], between[:, k - 1]], axis=1))
    vertices = np.concatenate([vertices, vertices[edges].mean(axis=1)])
    return vertices, np.concatenate([*corners, middle]), np.concatenate([*places, between])


def textured(vertices, faces, uv, picture):
    """A surface drawn with its texture."""
    for _ in range(2):
        vertices, faces, uv = finer(vertices, faces, uv)
    size = len(picture)
    columns = np.floor(uv[..., 0] % 1 * size).astype(int).clip(0, size - 1)
    rows = np.floor(uv[..., 1] * size).astype(int).clip(0, size - 1)
    paint = np.empty((len(vertices), 3))
    paint[faces] = picture[rows, columns]
    return painted(vertices, faces, paint)


def painted(vertices, faces, paint):
    return next(draw_shapes(vertices[None], faces, size=(SIZE, SIZE), paint=paint.astype(np.float32)))


def labelled(vertices, faces, labels):
    """A surface drawn with a colour for each label: every face has corners of its own, its normals are kept."""
    colours = 0.6 + 0.32 * np.cos(2.4 * np.arange(labels.max() + 1)[:, None] + [0, 2.1, 4.2])
    uv = np.zeros((len(faces), 3, 2))
    uv[..., 0] = labels[:, None]
    for _ in range(2):
        vertices, faces, uv = finer(vertices, faces, uv)
    paint = np.empty((len(vertices), 3))
    paint[faces] = colours[uv[..., 0].astype(int)]
    return painted(vertices, faces, paint)


def transfer_picture(person, quadruped):
    carrier = Transfer(person)
    source, target = carrier.source, carrier.target
    labels = nearest_of_spread(source.vertices[source.faces].mean(axis=1), 14)
    panels = [labelled(mesh.vertices, mesh.faces, part) for mesh, part in
              ((source, labels), (target, carrier.labels(labels)))]  # fmt: skip
    picture, uv = texture(), around(source.vertices, source.faces)
    panels += [textured(mesh.vertices, mesh.faces, part, picture) for mesh, part in
               ((source, uv), (target, np.nan_to_num(carrier.uv(uv))))]  # fmt: skip
    carrier = Transfer(quadruped)
    source, target = carrier.source, carrier.target
    low, high = source.vertices.min(axis=0), source.vertices.max(axis=0)
    colors = np.round(255 * (0.15 + 0.8 * (source.vertices - low) / (high - low))).astype(np.uint8)
    panels += [painted(mesh.vertices, mesh.faces, part / 255) for mesh, part in
               ((source, colors), (target, carrier.colors(colors)))]  # fmt: skip
    return np.concatenate([panel[:, _filled(panel.swapaxes(0, 1))] for panel in panels], axis=1)


def nearest_of_spread(places, number):
    """For each place the nearest of some that are spread evenly."""
    chosen, apart = [0], np.full(len(places), np.inf)
    label = np.zeros(len(places), int)
    for k in range(number):
        to = np.linalg.norm(places - places[chosen[-1]], axis=1)
        label[to < apart] = k
        apart = np.minimum(apart, to)
        chosen.append(int(apart.argmax()))
    return label


def morph_picture(person, quadruped):
    rows = []
    for surface_map in (person, quadruped):
        shapes = morph(surface_map, np.linspace(0, 1, 6))
        rows.append(np.concatenate(list(draw_shapes(shapes, surface_map.source.faces, size=(SIZE, SIZE))), axis=1))
    return np.concatenate([row[_filled(row)] for row in rows], axis=0)


def _filled(row):
    """The rows of a picture that are not white, and some more."""
    used = np.flatnonzero((row < 0.99).any(axis=(1, 2)))
    return slice(max(used[0] - 12, 0), used[-1] + 12)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--folder", type=Path, default=Path("docs/images"))
    folder = parser.parse_args().folder
    maps = [mm.match(*examples.paths(name), seed=0).dense() for name in ("person", "quadruped")]
    for name, draw in (("transfer", transfer_picture), ("morph", morph_picture)):
        picture = draw(*maps)
        (folder / f"{name}.png").write_bytes(png(picture[_filled(picture)]))
        print(f"{folder / name}.png")


if __name__ == "__main__":
    main()
