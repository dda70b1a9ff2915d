"""Soft matching of two point sets that lets no part be left over: unbalanced optimal transport (Sinkhorn 1967)."""

from __future__ import annotations

import numpy as np

from .._core.compiling import jit

SHARPNESS = 0.45
"""Temperature, as a fraction of the typical squared distance to the neighbour of number NEIGHBOUR."""

NEIGHBOUR = 10
ITERATIONS = 10

BALANCE = 0.8
"""How strictly the masses of the second set bind: 1 leaves no point of it over, 0 takes the nearest point alone."""

CANDIDATES = 500
"""How many candidates for the images of further points are worked on at a time."""


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
    neighbour
        See :data:`SHARPNESS`.
    """

    def __init__(
        self,
        first: np.ndarray,
        second: np.ndarray,
        balance: float = BALANCE,
        neighbour: int = NEIGHBOUR,
    ) -> None:
        self._first, self._balance = first.astype(np.float32), np.float32(balance)
        # Everything in place: fresh memory of this size costs as much as what is done with it.
        kernel = _squared_distances(self._first, second)
        self._nearest = kernel.min(axis=1)
        kernel -= self._nearest[:, None]
        some = kernel[:: max(1, len(kernel) // 200)]
        number = min(neighbour, kernel.shape[1] - 1)
        self.temperature = SHARPNESS * float(np.median(np.partition(some, number, axis=1)[:, number])) + 1e-12
        self._to_kernel(kernel)
        self._sent = _balance(kernel, self._balance)
        self.plan: np.ndarray = kernel
        """(p1, p2) float32: which part of each point's mass goes where; rows sum to 1."""

    def _to_kernel(self, squared: np.ndarray) -> None:
        """Squared distances beyond the nearest to what mass passes through, in place."""
        np.maximum(squared, 0, out=squared)
        squared *= np.float32(-1 / self.temperature)
        np.exp(squared, out=squared)
        # The floor keeps every sum positive; it is far below what any match is worth.
        squared += np.float32(1e-20)

    def images(self, queries: np.ndarray, candidates: np.ndarray) -> np.ndarray:
        """Where further points of the first space go among further points of the second: numbers (q,) int64.

        The plan is extended by the very formula that balanced it, so that it need not be solved anew for dense sets.

        Parameters
        ----------
        queries, candidates
            (q, k) and (c, k) features in the same spaces.
        """
        queries = queries.astype(np.float32)
        same = np.array_equal(queries, self._first)
        found, least = np.zeros(len(queries), np.int64), np.full(len(queries), np.inf, np.float32)
        for start in range(0, len(candidates), CANDIDATES):
            some = candidates[start : start + CANDIDATES]
            squared = _squared_distances(self._first, some)
            apart = squared.copy() if same else _squared_distances(queries, some)
            squared -= self._nearest[:, None]
            self._to_kernel(squared)
            apart += np.float32(self.temperature) * self._balance * np.log(self._sent @ squared)
            nearest = apart.argmin(axis=1)
            value = apart[np.arange(len(queries)), nearest]
            better = value < least
            found[better], least[better] = start + nearest[better], value[better]
        return found


@jit(fastmath={"reassoc"})
def _balance(kernel: np.ndarray, balance: np.float32) -> np.ndarray:
    """Turn the kernel (p1, p2) into the plan, in place, and tell what the rows had to be multiplied by, (p1,)."""
    share = np.float32(kernel.shape[0]) / np.float32(kernel.shape[1])
    received, sent = np.ones(kernel.shape[1], np.float32), np.empty(kernel.shape[0], np.float32)
    mass = np.empty_like(received)
    for iteration in range(ITERATIONS + 1):
        mass[:] = np.float32(0)
        for i in range(len(sent)):
            row, through = kernel[i], np.float32(0)
            for j in range(len(row)):
                through += row[j] * received[j]
            sent[i] = np.float32(1) / through
            if iteration == ITERATIONS:  # the rows end in balance
                row *= sent[i] * received
                continue
            for j in range(len(row)):
                mass[j] += sent[i] * row[j]
        if iteration < ITERATIONS:
            received[:] = (share / mass) ** balance
    return sent


def _squared_distances(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """(p1, p2) float32, as one product: two more columns hold the squares of each side."""
    sides = []
    for factor, points, own in ((-2, first, -2), (1, second, -1)):
        wide = np.ones((len(points), points.shape[1] + 2), np.float32)
        wide[:, :-2] = points
        wide[:, own] = np.einsum("ij,ij->i", wide[:, :-2], wide[:, :-2])
        wide[:, :-2] *= factor
        sides.append(wide)
    return sides[0] @ sides[1].T
