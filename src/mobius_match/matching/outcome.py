"""How two surfaces correspond: the alignment of two wholes, or the place of a part; and how this is decided."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import partial

from .._core.display import one_line
from ..alignments.alignment import Alignment
from ..alignments.candidates import Candidates, alignments_with_landmarks
from ..alignments.selection import choose_alignment
from ..landmarks.constraints import LandmarkConstraints
from ..settings import MatchSettings
from ..surface.surface import Surface
from ..voting.votes import Votes
from .parameters import Parameters
from .partial.coverage import Coverage
from .partial.decision import choose_coverage
from .partial.part import PartMatch, locate_parts


@dataclass(frozen=True, eq=False)
class Outcome:
    """How two surfaces correspond.

    Parameters
    ----------
    votes
        The votes; cast once more if landmarks disagreed with the first ones.
    coverage
        Whether they correspond as wholes, one is a part of the other, or each lacks something.
    alignments
        The alignments of two wholes, the chosen one first, which is registered; none with uniform proposals.
    part
        The place of the part, where one of them is a part.
    notes
        A line each on coverage.
    """

    votes: Votes
    coverage: Coverage
    alignments: list[Alignment] = field(default_factory=list)
    part: PartMatch | None = None
    notes: list[str] = field(default_factory=list)

    def __repr__(self) -> str:
        return one_line(self)

    @property
    def probability(self) -> float | None:
        """That the two correspond in this way; None for votes alone, from which nothing of the kind follows."""
        if self.part is not None:
            return float(self.part.match_probabilities.max(initial=0.0))
        return self.alignments[0].probability if self.alignments else None

    @property
    def order(self) -> int:
        """How many alignments of wholes are equally right by a symmetry of the shapes."""
        return self.alignments[0].order if self.alignments else 1


def align(
    source: Surface,
    target: Surface,
    votes: Votes,
    settings: MatchSettings,
    parameters: Parameters,
    constraints: LandmarkConstraints | None = None,
) -> Outcome:
    """Beyond the paper: decide whether one surface is a part of the other, and choose among alignments of wholes.

    The paper's own voting, with uniform proposals, has no alignments: its votes are all there is.
    """
    if settings.proposal != "guided":
        return Outcome(votes, Coverage.WHOLE)
    constants = parameters.alignment
    candidates = Candidates(source, target, constants, constraints, settings.jobs)
    votes, found = alignments_with_landmarks(candidates, votes, settings)
    alignments = choose_alignment(candidates, found)
    locate = partial(
        locate_parts,
        source,
        target,
        parameters.partial,
        constants.registration,
        settings.seed,
        settings.jobs,
        constraints,
        constants.voting,
    )
    coverage, part, notes = choose_coverage(source, target, locate, alignments, parameters.partial, constants)
    return Outcome(votes, coverage, [] if part else alignments, part, notes)
