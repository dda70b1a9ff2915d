"""Soft matching of two point sets by unbalanced optimal transport (Sinkhorn 1967; Chizat et al. 2018)."""

from __future__ import annotations

import numpy as np

from .._core.compiling import jit

BLOCK = 500
"""Candidates that are compared at a time: the matrix between them and the queries must fit into memory."""


class Transport:
    """An entropic transport plan between two sets of points in one feature space.

    Every point of the first set sends the same mass, and every point of the second receives about the same, so that two
    legs of one surface are not both matched with the same leg of the other.

    Parameters
    ----------
    first, second
        (p1, k) and (p2, k): features.
    balance
        Exponent b in [0, 1] with which the masses of the second set are enforced: 1 is balanced transport, 0 sends
        each point to its nearest alone.
    sharpness, neighbor
        The temperature is the sharpness times a typical increase of squared distance: the median, over the first
        set, of how much farther the neighbour of this number (from 0) is than the nearest.
    iterations
        Number of Sinkhorn iterations.
    """

    def __init__(
        self,
        first: np.ndarray,
        second: np.ndarray,
        *,
        balance: float = 0.8,
        sharpness: float = 0.45,
        neighbor: int = 10,
        iterations: int = 10,
    ) -> None:
        self._first, self._balance = first.astype(np.float32), np.float32(balance)
        # All in place: allocating a matrix of this size takes as long as the operations on it.
        kernel = _squared_distances(self._first, second)
        self._nearest = kernel.min(axis=1)
        kernel -= self._nearest[:, None]
        some = kernel[:: max(1, len(kernel) // 200)]
        number = min(neighbor, kernel.shape[1] - 1)
        self.temperature = sharpness * float(np.median(np.partition(some, number, axis=1)[:, number])) + 1e-12
        self._to_kernel(kernel)
        self._sent = _balance(kernel, self._balance, iterations)
        self.plan: np.ndarray = kernel
        """(p1, p2) float32: the share of each first point's mass that each second point gets; rows sum to 1."""

    def _to_kernel(self, squared: np.ndarray) -> None:
        """Turn squared distances, less that of the nearest, into the Gibbs kernel, in place."""
        np.maximum(squared, 0, out=squared)
        squared *= np.float32(-1 / self.temperature)
        np.exp(squared, out=squared)
        # The floor keeps every sum positive; it is far below the kernel of any match.
        squared += np.float32(1e-20)

    def images(self, queries: np.ndarray, candidates: np.ndarray) -> np.ndarray:
        """Images (q,) int64 of further points among further candidates.

        The dual variables of the plan extend it to points outside of the two sets, so dense sets need no new solution.

        Parameters
        ----------
        queries, candidates
            (q, k) and (c, k) features in the same space.
        """
        queries = queries.astype(np.float32)
        same = np.array_equal(queries, self._first)
        image, least = np.zeros(len(queries), np.int64), np.full(len(queries), np.inf, np.float32)
        for start in range(0, len(candidates), BLOCK):
            block = candidates[start : start + BLOCK]
            squared = _squared_distances(self._first, block)
            cost = squared.copy() if same else _squared_distances(queries, block)
            squared -= self._nearest[:, None]
            self._to_kernel(squared)
            cost += np.float32(self.temperature) * self._balance * np.log(self._sent @ squared)
            nearest = cost.argmin(axis=1)
            value = cost[np.arange(len(queries)), nearest]
            better = value < least
            image[better], least[better] = start + nearest[better], value[better]
        return image


@jit(fastmath={"reassoc"})
def _balance(kernel: np.ndarray, balance: np.float32, iterations: int) -> np.ndarray:
    """Turn the kernel (p1, p2) into the plan, in place; return the factors (p1,) of its rows."""
    share = np.float32(kernel.shape[0]) / np.float32(kernel.shape[1])
    received, sent = np.ones(kernel.shape[1], np.float32), np.empty(kernel.shape[0], np.float32)
    mass = np.empty_like(received)
    for iteration in range(iterations + 1):
        mass[:] = np.float32(0)
        for i in range(len(sent)):
            row, through = kernel[i], np.float32(0)
            for j in range(len(row)):
                through += row[j] * received[j]
            sent[i] = np.float32(1) / through
            if iteration == iterations:  # the last step balances the rows
                row *= sent[i] * received
                continue
            for j in range(len(row)):
                mass[j] += sent[i] * row[j]
        if iteration < iterations:
            received[:] = (share / mass) ** balance
    return sent


def _squared_distances(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Squared distances (p1, p2) float32 as one matrix product: two further columns hold the squared norms."""
    sides = []
    for factor, points, own in ((-2, first, -2), (1, second, -1)):
        wide = np.ones((len(points), points.shape[1] + 2), np.float32)
        wide[:, :-2] = points
        wide[:, own] = np.einsum("ij,ij->i", wide[:, :-2], wide[:, :-2])
        wide[:, :-2] *= factor
        sides.append(wide)
    return sides[0] @ sides[1].T
