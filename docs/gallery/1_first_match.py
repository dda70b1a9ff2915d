"""
A first match
=============

Two poses of an animal, each meshed on its own: which vertex of one is which vertex of the other?
"""

import numpy as np

import mobius_match as mm
from mobius_match.evaluation import examples
from mobius_match.exporting.figures import draw_matches

source, target = examples.paths("quadruped")
result = mm.match(source, target, seed=0)
for k in range(5):
    i, j = result.pairs[k]
    print(f"vertex {i} is vertex {j}, confidence {result.confidence[k]:.3f} ({result.kind[k]})")

# %%
# A sphere of one colour on both sides is one match; the larger, the more certain. The picture shows the matches that
# can be seen from one side; :doc:`/viewer` shows them all.

draw_matches(result, "matches.png", size=(1600, 640))

# %%
# The true places are known here. Each match names a point inside a face of the target, finer than its vertices:

faces, barycentric = examples.truth("quadruped")
mesh = mm.read_mesh(target)
true = np.einsum("qc,qcx->qx", barycentric, mesh.vertices[mesh.faces[faces]])
found = result.target_points.values(mesh.vertices)
errors = np.linalg.norm(found - true[result.pairs[:, 0]], axis=1) / result.target_info["diameter"]
print(f"{(errors < 0.05).mean():.0%} of {len(result)} are within 5 % of the diameter")
print(f"median error {np.median(errors):.4f} of the diameter")
