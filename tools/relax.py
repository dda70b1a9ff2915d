"""Skin that slides and folds instead of stretching: as-rigid-as-possible relaxation of a skinned pose.

Linear blend skinning stretches and squeezes the surface by a third and more at shoulders, hips and knees.
Sorkine and Alexa's iteration (As-Rigid-As-Possible Surface Modeling, 2007), held softly to the skinned pose,
takes most of that away.
"""

import igl
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, diags_array
from scipy.sparse.linalg import splu

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

REACH = 0.3  # metres; at this size holding to the skinned pose weighs as much as rigidity
ROUNDS = 30


def relaxed(rest: Floats, skinned: Floats, faces: Ints, reach: float = REACH, rounds: int = ROUNDS) -> Floats:
    """The skinned pose (n, 3) with lengths nearer to those at rest (n, 3)."""
    n = len(rest)
    start, end = igl.edges(faces).T
    start, end = np.hstack([start, end]), np.hstack([end, start])
    weight = np.maximum(csr_array(igl.cotmatrix(rest, faces))[start, end], 1e-3)
    link = csr_array((weight, (start, end)), shape=(n, n))
    hold = igl.massmatrix(rest, faces).diagonal()[:, None] / reach**2
    solver = splu((diags_array(link.sum(axis=1) + hold[:, 0]) - link).tocsc())
    at_start = csr_array((np.ones(len(start)), (start, np.arange(len(start)))), shape=(n, len(start)))

    edge = rest[start] - rest[end]
    posed = skinned
    for _ in range(rounds):
        now = posed[start] - posed[end]
        spread = at_start @ (weight[:, None, None] * now[:, :, None] * edge[:, None, :]).reshape(-1, 9)
        left, _, right = np.linalg.svd(spread.reshape(-1, 3, 3))
        left[:, :, 2] *= np.sign(np.linalg.det(left @ right))[:, None]
        turn = left @ right
        turned = np.einsum("eij,ej->ei", turn[start] + turn[end], edge) / 2
        posed = solver.solve(at_start @ (weight[:, None] * turned) + hold * skinned)
    return posed
