"""
How alike shapes are
====================

The mean change of geodesic distances under the map of two shapes is a distance between them that poses hardly change.
"""

from itertools import combinations

import matplotlib.pyplot as plt
import numpy as np

import mobius_match as mm
from mobius_match import examples

# %%
# The animal in two poses, and each pose again with everything before its shoulders drawn out: another animal.

meshes = [mm.read_mesh(path) for path in examples.paths("quadruped")]
longer = []
for mesh in meshes:
    before = np.clip(mesh.vertices[:, 2:] - 0.25, 0, None)
    longer.append((mesh.vertices + [0, 0.5, 1.0] * before, mesh.faces))
names = ["standing", "walking", "long neck, standing", "long neck, walking"]
surfaces = [mm.prepare(mesh) for mesh in (*meshes, *longer)]

distances = np.zeros((4, 4))
for i, j in combinations(range(4), 2):
    dense = mm.match(surfaces[i], surfaces[j], seed=0).dense()
    distances[i, j] = distances[j, i] = mm.isometric_distance(dense)

figure, axes = plt.subplots(figsize=(6, 4.6), layout="constrained")
picture = axes.imshow(distances, cmap="viridis_r")
axes.set_xticks(range(4), names, rotation=25, ha="right")
axes.set_yticks(range(4), names)
for (i, j), value in np.ndenumerate(distances):
    axes.text(
        j,
        i,
        f"{value:.3f}",
        ha="center",
        va="center",
        color="white" if value > distances.max() / 2 else "black",
    )
figure.colorbar(picture, label="mean change of distances, per sqrt(area)")
plt.show()

# %%
# Two poses of one animal are closer than two animals. Between shapes of different kinds, such as a person and an
# animal, distances are larger still: :doc:`/dense`.
