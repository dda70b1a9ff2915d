"""Where a part lies on a whole: triplets judged by distances, and the part bent onto the whole at the best places."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import scipy

from .confidence import interpolated, neighbour_means
from .geometry.curvature import curvatures
from .geometry.geodesics import nearest_centres
from .geometry.nearest import nearest_rows
from .geometry.points import SurfacePoints, closest_points
from .hints import Hints
from .hypotheses import rank_correlation
from .mesh.measure import cross_products
from .mesh.topology import boundary_edges
from .registration import ROUNDS, TIGHT, Registration, looks, register, vertex_normals
from .surface import Surface
from .voting.agreement import agreement, as_far
from .voting.groups import group_triplets
from .voting.proposals import guided_triplets

RADII = (0.03, 0.06, 0.1)
"""Widths that curvatures are smoothed to; like all lengths here, per sqrt(area) of the whole."""

TRIPLETS, SPREAD, TOLERANCE, ALIKE = 10_000, 0.3, 0.15, 0.35
"""How many are judged; least distance of their points, relative difference of lengths, part of all pairs allowed."""

APPEARANCE = 0.1
"""Distance that a difference in curvature of one standard deviation counts as much as."""

COARSE = ((2000, (25, 200)), (300, (100, 400)))
"""How many triplets are kept in each round, by points of the part and of the whole; the last are grouped."""

RADIUS, GROUPS, PROMISING = 0.1, 40, 0.8
"""Mean distance of two triplets' places within a group, how many groups, and the least worth of the best triplet of
each, as a part of that of the best of all."""

SKETCHED, REFINED, CLOSE = 12, 2, 1.5
"""How many groups are bent in haste, how many of these are refined, and up to which multiple of the least badness."""

AROUND, TURNS = 24, 8
"""Among how many points next to each the others of its triangles are, and how many of these tell how it is turned."""

LANDMARKS = 50
CAP = 0.15
"""A distance to a landmark that is wrong by more counts no more: it may lead through what is missing."""

WEIGHTS = {"distances": 1.0, "misfit": 10.0, "turn": 1.0, "gauss curvature": 1.0, "mean curvature": 1.0}
"""What each kind of evidence against a place counts."""

WORST, LOOSEST = 1.5, 0.0135
"""Weighted sum, and mean distance of the bent part from the whole, above which the one is no part of the other."""

NEAR, SNAPPED = 0.15, 0.03
"""Over which a landmark has a say in how well distances agree, and how far its image may be from a known one."""

FLOOR = 0.01
SLOPES = {"distances": -2.42, "misfit": -1.27, "cut": 0.80, "badness": -1.41, "curvature": -0.75}
OFFSET = -12.41
"""Logistic regression of being right on the logarithms of the evidence, over parts of animals and people; places on
what is missing count five times. The offset is lowered so that a chance of 0.5 here is one of 0.7 there."""

MARGIN = 0.035
"""Distance from the cut below which no match is reported: what is sent there may as well lie beyond it."""

ON_PART, ASTRAY = 0.02, 0.1
"""Distance of a point of the whole from the bent part, and along the surface, up to which it can belong to it."""


class Pair:
    """A part and the whole in common units, with what is measured on both.

    The area of the part is that of its whole, in the part's own units: all lengths are per sqrt(area).
    In all that follows a landmark is a sample of the part together with the sample of the whole next to its image.
    """

    def __init__(self, part: Surface, whole: Surface, hints: Hints | None = None) -> None:
        self.part, self.whole = part, whole
        self.scale1, self.scale2 = np.sqrt(part.area), np.sqrt(whole.area)
        self.distances1, self.distances2 = (
            (surface.proxy_distances / np.sqrt(surface.area)).astype(np.float32) for surface in (part, whole)
        )
        self.samples1, self.samples2 = (np.searchsorted(surface.proxy, surface.samples) for surface in (part, whole))
        mine, theirs = (
            curvatures((one.mesh.vertices - one.mesh.vertices.mean(axis=0)) / np.sqrt(one.area), one.mesh.faces, RADII)
            for one in (part, whole)
        )
        spread = np.maximum(theirs[whole.proxy].std(axis=0), 1e-9)
        self.curvatures1, self.curvatures2 = mine[part.proxy] / spread, theirs / spread
        each = zip(self.curvatures1.T, self.curvatures2[whole.proxy].T, strict=True)
        unlike = sum(np.abs(mine[:, None] - theirs) for mine, theirs in each)
        self.costs = (APPEARANCE * np.minimum(unlike / self.curvatures1.shape[1], 3.0)).astype(np.float32)
        self._hints = hints
        if hints is not None:
            astray = hints.disagreement(part, whole, part.proxy, whole.proxy)
            self.costs += np.minimum(astray, CAP).astype(np.float32)
        self._triangles = self._wide_triangles()
        # Along the surface: in space a hand may be next to a thigh.
        self._home = nearest_centres(whole.mesh.vertices, whole.mesh.faces, whole.proxy)

    def located(self, generator: np.random.Generator, pool: ThreadPoolExecutor) -> Registration | None:
        """The part bent onto where it lies on the whole; None if it is not there."""
        starts = self.starts(generator, pool)
        found = sorted(pool.map(lambda image: self.bent(image, rounds=1), starts), key=self.badness)
        if not found:
            return None
        promising = [one for one in found[:REFINED] if self.badness(one) <= CLOSE * self.badness(found[0])]
        best = min(pool.map(self.refined, promising), key=self.badness)
        if self.badness(best) > WORST or best.misfit.mean() > LOOSEST:
            return None
        return best

    def refined(self, found: Registration) -> Registration:
        """Bent again, twice, to where the landmarks that it places best say."""
        for _ in range(2):
            found = self.bent(self.image_by_landmarks(*self.landmarks(found)))
        return found

    def starts(self, generator: np.random.Generator, pool: ThreadPoolExecutor) -> list[np.ndarray]:
        """Maps of the part's proxy to the whole's (P1,) that the best triplets stand for, best first."""
        costs = self.costs[np.ix_(self.samples1, self.samples2)]
        alike = costs <= np.quantile(costs, ALIKE)
        lengths = self.part.normalized_distances, self.whole.normalized_distances
        if not len(guided_triplets(generator, 50, *lengths, alike, SPREAD, TOLERANCE)[0]):
            return []
        first, second = guided_triplets(generator, TRIPLETS, *lengths, alike, SPREAD, TOLERANCE)
        for count, points in COARSE:
            some1, some2 = (
                np.arange(0, size, max(1, size // few)) for size, few in zip(self.costs.shape, points, strict=True)
            )
            coarse = self.distances1[:, some1], self.distances2[:, some2], self.costs[np.ix_(some1, some2)]
            totals = agreement(*coarse, first, second, APPEARANCE, pool)
            best = np.argsort(-totals, kind="stable")[:count]
            first, second, totals = first[best], second[best], totals[best]
        pairs = np.empty((len(best), len(self.samples1)), np.int64)
        for row, mine, theirs in zip(pairs, first, second, strict=True):
            apart = np.abs(
                self.distances1[mine][:, self.samples1, None] - self.distances2[theirs][:, None, self.samples2]
            )
            row[:] = (apart.sum(axis=0) + costs).argmin(axis=1)
        groups = group_triplets(pairs, self.whole.normalized_distances, totals, RADIUS, GROUPS)
        good = [group for group in groups if totals[group[0]] >= PROMISING * totals[0]]
        images = list(pool.map(lambda group: self._agreed(pairs[group], totals[group]), good))
        kept = [image for image in images if self.orientation(image) > 0] or images
        return sorted(kept, key=self._unlikeness)[:SKETCHED]

    def _wide_triangles(self) -> tuple[np.ndarray, np.ndarray]:
        """Triangles (t, 3) of points of the part's proxy that are next to each other, and which way they look (t,)."""
        vertices = self.part.mesh.vertices[self.part.proxy]
        near = scipy.spatial.cKDTree(vertices).query(vertices, min(AROUND + 1, len(vertices)))[1]
        first = np.repeat(np.arange(len(near)), TURNS)
        generator = np.random.default_rng(0)
        others = generator.integers(near.shape[1] // 3, near.shape[1], (2, len(first)))
        triangles = np.stack([first, near[first, others[0]], near[first, others[1]]], axis=1)
        looking = _looking(self.part, self.part.proxy[triangles])
        clear = np.abs(looking) > np.median(np.abs(looking))
        return triangles[clear], np.sign(looking[clear])

    def orientation(self, image: np.ndarray) -> float:
        """How many triangles keep their orientation under a map of the proxies (P1,): 1 all of them, -1 none."""
        triangles, looking = self._triangles
        return float((np.sign(_looking(self.whole, self.whole.proxy[image[triangles]])) * looking).mean())

    def _unlikeness(self, image: np.ndarray) -> float:
        """How much distances and curvatures differ under a map of the part's proxy to the whole's (P1,)."""
        apart = self._compared(image)[1].mean()
        return float(apart + 3 * self.costs[np.arange(len(image)), image].mean())

    def _agreed(self, pairs: np.ndarray, totals: np.ndarray) -> np.ndarray:
        """The map that a group of triplets agrees on."""
        votes = np.zeros((pairs.shape[1], len(self.samples2)))
        for row, total in zip(pairs, totals, strict=True):
            votes[np.arange(len(row)), row] += total
        chosen = np.argsort(-votes.max(axis=1), kind="stable")[:LANDMARKS]
        return self.image_by_landmarks(chosen, votes.argmax(axis=1)[chosen])

    def image_by_landmarks(self, mine: np.ndarray, theirs: np.ndarray) -> np.ndarray:
        """Each vertex of the part's proxy to the one of the whole's that is as far from the landmarks: (P1,) int64."""
        return as_far(self.distances1[mine], self.distances2[theirs], CAP, 3 / len(mine), self.costs)

    def bent(self, image: np.ndarray, rounds: int = ROUNDS) -> Registration:
        """The part bent onto the whole along a map of its proxy (P1,) to the whole's."""
        image = self.whole.proxy[image]
        return register(self.part, self.whole, image, whole=False, rounds=rounds, trusts=TIGHT, hints=self._hints)

    def landmarks(self, found: Registration) -> tuple[np.ndarray, np.ndarray]:
        """The landmarks that a registration places best: samples of the part and of the whole."""
        theirs, apart, snapped = self._compared(self._home[found.image])
        doubt = np.median(apart, axis=1) + snapped + 3 * found.misfit[self.samples1] + 0.1 * found.turn[self.samples1]
        mine = np.argsort(doubt, kind="stable")[:LANDMARKS]
        return mine, theirs[mine]

    def _compared(self, image: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The whole's sample (N1,) of each landmark, the errors of distances (N1, P1), how far the sample is off."""
        images = self.distances2[:, image]
        theirs = images[:, self.samples1].argmin(axis=0)
        return theirs, np.abs(self.distances1 - images[theirs]), images[theirs, self.samples1]

    def badness(self, found: Registration) -> float:
        """The weighted sum of the evidence against a registration."""
        gauss, mean = (
            1 - rank_correlation(of_part, of_whole)
            for of_part, of_whole in zip(self.curvatures1.T[2:4], self.curvatures2[found.image].T[2:4], strict=True)
        )
        apart = self._compared(self._home[found.image])[1]
        evidence = {
            "distances": float(apart.mean()),
            "misfit": float(found.misfit.mean()),
            "turn": float(found.turn.mean()),
            "gauss curvature": gauss,
            "mean curvature": mean,
        }
        return sum(WEIGHTS[kind] * value for kind, value in evidence.items())

    def evidence(self, found: Registration) -> dict[str, np.ndarray]:
        """What speaks against the place of each vertex of the part's proxy, or for it: how far the cut is; (P1,)."""
        _, apart, snapped = self._compared(self._home[found.image])
        vertices, around = self.part.mesh.vertices, neighbour_means(self.part)
        unlike = np.abs(self.curvatures1 - self.curvatures2[found.image]).mean(axis=1)
        weight = np.exp(-self.distances1 / NEAR - snapped[:, None] / SNAPPED) + 1e-12
        return {
            "distances": (weight * apart).sum(axis=0) / weight.sum(axis=0),
            "misfit": around @ found.misfit,
            "curvature": around @ unlike,
            "badness": np.full(len(unlike), self.badness(found)),
            "cut": scipy.spatial.cKDTree(vertices[boundary_edges(self.part.mesh.faces).ravel()]).query(
                vertices[self.part.proxy]
            )[0]
            / self.scale1,
        }

    def chances(self, found: Registration) -> np.ndarray:
        """The chance (P1,) float64 in [0, 1] that the place of each vertex of the part's proxy is right."""
        evidence = self.evidence(found)
        score = OFFSET + sum(slope * np.log(evidence[kind] + FLOOR) for kind, slope in SLOPES.items())
        return np.where(evidence["cut"] >= MARGIN, 1 / (1 + np.exp(-score)), 0.0)

    def places_on_whole(self, found: Registration) -> tuple[SurfacePoints, np.ndarray]:
        """Points of the whole for the part's samples, and the chance of each."""
        mesh, here = self.whole.mesh, self.samples1
        points = closest_points(
            mesh.vertices / self.scale2, mesh.faces, found.positions[here] / self.scale2, found.image[here]
        )
        return points, self.chances(found)[here]

    def places_on_part(self, found: Registration) -> tuple[SurfacePoints, np.ndarray]:
        """Points of the part for the whole's samples, and the chance of each; 0 for those that are off the part."""
        mesh = self.part.mesh
        there, rest = (looks(one.mesh.vertices / np.sqrt(one.area), one.mesh.faces) for one in (self.whole, self.part))
        bent = np.hstack([found.positions / self.scale2, there[found.image, 3:]])
        queries = there[self.whole.samples]
        places = interpolated(bent, queries, rest[self.part.proxy].T).T
        points = closest_points(mesh.vertices / self.scale1, mesh.faces, places[:, :3], nearest_rows(places, rest))
        node = scipy.spatial.cKDTree(bent).query(queries)[1]
        middles = bent[self.part.proxy_edges].mean(axis=1)
        apart = scipy.spatial.cKDTree(np.concatenate([bent, middles])).query(queries)[0]
        # Along the surface too: what is missing may touch the part.
        astray = self.distances2[np.arange(len(node)), self._home[found.image[node]]]
        return points, np.where((apart <= ON_PART) & (astray <= ASTRAY), self.chances(found)[node], 0.0)


def _looking(surface: Surface, triangles: np.ndarray) -> np.ndarray:
    """How far triangles (t, 3) of vertices look the way of the normal at their first one, times twice their area."""
    vertices, faces = surface.mesh.vertices, surface.mesh.faces
    return np.einsum("ij,ij->i", cross_products(vertices, triangles), vertex_normals(vertices, faces)[triangles[:, 0]])
