"""
One shape becomes the other
===========================

Along a dense map the source becomes the target, without shrinking where limbs rotate.
"""

import matplotlib.pyplot as plt
import numpy as np

import mobius_match as mm

dense = mm.match(*mm.examples.paths("quadruped"), seed=0).dense()
shapes = mm.morph(dense, np.linspace(0, 1, 5))
frames = list(mm.draw_shapes(shapes, dense.source.faces, size=(360, 260)))
plt.imsave("morph.png", np.concatenate(frames, axis=1))

# %%
# As an animation for any viewer of glTF:

content = mm.animated_glb(shapes, dense.source.faces, seconds=2.0)
print(f"{len(content):,} bytes; write them to a file whose name ends in .glb")
