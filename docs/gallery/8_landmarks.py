"""
Landmarks from one shape to the other
=====================================

Named points that were placed on one shape are transferred to the other.
"""

import matplotlib.pyplot as plt
import numpy as np

import mobius_match as mm

transfer = mm.Transfer(mm.match(*mm.examples.paths("person"), seed=0).dense())
source, target = transfer.source, transfer.target

# %%
# Three positions on the source are moved to the closest point of the surface, then transferred. The result is exact
# positions on the target, and the vertices nearest to them.

height = source.vertices[:, 1]
placed = {
    "top of the head": source.vertices[height.argmax()],
    "right hand": source.vertices[source.vertices[:, 0].argmin()],
    "left hand": source.vertices[source.vertices[:, 0].argmax()],
}
points, distances = transfer.project(np.array(list(placed.values())))
places, vertices = transfer.points(points)
for name, place, vertex in zip(placed, places, vertices, strict=True):
    print(f"{name}: vertex {vertex} at {np.round(place, 3)}")

# %%
# On both shapes, what lies within 8 cm of a landmark is painted:


def drawn(mesh, landmarks):
    near = np.linalg.norm(mesh.vertices[:, None] - landmarks, axis=2) < 0.08
    paint = np.full((len(mesh.vertices), 3), 0.8, np.float32)
    for k in range(len(landmarks)):
        paint[near[:, k]] = plt.get_cmap("tab10")(k)[:3]
    return next(mm.draw_shapes(mesh.vertices[None], mesh.faces, size=(500, 620), paint=paint))


plt.imsave(
    "landmarks.png",
    np.concatenate([drawn(source, list(placed.values())), drawn(target, places)], axis=1),
)

# %%
# Known pairs guide a match: they decide which alignment is right, and are part of the result.

head = int(height.argmax())
guided = mm.match(*mm.examples.paths("person"), seed=0, landmarks=[(head, int(vertices[0]))])
print(f"{len(guided)} matches, {guided.given.sum()} of them given: {guided.pairs[0]}")
