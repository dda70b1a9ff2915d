"""Soft matching of two point sets that lets no part be left over: unbalanced optimal transport (Sinkhorn 1967)."""

from __future__ import annotations

import numpy as np

SHARPNESS = 0.45
"""Temperature, as a fraction of the typical squared distance to the neighbour of number NEIGHBOUR."""

NEIGHBOUR = 10
ITERATIONS = 10

BALANCE = 0.8
"""How strictly the masses of the second set bind: 1 leaves no point of it over, 0 takes the nearest point alone."""


class Transport:
    """An entropic transport plan between points of two feature spaces that have been brought together.

    Every point of the first set sends the same mass; those of the second receive about the same, so that two legs of
    one surface do not both end on the same leg of the other.

    Parameters
    ----------
    first, second
        (p1, k) and (p2, k): features.
    balance
        See :data:`BALANCE`.
    """

    def __init__(
        self,
        first: np.ndarray,
        second: np.ndarray,
        balance: float = BALANCE,
    ) -> None:
        self.first = first.astype(np.float32)
        self._balance = balance
        squared = _squared_distances(self.first, second)
        self._nearest = squared.min(axis=1, keepdims=True)
        squared -= self._nearest
        some = squared[:: max(1, len(squared) // 200)]
        number = min(NEIGHBOUR, squared.shape[1] - 1)
        self.temperature = SHARPNESS * float(np.median(np.partition(some, number, axis=1)[:, number])) + 1e-12
        kernel = self._kernel(squared)
        size1, size2 = map(np.float32, kernel.shape)
        received = np.ones(kernel.shape[1], np.float32)
        for _ in range(ITERATIONS):
            self._sent = 1 / (kernel @ received)
            received = (size1 / size2 / (self._sent @ kernel)) ** np.float32(balance)
        self._sent = 1 / (kernel @ received)
        self.plan: np.ndarray = self._sent[:, None] * kernel * received
        """(p1, p2) float32: which part of each point's mass goes where; rows sum to 1."""

    def _kernel(self, squared: np.ndarray) -> np.ndarray:
        # The floor keeps every sum positive; it is far below what any match is worth.
        return np.exp(np.maximum(squared, 0.0) / -self.temperature) + np.float32(1e-20)

    def images(self, queries: np.ndarray, candidates: np.ndarray) -> np.ndarray:
        """Where further points of the first space go among further points of the second: numbers (q,) int64.

        The plan is extended by the very formula that balanced it, so that it need not be solved anew for dense sets.

        Parameters
        ----------
        queries, candidates
            (q, k) and (c, k) features in the same spaces.
        """
        offer = np.zeros(len(candidates), np.float32)
        for block in np.array_split(np.arange(len(candidates)), 1 + len(candidates) // 4000):
            offer[block] = self._sent @ self._kernel(_squared_distances(self.first, candidates[block]) - self._nearest)
        toll = self.temperature * self._balance * np.log(offer)
        found = np.empty(len(queries), np.int64)
        size = max(1, 4_000_000 // len(candidates))
        for start in range(0, len(queries), size):
            squared = _squared_distances(queries[start : start + size], candidates)
            found[start : start + size] = np.argmin(squared + toll, axis=1)
        return found


def _squared_distances(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    first, second = first.astype(np.float32, copy=False), second.astype(np.float32, copy=False)
    return np.einsum("ij,ij->i", first, first)[:, None] + np.einsum("ij,ij->i", second, second) - 2 * first @ second.T
