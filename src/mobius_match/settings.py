"""Every setting of the method in two frozen records, checked when they are made.

The same settings stand in typed dictionaries, so that an editor completes the keywords of :func:`mobius_match.match`;
a test compares the two.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, fields, replace
from typing import Any, Literal, TypedDict, get_args

from .errors import SettingsError

LEAST_PROBABILITY, LEAST_VOTES, LEAST_ALIGNMENT_PROBABILITY = 0.5, 0.1, 0.1
"""Defaults of the threshold: with guided proposals the match is more likely right than wrong; with uniform ones it is a
share of the votes (section 8). Below the third, the alignment's, nothing counts as found."""

LARGEST_SPACING = 0.2
"""Largest spacing of matches per sqrt(area)."""

Geodesics = Literal["heat", "dijkstra"]
Triangulation = Literal["delaunay", "mesh"]
Placement = Literal["mean", "closest"]
Proposal = Literal["guided", "uniform"]
Distance = Literal["euclidean", "spherical"]
Assignment = Literal["greedy", "linear"]
Reflect = Literal["no", "yes", "auto"]
Preset = Literal["paper"]

WHICH_PIECES = ("largest", "all")  # values of ``pieces`` that are no names

PAPER_VOTES_PER_TRIPLET = 10
"""Section 9: about ten votes are cast for each of the N**3 correct triplets ..."""
PAPER_VOTES_RANGE = (5_000_000, 20_000_000)
"""... and between 5 and 20 million triplets were drawn in all of the paper's examples."""


def _check(condition: bool, what: str, value: object, remedy: str) -> None:
    if not condition:
        raise SettingsError(f"`{what}` is {value!r}; {remedy}")


def _check_choice(what: str, value: object, kind: Any) -> None:
    choices = get_args(kind)
    _check(value in choices, what, value, f"choose one of {', '.join(choices)}")


def check_names(names: Iterable[str], known: Iterable[str], function: str) -> None:
    """Refuse keywords that are no settings of a function, and name the one that was probably meant.

    Raises
    ------
    SettingsError
        For the first name that is not known.
    """
    known = sorted(known)
    for name in names:
        if name in known:
            continue
        close = difflib.get_close_matches(name, known, n=1)
        hint = f"did you mean {close[0]!r}? Its" if close else "its"
        raise SettingsError(f"{function} has no setting {name!r}; {hint} settings are {', '.join(known)}")


def _check_whole(what: str, value: object, least: int, most: int) -> None:
    whole = isinstance(value, int) and not isinstance(value, bool)
    _check(whole, what, value, "give a whole number")
    _check(least <= value <= most, what, value, f"give a number from {least} to {most}")  # type: ignore[operator]


def _check_number(what: str, value: object, most: float) -> None:
    remedy = f"give a number from 0 to {most}"
    _check(isinstance(value, int | float), what, value, remedy)
    _check(0 <= value <= most, what, value, remedy)  # type: ignore[operator]


@dataclass(frozen=True)
class PrepareSettings:
    """How one mesh is prepared for matching (sections 4 and 5).

    Parameters
    ----------
    samples
        Number of sample points N.
    geodesics
        ``"heat"`` (robust heat method) or ``"dijkstra"`` (shortest edge paths, the paper's).
    triangulation
        ``"delaunay"`` flattens the intrinsic Delaunay triangulation, ``"mesh"`` the mesh's own triangles.
    placement
        Position of a sample in the plane: ``"mean"`` of the mid-edges around it, or the ``"closest"`` mid-edge.
    resolution
        Meshes with more than 1.5 times this number of vertices are simplified to it, and results are carried back to
        all vertices; 0 computes on all vertices.
    pieces
        Of several pieces, the one that is matched: ``"largest"``; or the largest of those with this name, of an OBJ
        group, object or material, or of a glTF node or mesh. The others are carried along, or matched with pieces of
        the other shape: the large ones by the whole method, with ``"all"`` every one that has enough vertices.
    """

    samples: int = 100
    geodesics: Geodesics = "heat"
    triangulation: Triangulation = "delaunay"
    placement: Placement = "mean"
    resolution: int = 8000
    pieces: str = "largest"

    def __post_init__(self) -> None:
        _check_whole("samples", self.samples, 4, 5000)
        for name, kind in ("geodesics", Geodesics), ("triangulation", Triangulation), ("placement", Placement):
            _check_choice(name, getattr(self, name), kind)
        _check_whole("resolution", self.resolution, 0, 10**9)
        _check(isinstance(self.pieces, str) and self.pieces != "", "pieces", self.pieces, "give largest, all or a name")


@dataclass(frozen=True)
class MatchSettings(PrepareSettings):
    """How two surfaces are prepared and matched (sections 4 to 8).

    Parameters
    ----------
    samples, geodesics, triangulation, placement, resolution, pieces
        As in :class:`PrepareSettings`.
    votes
        Number of triplets to evaluate. None: with guided proposals until the votes no longer change, at most 20,000;
        with uniform ones the paper's number.
    proposal
        ``"guided"`` draws triplets that agree in geodesic distances, ``"uniform"`` draws as the paper does.
    distance
        Distance of section 7: ``"euclidean"`` or ``"spherical"``.
    min_fraction
        The paper's K as a fraction of the samples: triplets with fewer mutually nearest pairs do not vote.
        None: 0.4 for uniform proposals; guided ones weight the pairs instead and need no K.
    epsilon
        The paper's small number in the magnitude 1 / (epsilon + E / n) of a vote.
    assignment
        ``"greedy"`` (max-row-column) or ``"linear"`` (global linear assignment), section 8.
    threshold
        Minimum confidence of a match, 0 to 1: others are dropped; None: 0.5 times the alignment's probability. With
        uniform proposals the paper's S: pairs below it are kept only if the others support them; None: 0.1.
    recovery_radius
        Section 8's delta as a fraction of the geodesic diameter; 0 leaves recovered pairs out.
    spacing
        Minimum distance of matches between the samples from all samples and from each other, per sqrt(area), 0 to 0.2.
        Of two that are closer, the more confident one is reported. 0 reports all of about 1200 points; 0.2 only the
        samples, as uniform proposals and parts of a surface always do.
    reflect
        Whether the mirror image of the source is matched, as a left hand with a right one: ``"no"``, ``"yes"``, or
        ``"auto"``: matched are both, and the mirror image is taken where it fits clearly better.
    seed
        Seed of all randomness, 0 or larger.
    jobs
        Number of threads; None uses every processor. The result does not depend on it.
    """

    votes: int | None = None
    proposal: Proposal = "guided"
    distance: Distance = "euclidean"
    min_fraction: float | None = None
    epsilon: float = 0.01
    assignment: Assignment = "greedy"
    threshold: float | None = None
    recovery_radius: float = 0.05
    spacing: float = 0.025
    reflect: Reflect = "no"
    seed: int = 0
    jobs: int | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.votes is not None:
            _check_whole("votes", self.votes, 1, 10**10)
        choices = {"proposal": Proposal, "distance": Distance, "assignment": Assignment, "reflect": Reflect}
        for name, kind in choices.items():
            _check_choice(name, getattr(self, name), kind)
        for name in ("min_fraction", "threshold", "recovery_radius"):
            value = getattr(self, name)
            if value is not None:
                _check_number(name, value, 1)
        _check_number("spacing", self.spacing, LARGEST_SPACING)
        _check(isinstance(self.epsilon, int | float), "epsilon", self.epsilon, "give a positive number")
        _check(0 < self.epsilon < float("inf"), "epsilon", self.epsilon, "give a positive number")
        _check_whole("seed", self.seed, 0, 2**63 - 1)
        if self.jobs is not None:
            _check_whole("jobs", self.jobs, 1, 1024)

    def preparation(self) -> PrepareSettings:
        """The settings of the preparation of each mesh.

        Returns
        -------
        PrepareSettings
            Its fields have the values that they have here.
        """
        values = {f.name: getattr(self, f.name) for f in fields(PrepareSettings) if f.name != "pieces"}
        return PrepareSettings(**values, pieces=prepared_piece(self.pieces))

    def number_of_votes(self) -> int:
        """The number of triplets that are evaluated.

        Returns
        -------
        int
            ``votes``, or the largest number that the program chooses.
        """
        if self.votes is not None:
            return self.votes
        if self.proposal == "uniform":
            wanted = PAPER_VOTES_PER_TRIPLET * self.samples**3
            return min(max(wanted, PAPER_VOTES_RANGE[0]), PAPER_VOTES_RANGE[1])
        return 20_000

    def to_dict(self) -> dict[str, Any]:
        """All settings as JSON-able values.

        Returns
        -------
        dict
            The values by name.
        """
        return asdict(self)


PRESETS: dict[str, dict[str, Any]] = {
    "paper": {
        "samples": 100,
        "geodesics": "dijkstra",
        "triangulation": "mesh",
        "placement": "closest",
        "resolution": 0,
        "proposal": "uniform",
        "distance": "euclidean",
        "min_fraction": 0.4,
        "assignment": "greedy",
        "threshold": 0.0,
        "recovery_radius": 0.0,
    }
}
"""Named groups of settings. "paper": what the publication used for its figures 8 and 9."""


def prepared_piece(pieces: str) -> str:
    """The value of ``pieces`` of a preparation: whether all pieces are matched makes no difference to it."""
    return "largest" if pieces == "all" else pieces


class PrepareOptions(TypedDict, total=False):
    """The fields of :class:`PrepareSettings`, as keywords."""

    samples: int
    geodesics: Geodesics
    triangulation: Triangulation
    placement: Placement
    resolution: int
    pieces: str


class SymmetryOptions(PrepareOptions, total=False):
    """The settings of :func:`mobius_match.symmetry`, as keywords."""

    votes: int | None
    seed: int
    jobs: int | None


class MatchOptions(SymmetryOptions, total=False):
    """The fields of :class:`MatchSettings`, as keywords."""

    proposal: Proposal
    distance: Distance
    min_fraction: float | None
    epsilon: float
    assignment: Assignment
    threshold: float | None
    recovery_radius: float
    spacing: float
    reflect: Reflect


def make_settings(preset: str | None = None, **overrides: Any) -> MatchSettings:
    """Settings from a preset's values, with the caller's own values in place of them.

    Raises
    ------
    SettingsError
        For an unknown preset or setting, or a value that is out of range.
    """
    check_names(overrides, (f.name for f in fields(MatchSettings)), "match")
    return replace(MatchSettings(), **{**_of_preset(preset), **overrides})


def make_prepare_settings(
    settings: PrepareSettings | None, preset: str | None, overrides: Mapping[str, Any]
) -> PrepareSettings:
    """Settings of a preparation: a record, a preset's values in place of its own, and the caller's in place of these.

    Raises
    ------
    SettingsError
        For an unknown preset or setting, or a value that is out of range.
    """
    known = [f.name for f in fields(PrepareSettings)]
    check_names(overrides, known, "prepare")
    if settings is None:
        settings = PrepareSettings()
    elif not isinstance(settings, PrepareSettings):
        raise SettingsError(f"`settings` is {settings!r}; give a PrepareSettings, or its fields as keywords")
    elif isinstance(settings, MatchSettings):
        settings = settings.preparation()
    of_preset = {name: value for name, value in _of_preset(preset).items() if name in known}
    chosen = replace(settings, **{**of_preset, **overrides})
    return replace(chosen, pieces=prepared_piece(chosen.pieces))


def _of_preset(preset: str | None) -> dict[str, Any]:
    if preset is None:
        return {}
    _check_choice("preset", preset, Preset)
    return PRESETS[preset]
