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
from ...surface.surface import Surface
from .partners import find_partners, piece_map
from .riding import PieceMap, map_of_all_pieces
from .search import PiecePair, PieceSearch
from .sides import Side


def with_all_pieces(result: Correspondence, known: list[PiecePair], search: PieceSearch, pair: bool) -> Correspondence:
    """A result in which the other pieces are matched too, where both shapes have them, or are carried along.

    Parameters
    ----------
    result
        The match of the main pieces; returned as it is if there are no others.
    known
        Other pairs of pieces that are matched already.
    search
        What the search for partners needs.
    pair
        Whether partners are looked for.
    """
    meshes = [surface.whole_mesh for surface in (result.source, result.target) if surface is not None]
    if len(meshes) < 2 or all(mesh.others is None for mesh in meshes):
        return result
    source, target = map(Side, meshes)
    partners = list[PiecePair]()
    if pair and all(mesh.others is not None for mesh in meshes):
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
        warnings=(*result.warnings, *_notes(meshes, partners)),
        _make_dense=dense,
    )


def of_whole(result: Correspondence, source: Surface, target: Surface, notes: list[str]) -> Correspondence:
    """The match of two pieces as that of the shapes whose main pieces they are."""
    return replace(
        result,
        source=source,
        target=target,
        source_info=source.info,
        target_info=target.info,
        warnings=(*result.warnings, *notes),
        _make_dense=result.dense,
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
