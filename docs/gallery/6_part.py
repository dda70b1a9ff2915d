"""
A part of a shape
=================

The front half of an animal is located on the whole animal in another pose.
"""

import numpy as np

import mobius_match as mm

first, second = mm.examples.paths("quadruped")
whole = mm.read_mesh(first)
front = (whole.vertices[whole.faces][:, :, 2] > 0.05).all(axis=1)  # it looks along z
part = mm.Mesh(whole.vertices, whole.faces[front], name="front half")

result = mm.match(part, second, seed=0)
print(result)
print(*result.warnings, sep="\n")
mm.draw_matches(result, "part.png")

# %%
# There are no matches for what is missing, nor next to the cut. The part has the vertex numbers of the first pose, so
# the truth is known:

faces, barycentric = mm.examples.truth("quadruped")
mesh = mm.read_mesh(second)
true = np.einsum("qc,qcx->qx", barycentric, mesh.vertices[mesh.faces[faces]])
found = result.target_points.values(mesh.vertices)
errors = np.linalg.norm(found - true[result.pairs[:, 0]], axis=1) / result.target_info["diameter"]
print(f"{len(result)} matches, {(errors < 0.05).mean():.0%} within 5 % of the diameter")
