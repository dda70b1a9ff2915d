"""Algorithm 2 once more in plain numpy, line by line: what the kernels are compared with, exactly."""

import math

import numpy as np

from mobius_match.voting.canonical import FAR
from mobius_match.voting.mobius import CANONICAL_TRIANGLE

Y1, Y2, Y3 = (complex(y) for y in CANONICAL_TRIANGLE)


def canonical_twin(points, triplet):
    """Equations 3 and 4 for homogeneous points, up to the rotation that makes y1 - y3 real, (2, p) float32."""
    z = np.array([complex(p) if q else 1e100 for p, q in points])
    z1, z2, z3 = (complex(z[t]) for t in triplet)
    if len({z1, z2, z3}) < 3:
        return None
    side = abs(Y1 - Y3)
    corner = Y3 * (side / (Y1 - Y3))
    r = (Y1 - Y2) / (Y2 - Y3) * (z2 - z3) / (z1 - z2)
    u, v = z - z1, z3 - z
    with np.errstate(all="ignore"):
        # Real arithmetic, one operation at a time: the order of rounding matters for the last digit.
        x, y = r.real * u.real - r.imag * u.imag + v.real, r.real * u.imag + r.imag * u.real + v.imag
        real, imag, square = v.real * x + v.imag * y, v.imag * x - v.real * y, x * x + y * y
        finite = square * FAR > np.abs(real) + np.abs(imag)
        scale = side / square
        image = np.where(finite, [corner.real + real * scale, corner.imag + imag * scale], [[FAR], [0.0]])
    return image.astype(np.float32)


def sphere_twin(plane):
    x, y = plane.astype(np.float64)
    square = x * x + y * y
    scale = 1 / (1 + square)
    return np.stack([2 * x * scale, 2 * y * scale, (square - 1) * scale]).astype(np.float32)


def squared_twin(first, second):
    """All squared distances (N1, N2); the order of summation matters for the last bit."""
    squares = [(second[axis][None, :] - first[axis][:, None]) ** 2 for axis in range(len(first))]
    return squares[0] + squares[1] if len(first) == 2 else (squares[0] + squares[1]) + squares[2]


def pairs_twin(first, second):
    """Mutually nearest pairs and their squared distances: a column and its first nearest row that is not taken yet."""
    squared = squared_twin(first, second)
    pairs, least = {}, squared.min(axis=1)
    for j, k in enumerate(squared.argmin(axis=0)):
        if squared[k, j] == least[k] and k not in pairs:
            pairs[int(k)] = j
    return [(k, j, squared[k, j]) for k, j in pairs.items()]


def vote_twin(points1, points2, triplets1, triplets2, least_pairs, epsilon, spherical, weigh=None):
    """Algorithm 2, and its weighed form if ``weigh`` is (geodesics1, geodesics2, similarity, scale, power)."""
    votes, n_voting = np.zeros((len(points1), len(points2))), 0
    for t1, t2 in zip(triplets1, triplets2, strict=True):
        z, w = canonical_twin(points1, t1), canonical_twin(points2, t2)
        if z is None or w is None:
            continue
        candidates = pairs_twin(sphere_twin(z), sphere_twin(w)) if spherical else pairs_twin(z, w)
        if len(candidates) < least_pairs:
            continue
        n_voting += 1
        if weigh is None:
            energy = 0.0
            for _, _, squared in candidates:
                squared = float(squared)
                energy += math.sqrt(squared / max(4.0 - squared, 1e-12) if spherical else squared)
            for k, j, _ in candidates:
                votes[k, j] += 1 / (epsilon + energy / len(candidates))
            continue
        geodesics1, geodesics2, similarity, scale, power = weigh
        weights = []
        for k, j, _ in candidates:
            difference = sum(abs(geodesics1[a, k] - geodesics2[b, j]) / 3 for a, b in zip(t1, t2, strict=True))
            weights.append(similarity[k, j] * math.exp(-((difference / scale) ** 2)))
        for (k, j, _), weight in zip(candidates, weights, strict=True):
            votes[k, j] += weight * (sum(weights) / len(points1)) ** power
    return votes, n_voting
