"""
One shape against many
======================

Preparing a mesh is the costly part, and does not depend on what it is matched with. So each mesh of a collection is
prepared once; ``Surface.save`` and ``mobius prepare`` store it in a file.
"""

import time

import matplotlib.pyplot as plt
import numpy as np

import mobius_match as mm

# %%
# A small collection: four poses between the two of the person. They share the reference's triangles, so that the truth
# is known; the program makes no use of that.

first = mm.match(*mm.examples.paths("person"), seed=0)
faces = first.source.whole_mesh.faces
poses = mm.morph(first.dense(), [0.25, 0.5, 0.75, 1.0])
frames = list(mm.draw_shapes(poses, faces, size=(340, 420)))
plt.imsave("poses.png", np.concatenate(frames, axis=1))

# %%
# Each is prepared once, then matched with the reference:

reference = mm.prepare(mm.examples.paths("person")[0])
start = time.perf_counter()
surfaces = [mm.prepare((vertices, faces)) for vertices in poses]
prepared = time.perf_counter()
results = [mm.match(reference, surface, seed=0) for surface in surfaces]
matched = time.perf_counter()
print(f"to prepare a mesh: {(prepared - start) / 4:.2f} s")
print(f"then to match it: {(matched - prepared) / 4:.2f} s")

# %%
# Errors of the matches, as fractions of the diameter:

for vertices, surface, result in zip(poses, surfaces, results, strict=True):
    places = result.target_points.values(vertices)
    errors = np.linalg.norm(places - vertices[result.pairs[:, 0]], axis=1) / surface.diameter
    print(f"{len(result)} matches: median {np.median(errors):.4f}, largest {errors.max():.4f}")
