"""
One shape against many
======================

Preparing a mesh is the costly part, and does not depend on what it is matched with. Over a collection every mesh is
prepared once; the files of ``Surface.save`` and ``mobius prepare`` keep it for another day.
"""

import time

import matplotlib.pyplot as plt
import numpy as np

import mobius_match as mm
from mobius_match.evaluation import examples
from mobius_match.exporting.figures import draw_shapes
from mobius_match.transfer.morph import morph

# %%
# A small collection: four poses between the two of the person. They have the reference's triangles, so that the truth
# is known, but the program makes no use of that.

first = mm.match(*examples.paths("person"), seed=0)
faces = first.source.whole_mesh.faces
poses = morph(first.dense(), [0.25, 0.5, 0.75, 1.0])
frames = list(draw_shapes(poses, faces, size=(340, 420)))
plt.imsave("poses.png", np.concatenate(frames, axis=1))

# %%
# Prepared once each, then matched with the reference:

reference = mm.prepare(examples.paths("person")[0])
start = time.perf_counter()
surfaces = [mm.prepare((vertices, faces)) for vertices in poses]
prepared = time.perf_counter()
results = [mm.match(reference, surface, seed=0) for surface in surfaces]
matched = time.perf_counter()
print(f"to prepare a mesh: {(prepared - start) / 4:.2f} s")
print(f"then to match it: {(matched - prepared) / 4:.2f} s")

# %%
# How far from the truth the matches are, per diameter:

for vertices, surface, result in zip(poses, surfaces, results, strict=True):
    places = result.target_points.values(vertices)
    errors = np.linalg.norm(places - vertices[result.pairs[:, 0]], axis=1) / surface.diameter
    print(f"{len(result)} matches: median {np.median(errors):.4f}, largest {errors.max():.4f}")
