"""
A dense map, and transfer along it
==================================

A few hundred matches become a map of all vertices in both directions, along which colours, labels and textures are
transferred.
"""

import matplotlib.pyplot as plt
import numpy as np

import mobius_match as mm

dense = mm.match(*mm.examples.paths("person"), seed=0).dense()
print(mm.quality(dense))

# %%
# Position on the source as colour, transferred to the target:

transfer = mm.Transfer(dense)
source, target = transfer.source, transfer.target
low, high = source.vertices.min(axis=0), source.vertices.max(axis=0)
colours = np.round(255 * (0.15 + 0.8 * (source.vertices - low) / (high - low))).astype(np.uint8)
carried = transfer.colors(colours)


def drawn(mesh, paint):
    return next(
        mm.draw_shapes(
            mesh.vertices[None],
            mesh.faces,
            size=(500, 620),
            paint=paint.astype(np.float32),
        )
    )


plt.imsave(
    "colours.png",
    np.concatenate([drawn(source, colours / 255), drawn(target, carried / 255)], axis=1),
)

# %%
# What the map does to areas, measured without ground truth: blue where they shrink, red where they grow, white where
# they stay the same. The change is largest at joints that bend.

growth = np.nan_to_num(mm.quality(dense).area)
paint = plt.get_cmap("RdBu_r")(0.5 + growth / 2)[:, :3]
plt.imsave("areas.png", drawn(dense.source, paint))
