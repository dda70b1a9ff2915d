"""
Left and right of one shape
===========================

Which half mirrors the other, in whatever pose.
"""

import matplotlib.pyplot as plt
import numpy as np

import mobius_match as mm
from mobius_match.evaluation import examples
from mobius_match.exporting.figures import draw_shapes

found = mm.symmetry(examples.paths("person")[1], seed=0)
print(found)
print(found.pairs[:5])

# %%
# The two vertices of a pair get one colour, and so does what is nearest to each; in white the vertices in the middle.

mesh = found.source.whole_mesh
ends = mesh.vertices[found.pairs.ravel()]
nearest = np.linalg.norm(mesh.vertices[:, None] - ends, axis=2).argmin(axis=1) // 2
hues = 0.38 * np.arange(len(found)) % 1
paint = 0.3 + 0.65 * plt.get_cmap("hsv")(hues)[nearest, :3].astype(np.float32)
paint[found.stationary] = 1
picture = next(draw_shapes(mesh.vertices[None], mesh.faces, paint=paint))
plt.imsave("symmetry.png", picture)
