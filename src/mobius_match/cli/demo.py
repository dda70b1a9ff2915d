"""``mobius demo``: match the example meshes and measure the errors."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from .common import Reporter, say
from .match import run_match
from .options import Quiet, Verbose
from .output import ROWS, STDOUT, make_folder, number_omitted, print_table, to_json, write
from .results import draw

if TYPE_CHECKING:
    import numpy as np
    from rich.table import Table

    from ..results.correspondence import Correspondence


def demo(
    output: Annotated[
        Path, typer.Option("--output", "-o", metavar="DIR", help="Folder for results, pictures, tables and pages.")
    ] = Path("mobius-demo"),
    json: Annotated[bool, typer.Option("--json", help="Print the figures as JSON instead of tables.")] = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:
    """Match the example meshes that come with the program, and measure the errors against the known correspondence.

    The error of a match is the geodesic distance on the target from the matched vertex to the true point, as
    a fraction of the target's diameter.
    """
    from ..evaluation import examples
    from ..viewer import page

    make_folder(output)
    report = []
    with Reporter(quiet) as reporter:
        for name in examples.names():
            source, target = examples.paths(name)
            reporter.notes([f"{name}: {source.name} to {target.name} ..."])
            result = run_match(source, target, reporter, {})
            entry = {"pair": name, **measure(result, *examples.truth(name))}
            write(output / f"{name}.json", to_json(result.to_dict()))
            write(output / f"{name}.csv", _csv(entry["matches"]))
            write(output / f"{name}.png", draw(result))
            write(output / f"{name}.html", page(result, dense=result.dense()).encode())
            report.append(entry)
    if json:
        write(STDOUT, to_json(report))
    else:
        for entry in report:
            print_table(_match_table(entry))
        print_table(_summary_table(report, reporter.compiled))
    if not quiet:
        say(f"Results (.json), tables (.csv), pictures (.png) and interactive pages (.html) are in {output.resolve()}")


def measure(result: Correspondence, true_faces: np.ndarray, true_weights: np.ndarray) -> dict[str, Any]:
    """Geodesic errors of a match, as fractions of the geodesic diameter of the target.

    Parameters
    ----------
    result
        A match of two files.
    true_faces, true_weights
        (n,) int and (n, 3) float: face and barycentric coordinates on the target of each source vertex.
    """
    import numpy as np

    from ..geometry.geodesics import geodesic_solver
    from ..mesh import read_mesh

    target = read_mesh(result.target_info["path"])
    distances = geodesic_solver(target.vertices, target.faces)
    corners, weights = target.faces[true_faces[result.pairs[:, 0]]], true_weights[result.pairs[:, 0]]
    errors = np.array(
        [weight @ distances(j)[corner] for (_, j), corner, weight in zip(result.pairs, corners, weights, strict=True)]
    )
    errors /= result.target_info["diameter"]
    matches = zip(result.pairs.tolist(), result.confidence.tolist(), result.kind.tolist(), errors.tolist(), strict=True)
    return {
        "correspondences": len(result),
        "mean_error_first_15": float(errors[:15].mean()),
        "mean_error_first_45": float(errors[:45].mean()),
        "within_3_percent": float((errors <= 0.03).mean()),
        "within_5_percent": float((errors <= 0.05).mean()),
        "seconds": result.timings["total"],
        "matches": [
            {"source": i, "target": j, "confidence": confidence, "kind": str(kind), "error": error}
            for (i, j), confidence, kind, error in matches
        ],
    }


def _csv(rows: list[dict[str, Any]]) -> bytes:
    lines = [list(rows[0]), *(row.values() for row in rows)]
    return "".join(",".join(map(str, line)) + "\n" for line in lines).encode()


def _match_table(entry: dict[str, Any]) -> Table:
    from rich.table import Table

    omitted = number_omitted(len(entry["matches"]))
    caption = omitted and f"{omitted} in {entry['pair']}.csv"
    title = f"{entry['pair']}: matches and their errors"
    table = Table(title=title, caption=caption, title_justify="left", caption_justify="left")
    for heading in ("", "source vertex", "target vertex", "confidence", "error (% of diameter)"):
        table.add_column(heading, justify="right")
    for number, row in enumerate(entry["matches"][:ROWS], start=1):
        table.add_row(
            *map(str, (number, row["source"], row["target"])), f"{row['confidence']:.3f}", _percent(row["error"])
        )
    return table


def _summary_table(report: list[dict[str, Any]], compiled: bool) -> Table:
    from rich.table import Table

    table = Table(title="Errors, % of the target's diameter", title_justify="left")
    for heading in (
        "pair",
        "matches",
        "mean of\nfirst 15",
        "mean of\nfirst 45",
        "within 3 %",
        "within 5 %",
        "seconds\n(with\ncompiling)" if compiled else "seconds",
    ):
        table.add_column(heading, justify="left" if heading == "pair" else "right")
    for entry in report:
        errors = (_percent(entry[f"mean_error_first_{n}"]) for n in (15, 45))
        shares = (f"{100 * entry[f'within_{n}_percent']:.0f} %" for n in (3, 5))
        table.add_row(entry["pair"], str(entry["correspondences"]), *errors, *shares, f"{entry['seconds']:.1f}")
    return table


def _percent(fraction: float) -> str:
    return f"{100 * fraction:.1f}"
