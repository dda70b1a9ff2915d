"""
How similar shapes are
======================

The mean change of geodesic distances under the map between two shapes is a distance between them. It hardly depends on
the pose.
"""

from itertools import combinations

import matplotlib.pyplot as plt
import numpy as np

import mobius_match as mm

# %%
# The animal in two poses, and the second again with a longer neck: another animal.

meshes = [mm.read_mesh(path) for path in mm.examples.paths("quadruped")]
walking = meshes[1]
before = np.clip(walking.vertices[:, 2:] - 0.25, 0, None)  # it looks along z
longer = (walking.vertices + [0, 0.5, 1.0] * before, walking.faces)
names = ["standing", "walking", "walking,\nlong neck"]
surfaces = [mm.prepare(mesh) for mesh in (*meshes, longer)]

distances = np.zeros((3, 3))
for i, j in combinations(range(3), 2):
    dense = mm.match(surfaces[i], surfaces[j], seed=0).dense()
    distances[i, j] = distances[j, i] = mm.isometric_distance(dense)

figure, axes = plt.subplots(figsize=(5.6, 4.2), layout="constrained")
picture = axes.imshow(distances, cmap="cividis_r")
axes.set_xticks(range(3), names)
axes.set_yticks(range(3), names)
for (i, j), value in np.ndenumerate(distances):
    colour = "white" if value > distances.max() / 2 else "black"
    axes.text(j, i, f"{value:.3f}", ha="center", va="center", color=colour)
figure.colorbar(picture, label="mean change of distances / sqrt(area)")
plt.show()

# %%
# Two poses of one animal are closer to each other than two animals. Between shapes of different kinds, such as a person
# and an animal, distances are larger still: :doc:`/dense`.
