"""
Left and right of one shape
===========================

Which half of a shape mirrors the other, in any pose.
"""

import matplotlib.pyplot as plt
import numpy as np

import mobius_match as mm

found = mm.symmetry(mm.examples.paths("person")[1], seed=0)
print(found)
print(found.pairs[:5])

# %%
# The two vertices of a pair have the same colour, and so have the vertices nearest to each. Vertices in the middle are
# white.

mesh = found.source.whole_mesh
ends = mesh.vertices[found.pairs.ravel()]
nearest = np.linalg.norm(mesh.vertices[:, None] - ends, axis=2).argmin(axis=1) // 2
hues = 0.38 * np.arange(len(found)) % 1
paint = 0.3 + 0.65 * plt.get_cmap("hsv")(hues)[nearest, :3].astype(np.float32)
paint[found.stationary] = 1
picture = next(mm.draw_shapes(mesh.vertices[None], mesh.faces, paint=paint))
plt.imsave("symmetry.png", picture)
