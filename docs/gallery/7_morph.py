"""
One shape becomes the other
===========================

Along a dense map the source turns into the target, without shrinking where limbs turn.
"""

import matplotlib.pyplot as plt
import numpy as np

import mobius_match as mm
from mobius_match.evaluation import examples
from mobius_match.exporting.figures import draw_shapes
from mobius_match.transfer.animation import animated_glb
from mobius_match.transfer.morph import morph

dense = mm.match(*examples.paths("quadruped"), seed=0).dense()
shapes = morph(dense, np.linspace(0, 1, 5))
frames = list(draw_shapes(shapes, dense.source.faces, size=(360, 260)))
plt.imsave("morph.png", np.concatenate(frames, axis=1))

# %%
# As an animation that any viewer of glTF plays:

content = animated_glb(shapes, dense.source.faces, seconds=2.0)
print(f"{len(content):,} bytes; write them to a file whose name ends in .glb")
