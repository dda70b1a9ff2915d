"""
A first match
=============

Two poses of an animal, each meshed on its own: which vertex of one is which vertex of the other?
"""

import numpy as np

import mobius_match as mm
from mobius_match import examples
from mobius_match.figures import draw_matches

source, target = examples.paths("quadruped")
result = mm.match(source, target, seed=0)
for (i, j), confidence, kind in list(zip(result.pairs, result.confidence, result.kind, strict=True))[:5]:
    print(f"vertex {i} is vertex {j} with confidence {confidence:.3f} ({kind})")

# %%
# A sphere of one colour on both sides is one match; the larger, the more certain. The picture shows the matches that
# can be seen from one side; :doc:`/viewer` shows them all.

draw_matches(result, "matches.png")

# %%
# The true places are known here. Each match names a point inside a face of the target, finer than its vertices:

faces, barycentric = examples.truth("quadruped")
mesh = mm.read_mesh(target)
true = np.einsum("qc,qcx->qx", barycentric, mesh.vertices[mesh.faces[faces]])[result.pairs[:, 0]]
found = result.target_points.values(mesh.vertices)
errors = np.linalg.norm(found - true, axis=1) / result.target_info["diameter"]
print(f"{(errors < 0.05).mean():.0%} of {len(result)} are within 5 % of the diameter")
print(f"median error {np.median(errors):.4f} of the diameter")
