"""A result for all pieces, from that of the main ones."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np

from ...geometry.points import SurfacePoints
from ...mesh import Mesh
from ...mesh.mesh import count
from ...mesh.pieces import pieces_of
from ...results.correspondence import Correspondence
from ...results.surface_map import SurfaceMap
from .partners import find_partners, piece_map
from .riding import PieceMap, map_of_all_pieces
from .search import PiecePair, PieceSearch, surfaces_of
from .sides import Side


def with_all_pieces(result: Correspondence, known: list[PiecePair], search: PieceSearch) -> Correspondence:
    """A result in which the other pieces are matched too, where both shapes have them, or are carried along.

    Parameters
    ----------
    result
        The match of the main pieces; returned as it is if there are no others.
    known
        Other pairs of pieces that are matched already.
    search
        What the search for partners needs. With the paper's own votes, none are looked for.
    """
    sides = [Side.of(surface) for surface in surfaces_of(result)]
    others = [side.mesh.others is not None for side in sides]
    if not any(others):
        return result
    source, target = sides
    partners = list[PiecePair]()
    if search.settings.proposal == "guided" and all(others):
        partners = find_partners(source, target, result.dense(), known, search)
    main = result.dense  # of the result without the others

    @cache
    def dense() -> SurfaceMap:
        maps = [PiecePair(source.main, target.main, None, main()), *partners]
        of_pieces: list[PieceMap] = [piece_map(one, source, target) for one in maps]
        return map_of_all_pieces(source.whole, target.whole, of_pieces, search.parameters, search.controls)

    return replace(
        result,
        **_merged([result, *(one.result for one in partners if one.result is not None)]),
        warnings=(*result.warnings, *_notes([side.mesh for side in sides], partners)),
        _make_dense=dense,
    )


def _merged(results: list[Correspondence]) -> dict[str, Any]:
    """The matches of several results, the most confident first, as fields of a result."""
    if len(results) < 2:
        return {}
    confidence = np.concatenate([one.confidence for one in results])
    given = [np.zeros(len(one), bool) if one.given is None else one.given for one in results]
    order = np.lexsort([-confidence, ~np.concatenate(given)])
    points = [one.target_points for one in results]
    fields: dict[str, Any] = {
        "pairs": np.concatenate([one.pairs for one in results])[order],
        "confidence": confidence[order],
        "kind": np.concatenate([one.kind for one in results])[order],
        "given": None if results[0].given is None else np.concatenate(given)[order],
    }
    known = [one for one in points if one is not None]
    if len(known) == len(points):
        fields["target_points"] = SurfacePoints(
            *(
                np.concatenate([getattr(one, name) for one in known])[order]
                for name in ("faces", "corners", "barycentric")
            )
        )
    return fields


def _notes(meshes: list[Mesh], partners: list[PiecePair]) -> list[str]:
    """A line on the pieces besides the main ones."""
    matched = sum(one.result is not None for one in partners)
    lines = []
    if partners:
        lines.append(
            f"{count(len(partners), 'further piece', 'further pieces')} that both shapes have matched with each other"
            + (f", {matched} of them with matches in the list" if matched else "")
        )
    for mesh in meshes:
        rest = 0 if mesh.others is None else len(pieces_of(mesh.others)) - len(partners)
        if rest:
            lines.append(f"{mesh.name}: {count(rest, 'piece is', 'pieces are')} carried along in dense maps")
    return lines
