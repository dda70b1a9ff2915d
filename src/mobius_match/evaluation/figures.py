"""Figures of an evaluation: the paper's figures 8 and 9, cumulative error curves, confidence and error.

All figures are readable in greyscale and with colour-vision deficiencies: lines also differ in dashes and markers, and
the colour map of the error matrix darkens monotonically. The same numbers give the same bytes.
"""

from __future__ import annotations

import io
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from .._core.display import one_line
from .page import printable
from .summary import CLOSE, NEAR, over_pairs

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

BLUE, ORANGE, GREEN = "#0072b2", "#d55e00", "#00795a"
STYLES: dict[str, dict[str, Any]] = {
    "direct": {"color": BLUE, "linestyle": "-", "marker": "o"},
    "mirrored": {"color": ORANGE, "linestyle": "--", "marker": "^"},
    "better": {"color": GREEN, "linestyle": ":", "marker": "s"},
}
"""Styles of the lines of the three variants."""
_COLOURS = (BLUE, ORANGE, GREEN, "#cc79a7", "#56b4e9", "#000000", "#a6761d", "#7570b3")
_DASHES = ("-", "--", "-.", ":", (0, (5, 1, 1, 1, 1, 1)))
_MARKERS = "o^sDvPX*"
WIDTH = 10.9
"""Width in inches of a figure as wide as the page."""
MAX_NAMES = 70
"""Maximum number of rows of the error matrix that have names."""
MATRIX_TOP = 0.20
"""Error per diameter at the end of the colour scale of the error matrix."""


@dataclass(frozen=True)
class Line:
    """A labelled curve; NaN leaves a gap."""

    label: str
    values: np.ndarray
    style: dict[str, Any]

    def __repr__(self) -> str:
        return one_line(self)


def run_style(number: int) -> dict[str, Any]:
    """Style of the line of one of several runs."""
    return {
        "color": _COLOURS[number % len(_COLOURS)],
        "linestyle": _DASHES[number % len(_DASHES)],
        "marker": _MARKERS[number % len(_MARKERS)],
    }


def draw(make: Callable[..., Figure], *arguments: Any, **options: Any) -> tuple[bytes, bytes]:
    """The figure that ``make`` returns, as the bytes of an SVG and of a PNG file."""
    with _style():
        figure = make(*arguments, **options)
        svg, png = io.BytesIO(), io.BytesIO()
        figure.savefig(svg, format="svg", metadata={"Date": None, "Creator": None})
        figure.set_layout_engine("none")  # keep the layout, whose computation is slow
        figure.savefig(png, format="png", dpi=150, metadata={"Software": None})
    return svg.getvalue(), png.getvalue()


@contextmanager
def _style() -> Iterator[None]:
    """Matplotlib's defaults, independent of the user's settings, and reproducible identifiers."""
    from matplotlib import style

    changes = {
        "svg.hashsalt": "mobius-match",
        "font.family": "DejaVu Sans",
        "font.size": 9,
        "axes.spines.top": False,
        "axes.spines.right": False,
        "axes.grid": True,
        "grid.color": "#dde1e7",
        "grid.linewidth": 0.6,
        "axes.axisbelow": True,
        "axes.titlesize": 10,
        "axes.titlelocation": "left",
        "legend.frameon": False,
        "figure.facecolor": "white",
        "hatch.linewidth": 0.4,
    }
    with style.context(["default", changes]), warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Glyph .* missing")  # a name in a script that the font does not cover
        yield


def _new(width: float, height: float, columns: int = 1) -> tuple[Figure, list[Axes]]:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained")
    return figure, list(figure.subplots(1, columns, squeeze=False)[0])


def label(text: str, most: int = 40) -> str:
    """A name for a figure: one line, at most ``most`` characters."""
    text = printable(text)
    return text if len(text) <= most else text[: most - 1] + "…"


def error_matrix(
    names: Sequence[str], categories: Sequence[str], panels: dict[str, np.ndarray], marks: Sequence[int] = ()
) -> Figure:
    """One row per pair, one column per correspondence in order of confidence, coloured by error per diameter.

    Parameters
    ----------
    names, categories
        P names of pairs, and their categories.
    panels
        Errors (P, K) by title; NaN, where a pair has no such match, is hatched.
    marks
        Numbers of matches that are marked by a line.
    """
    from matplotlib.colors import Normalize

    n_rows = len(names)
    # With names each row needs the height of its name; otherwise the rows share the height of a page.
    height = min(0.155 * n_rows, 10) if n_rows > MAX_NAMES else 0.155 * n_rows
    figure, all_axes = _new(WIDTH, height + 1.5, len(panels))
    norm = Normalize(0, MATRIX_TOP)
    edges = [k for k in range(1, n_rows) if categories[k] != categories[k - 1]]
    for axes, (title, table) in zip(all_axes, panels.items(), strict=True):
        axes.grid(False)
        axes.patch.set(facecolor="#eef0f3", hatch="////", edgecolor="#b9c0ca")
        extent = (0.5, table.shape[1] + 0.5, n_rows - 0.5, -0.5)
        image = axes.imshow(table, "magma_r", norm, aspect="auto", interpolation="none", extent=extent)
        axes.set_title(label(title), parse_math=False)
        axes.set_xlabel("correspondence, in order of confidence")
        for edge in edges:
            axes.axhline(edge - 0.5, color="black", linewidth=0.8)
        for mark in marks:
            if mark < table.shape[1]:
                axes.axvline(mark + 0.5, color="black", linewidth=0.6, linestyle=(0, (4, 3)))
        axes.set_yticks([])
    starts = [0, *edges]
    if n_rows <= MAX_NAMES:
        all_axes[0].set_yticks(range(n_rows), [label(name) for name in names], fontsize=7.5, parse_math=False)
    elif len(starts) <= MAX_NAMES:
        middles = [(a + b - 1) / 2 for a, b in zip(starts, [*edges, n_rows], strict=True)]
        all_axes[0].set_yticks(middles, [label(categories[a]) for a in starts], fontsize=7.5, parse_math=False)
    all_axes[0].tick_params(axis="y", length=0)
    bar = figure.colorbar(
        image, ax=all_axes, location="top", extend="max", shrink=0.6, aspect=45, ticks=[0, 0.03, 0.05, 0.1, 0.15, 0.2]
    )
    bar.set_label("geodesic error per diameter of the target (hatched: no match, or its true point is unknown)")
    return figure


def first_matches(panels: dict[str, np.ndarray], styles: Sequence[str], bins: int = 25) -> Figure:
    """Mean and median over the pairs of the error of the k-th match, and the histogram of all these errors.

    Parameters
    ----------
    panels
        Errors (P, K) by title.
    styles
        Key of ``STYLES`` for each panel.
    bins
        Number of bins of the histogram.
    """
    figure, (curve, histogram) = _new(WIDTH, 3.9, 2)
    for name, (title, table) in zip(styles, panels.items(), strict=True):
        color = STYLES[name]["color"]
        ranks, means = np.arange(1, table.shape[1] + 1), over_pairs(table, np.mean)
        every = 1 if np.isnan(means).any() else 5  # a point between gaps is on no line
        marker = {"marker": STYLES[name]["marker"], "markevery": every, "markersize": 4}
        curve.plot(ranks, means, "-", label=f"{title}: mean", color=color, **marker)
        curve.plot(
            ranks, over_pairs(table, np.median), ":", label=f"{title}: median", color=color, **marker, mfc="white"
        )
        values = table[~np.isnan(table)]
        edges = np.linspace(0, 0.25, bins + 1)
        counts = np.histogram(np.minimum(values, edges[-1] - 1e-9), edges)[0] / max(len(values), 1)
        dashes = STYLES[name]["linestyle"]
        histogram.stairs(counts, edges, label=title, color=color, linewidth=1.6, linestyle=dashes, fill=False)
        if name == styles[0]:
            histogram.stairs(counts, edges, color=color, alpha=0.18, fill=True)
    curve.axhline(CLOSE, color="0.35", linewidth=0.8)
    curve.text(1.005, CLOSE, f"{100 * CLOSE:.0f} %", transform=curve.get_yaxis_transform(), va="center", fontsize=8)
    curve.set(
        xlabel="correspondence, in order of confidence", ylabel="error per diameter", xlim=(0, None), ylim=(0, None)
    )
    curve.set_title("Mean and median over the pairs", parse_math=False)
    curve.set_ylim(0, 1.15 * curve.get_ylim()[1] + 0.01)  # space for the legend
    curve.legend(loc="upper left", ncols=len(panels))
    histogram.set(xlabel="error per diameter (last bar: and above)", ylabel="share of matches", xlim=(0, 0.25))
    histogram.set_title("Distribution of the errors", parse_math=False)
    histogram.legend()
    return figure


def curves(
    panels: dict[str, Sequence[Line]], x: np.ndarray, x_label: str, y_label: str, top: float | None = None
) -> Figure:
    """Curves over the same ``x``, with one panel for each title, side by side at the same scale."""
    figure, all_axes = _new(WIDTH if len(panels) > 1 else 7, 4.2, len(panels))
    highest = [float(np.nanmax(line.values)) for lines in panels.values() for line in lines if len(line.values)]
    limit = top if top is not None else 1.06 * max([h for h in highest if h == h], default=0) or 1.0
    for axes, (title, lines) in zip(all_axes, panels.items(), strict=True):
        for k, line in enumerate(lines):
            every = (2 * k, max(len(x) // 10, 1))  # markers of equal lines are side by side
            axes.plot(x, line.values, label=label(line.label), markevery=every, markersize=4.5, **line.style)
        axes.set(xlim=(float(x[0]), float(x[-1])), ylim=(0, limit), xlabel=x_label, ylabel=y_label)
        axes.set_title(label(title), parse_math=False)
        if lines:
            for text in axes.legend(loc="best").get_texts():
                text.set_parse_math(False)
    return figure


def calibration(bins: np.ndarray, counts: np.ndarray, shares: dict[str, np.ndarray]) -> Figure:
    """Share of accurate matches in each bin of confidence, and number of matches in each bin."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(5.4, 4.2), layout="constrained")
    upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=(3, 1))
    middles = (bins[1:] + bins[:-1]) / 2
    for k, (name, values) in enumerate(shares.items()):
        shift = 0.008 * (k - (len(shares) - 1) / 2)
        title = {"better": "better of both"}.get(name, name)
        upper.plot(middles + shift, values, **STYLES[name], markersize=6, linewidth=1.2, label=title)
    upper.set(ylim=(-0.03, 1.03), xlim=(0, 1), ylabel=f"share within {100 * NEAR:.0f} %\nof the diameter")
    if len(shares) > 1:
        upper.legend(loc="lower right")
    lower.bar(middles, counts, np.diff(bins) * 0.9, color="#9aa4b2", edgecolor="#566172", linewidth=0.6)
    lower.set(xlabel="confidence", ylabel="matches")
    lower.set_xticks(bins)
    return figure
