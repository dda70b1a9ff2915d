"""
A first match
=============

Two poses of an animal that were meshed independently: which vertex of the one corresponds to which of the other?
"""

import numpy as np

import mobius_match as mm

source, target = mm.examples.paths("quadruped")
result = mm.match(source, target, seed=0)
for k in range(5):
    i, j = result.pairs[k]
    print(f"vertex {i} matches vertex {j}, confidence {result.confidence[k]:.3f} ({result.kind[k]})")

# %%
# Spheres of the same colour are one match; larger spheres are more certain. The picture shows the matches that are
# visible from one side; :doc:`/viewer` shows all of them.

mm.draw_matches(result, "matches.png", size=(1600, 640))

# %%
# The true positions are known here. Each match names a point inside a face of the target, which is finer than its
# vertices:

faces, barycentric = mm.examples.truth("quadruped")
mesh = mm.read_mesh(target)
true = np.einsum("qc,qcx->qx", barycentric, mesh.vertices[mesh.faces[faces]])
found = result.target_points.values(mesh.vertices)
errors = np.linalg.norm(found - true[result.pairs[:, 0]], axis=1) / result.target_info["diameter"]
print(f"{(errors < 0.05).mean():.0%} of {len(result)} are within 5 % of the diameter")
print(f"median error {np.median(errors):.4f} of the diameter")
