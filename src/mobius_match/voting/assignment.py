"""Section 8, correspondence matrix processing: from the fuzzy matrix C to a list of pairs with confidence."""

from __future__ import annotations

import numpy as np


def normalized(votes: np.ndarray) -> np.ndarray:
    """C divided by its largest value, so that all values lie in [0, 1]."""
    largest = votes.max(initial=0.0)
    return votes / largest if largest > 0 else votes


def max_row_column(matrix: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The greedy max-row-column algorithm: take the largest entry, zero its row and column, repeat.

    Parameters
    ----------
    matrix
        (N1, N2) float64, not negative. Of equal entries the first in reading order is taken.

    Returns
    -------
    pairs
        (Q, 2) int64 row and column numbers in the order taken; ends when no entry greater than zero is left.
    confidence
        (Q,) float64, the entries, not increasing.
    """
    order = np.argsort(-matrix, axis=None, kind="stable")
    order = order[matrix.ravel()[order] > 0]
    free_rows, free_columns = np.ones(matrix.shape[0], bool), np.ones(matrix.shape[1], bool)
    pairs = []
    for row, column in zip(*np.unravel_index(order, matrix.shape), strict=True):
        if free_rows[row] and free_columns[column]:
            free_rows[row] = free_columns[column] = False
            pairs.append((row, column))
    found = np.array(pairs, np.int64).reshape(-1, 2)
    return found, matrix[found[:, 0], found[:, 1]]


def linear_assignment(matrix: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The global choice that section 8 names: the assignment with the largest sum, without its pairs of value zero.

    Parameters and results are those of :func:`max_row_column`; pairs are sorted by value.
    """
    from scipy.optimize import linear_sum_assignment

    rows, columns = linear_sum_assignment(matrix, maximize=True)
    pairs = np.stack([rows, columns], axis=1).astype(np.int64)
    values = matrix[rows, columns]
    order = np.argsort(-values, kind="stable")
    order = order[values[order] > 0]
    return pairs[order], values[order]


def feature_vectors(distances: np.ndarray, trusted: np.ndarray) -> np.ndarray:
    """Geodesic distances of every sample to the trusted ones, each vector divided by its median.

    Parameters
    ----------
    distances
        (N, N) geodesic distances between the samples.
    trusted
        (Q,) numbers of the trusted samples.

    Returns
    -------
    numpy.ndarray
        (N, Q), without units.
    """
    vectors = distances[:, trusted]
    medians = np.median(vectors, axis=1, keepdims=True)
    return vectors / np.where(medians > 0, medians, 1.0)


def relative_distances(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Squared relative L2 distances |a - b|^2 / (|a| |b|) between feature vectors (N1, Q) and (N2, Q): (N1, N2)."""
    norms1, norms2 = np.linalg.norm(first, axis=1), np.linalg.norm(second, axis=1)
    squared = norms1[:, None] ** 2 + norms2[None, :] ** 2 - 2 * first @ second.T
    products = norms1[:, None] * norms2[None, :]
    return np.maximum(squared, 0.0) / np.where(products > 0, products, 1.0)


def recover(
    pairs: np.ndarray,
    trusted: np.ndarray,
    distances1: np.ndarray,
    distances2: np.ndarray,
    radius1: float,
    radius2: float,
) -> np.ndarray:
    """Which weak pairs the trusted ones support (section 8, last paragraph).

    A pair (z_j, w_j) is supported if the sample of surface 2 that is closest to z_j in feature space lies within the
    radius of w_j, and the sample of surface 1 that is closest to w_j within the radius of z_j.

    Parameters
    ----------
    pairs
        (Q, 2) sample numbers.
    trusted
        (Q,) bool: which of the pairs are trusted. With fewer than three no pair is recovered, since two distances
        do not determine a point.
    distances1, distances2
        (N1, N1) and (N2, N2) geodesic distances between the samples.
    radius1, radius2
        The paper's delta on each surface, in the units of the distances.

    Returns
    -------
    numpy.ndarray
        (Q,) bool, False for the trusted pairs.
    """
    if trusted.sum() < 3:
        return np.zeros(len(pairs), bool)
    difference = relative_distances(
        feature_vectors(distances1, pairs[trusted, 0]), feature_vectors(distances2, pairs[trusted, 1])
    )
    first, second = pairs[:, 0], pairs[:, 1]
    nearest2, nearest1 = difference.argmin(axis=1)[first], difference.argmin(axis=0)[second]
    near = (distances2[nearest2, second] < radius2) & (distances1[nearest1, first] < radius1)
    return near & ~trusted
