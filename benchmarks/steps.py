"""Make the pictures of docs/how-it-works.md from the person that ships with the package.

python benchmarks/steps.py [--folder docs/images]
"""

from __future__ import annotations

import argparse
import io
from dataclasses import replace
from pathlib import Path

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import LineCollection

import mobius_match as mm
from mobius_match._core.files import write_atomically
from mobius_match.alignments.candidates import Candidates
from mobius_match.alignments.coarse_map import refined_targets
from mobius_match.alignments.parameters import AlignmentParameters
from mobius_match.evaluation import examples
from mobius_match.exporting.figures import draw_matches
from mobius_match.exporting.scene import colours_of
from mobius_match.geometry.laplacian import intrinsic_mesh
from mobius_match.surface.flattening import choose_cut_face, flatten, vertex_positions
from mobius_match.transfer.transfer import Transfer
from mobius_match.voting.assignment import max_row_column, normalized
from mobius_match.voting.mobius import CANONICAL_TRIANGLE, apply, from_three_points

GREY = "0.82"
SQUARE = np.array([-1, 1])


def front(axes, vertices, faces=None, **how):
    """A surface in grey from the front, or points."""
    if faces is not None:
        axes.triplot(vertices[:, 0], vertices[:, 1], faces, color=GREY, linewidth=0.2)
    else:
        axes.scatter(vertices[:, 0], vertices[:, 1], **how)
    axes.set_aspect("equal")
    axes.axis("off")


def samples(result):
    """Section 4."""
    figure, rows = plt.subplots(1, 2, figsize=(8, 4.6), layout="constrained")
    for axes, surface in zip(rows, (result.source, result.target), strict=True):
        front(axes, surface.mesh.vertices, surface.mesh.faces)
        places, n = surface.mesh.vertices[surface.samples], surface.n_maxima
        front(axes, places[:n], s=26, c="tab:red", label=f"{n} maxima of curvature")
        front(axes, places[n:], s=26, c="tab:blue", label=f"{len(places) - n} farthest points")
        axes.legend(loc="lower center", bbox_to_anchor=(0.5, -0.14), frameon=False)
    return figure


def planes(result):
    """Sections 5 and 6: a flattened surface, and both after the Möbius maps of one triplet."""
    transfer = Transfer(result.dense())
    colours = colours_of(transfer.source.vertices)
    carried = transfer.values(colours)
    triplets = result.votes.best_source[0], result.votes.best_target[0]
    figure, row = plt.subplots(1, 3, figsize=(11, 4), layout="constrained")
    for k, (surface, paint) in enumerate(((result.source, colours), (result.target, carried))):
        flat, samples, middle = flattened(surface, paint)
        canonical = from_three_points(samples[triplets[k]], CANONICAL_TRIANGLE)
        if k == 0:
            plane(row[0], flat, middle, samples)
            centre = np.median(flat.real) + 1j * np.median(flat.imag)
            extent = 12 * np.median(np.abs(flat)) * SQUARE
            row[0].set(title="source, flattened", xlim=centre.real + extent, ylim=centre.imag + extent)
        plane(row[k + 1], apply(canonical, flat), middle, apply(canonical, samples))
        row[k + 1].plot(*np.stack([CANONICAL_TRIANGLE.real, CANONICAL_TRIANGLE.imag]), "k^", markersize=9)
        row[k + 1].set(title=f"{('source', 'target')[k]}, a triplet moved to ▲", xlim=3 * SQUARE, ylim=3 * SQUARE)
    return figure


def flattened(surface, paint):
    """Where the mid-edges (E,) and the samples lie in the plane, and the colours of the mid-edges."""
    mesh = surface.mesh
    scale = np.ptp(mesh.vertices, axis=0).max()
    triangulation = intrinsic_mesh((mesh.vertices - mesh.vertices.mean(axis=0)) / scale, mesh.faces, delaunay=True)
    average = np.linalg.norm(mesh.vertices - mesh.vertices[surface.cut_vertex], axis=1)
    flat = flatten(triangulation, choose_cut_face(triangulation, average))
    ends = np.empty((triangulation.n_edges, 2), np.int64)
    ends[triangulation.face_edges] = np.stack(
        [triangulation.faces[:, [1, 2, 0]], triangulation.faces[:, [2, 0, 1]]], axis=-1
    )
    known = np.isfinite(flat.positions)
    samples = vertex_positions(flat, triangulation, surface.samples)
    return flat.positions[known], samples, np.nanmean(paint[ends], axis=1).clip(0, 1)[known]


def plane(axes, points, colours, samples):
    axes.scatter(points.real, points.imag, s=2, c=colours, linewidths=0)
    axes.scatter(samples.real, samples.imag, s=14, c="none", edgecolors="k", linewidths=0.6)
    axes.set_aspect("equal")
    axes.set(xticks=[], yticks=[])


def matrices(result):
    """Section 8: the matrix C, its rows and columns in the order of the matches, and what is read off it."""
    matrix = normalized(result.votes.matrix)
    pairs, values = max_row_column(matrix)
    order = np.argsort(result.source.average_distances[pairs[:, 0]], kind="stable")
    rows, columns = pairs[order].T
    figure, row = plt.subplots(1, 2, figsize=(10, 4.5), layout="constrained")
    scale = mpl.colors.LogNorm(1e-3, 1, clip=True)
    chosen = np.zeros_like(matrix)
    chosen[pairs[:, 0], pairs[:, 1]] = values
    for axes, shown, title in zip(row, (matrix, chosen), ("C: votes", "after max-row-column"), strict=True):
        picture = axes.imshow(shown[np.ix_(rows, columns)], norm=scale, cmap="magma_r", interpolation="nearest")
        axes.set(title=title, xlabel="samples of the target", ylabel="samples of the source", xticks=[], yticks=[])
    figure.colorbar(picture, ax=row, label="votes / largest")
    return figure


def alternatives(result):
    """Two alignments of one pair."""
    second = result.alternatives[0]
    other = replace(
        result, pairs=second.pairs, confidence=second.confidence, kind=second.kind, target_points=second.target_points
    )
    figure, row = plt.subplots(1, 2, figsize=(12, 4.2), layout="constrained")
    titles = (
        f"chosen, probability {result.probability:.2f}",
        f"runner-up, probability {second.probability:.2f}: chest and arms swapped",
    )
    for axes, one, title in zip(row, (result, other), titles, strict=True):
        stream = io.BytesIO()
        draw_matches(one, stream, size=(1000, 640), view=(0, 8))
        axes.imshow(plt.imread(io.BytesIO(stream.getvalue())))
        axes.set_title(title)
        axes.axis("off")
    return figure


def registered(result):
    """The source's proxy: where it is, where the alignment's map sends it, and registered to the target."""
    source, target, parameters = result.source, result.target, AlignmentParameters()
    chosen = Candidates(source, target, parameters).voted(result.votes)[0]
    colours = colours_of(source.mesh.vertices[source.proxy])
    sent = target.mesh.vertices[refined_targets(source, target, chosen.image, source.proxy, parameters.coarse_map)]
    positions = chosen.registered(source, target, parameters).positions
    figure, row = plt.subplots(1, 3, figsize=(11, 4.6), layout="constrained")
    shown = (source.mesh.vertices[source.proxy], sent, positions)
    titles = ("the source, 1,200 points", "where the alignment sends them", "registered to the target")
    for axes, mesh, points, title in zip(row, (source, target, target), shown, titles, strict=True):
        joined = source.proxy_edges
        front(axes, mesh.mesh.vertices, mesh.mesh.faces)
        lines = LineCollection(points[joined][:, :, :2], colors=colours[joined[:, 0]], linewidths=0.7)
        axes.add_collection(lines)
        front(axes, points, s=5, c=colours)
        axes.set_title(title)
    return figure


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--folder", type=Path, default=Path("docs/images"))
    folder = parser.parse_args().folder
    result = mm.match(*examples.paths("person"), seed=0)
    for draw in (samples, planes, matrices, alternatives, registered):
        stream = io.BytesIO()
        draw(result).savefig(stream, dpi=110)
        path = folder / f"step-{draw.__name__}.png"
        write_atomically(path, stream.getvalue())
        print(path)


if __name__ == "__main__":
    main()
