"""Record everything that matching gives, to see whether a change of the code changed any result.

    python benchmarks/record.py DATA -o before.npz            # with the old code
    python benchmarks/record.py DATA --compare before.npz     # with the new code

DATA is the folder of the evaluation sets. Forty pairs over all sets whose meshes are accepted, two cut shapes, a match
with landmarks, a match with the paper's settings and two symmetries: matches, confidences, kinds, target points,
warnings' number, alternatives and dense maps. The comparison names each array that differs, with the fraction of its
rows that do, and ends with 1 if any does.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from changes import cut

import mobius_match as mm

PAIRS = {
    "tosca": """cat0 cat6, cat1 cat2, dog0 dog1, wolf0 wolf1, horse0 horse7, centaur0 centaur2, michael0 michael2""",
    "tosca_nonisometric": """8_gorilla_01 8_man_01, 8_gorilla_01 8_man_03, 8_man_06 8_gorilla_03,
        8_woman_04 8_gorilla_01""",
    "faust": """tr_reg_000 tr_reg_001, tr_reg_000 tr_reg_004, tr_reg_010 tr_reg_012, tr_reg_005 tr_reg_017""",
    "tosca_original": """cat0 cat6""",
    "shrec07_fourleg": """381 385, 385 389, 389 392""",
    "smal": """Davis_cow_00000 lion6, Hippo_for_Nat muybridge_014_01, cougar cow_alph4, fox-06 dog2,
        wolf_alph2 hippo5""",
    "shrec19_raw": """human_01 human_18, human_01 human_26""",
    "deformation_transfer": """crane_0000 crane_0085, lion_001 lion_005, elephant_001 elephant_006, cow_001 cow_004,
        crane_0051 crane_0068""",
    "knee_bones": """femur_001 femur_004, femur_002 femur_003, femur_003 femur_001""",
    "cat_lion": """cat_0001 lion_001, cat_0003 lion_003, cat_0004 lion_001""",
    "teeth": """P32 b19, U07 j18""",
    "handles": """bumpy_round_cube_a bumpy_round_cube_b""",
}
CUTS = (("cat0-cat6", (0.0, -1.0, 0.0), 0.0), ("michael0-michael2", (0.0, 0.0, 1.0), 0.0))
"""Pairs of `tosca` whose source is cut: the side of the plane that is kept, and where it is."""

ARRAYS = ("pairs", "confidence", "kind")


def fields_of(name: str, matches: Any) -> Iterator[tuple[str, np.ndarray]]:
    """The arrays of a list of matches."""
    for field in ARRAYS:
        yield f"{name}/{field}", getattr(matches, field)
    if matches.target_points is not None:
        yield f"{name}/faces", matches.target_points.faces
        yield f"{name}/barycentric", matches.target_points.barycentric


def arrays_of(source: Any, target: Any, **options: Any) -> Iterator[tuple[str, np.ndarray]]:
    """All arrays that a match gives, or the name of the error that refuses it."""
    try:
        result = mm.match(source, target, **options)
    except mm.MobiusError as error:
        yield "refused", np.array(type(error).__name__)
        return
    yield from fields_of("matches", result)
    yield "warnings", np.array(len(result.warnings))
    if result.given is not None:
        yield "given", result.given
    for number, other in enumerate(result.alternatives):
        yield from fields_of(f"alternative {number}", other)
        yield f"alternative {number}/margin", np.array([other.margin, other.share])
    yield from dense_arrays(result.dense())


def dense_arrays(dense: mm.SurfaceMap) -> Iterator[tuple[str, np.ndarray]]:
    """Both ways of a dense map."""
    for way, one in (("forward", dense), ("backward", dense.inverse)):
        yield f"dense {way}/vertices", one.vertex_map
        yield f"dense {way}/positions", one.positions


def tasks(data: Path) -> Iterator[tuple[str, Any]]:
    """Name of each task, and a function that gives its arrays."""
    named = [(kind, *pair.split()) for kind, pairs in PAIRS.items() for pair in pairs.split(",")]
    pairs = [(kind, data / kind / f"{a}.off", data / kind / f"{b}.off") for kind, a, b in named]
    for kind, a, b in pairs:
        yield f"{kind} {a.stem} {b.stem}", lambda a=a, b=b: arrays_of(a, b)
    for pair, side, place in CUTS:
        a, b = (data / "tosca" / f"{name}.off" for name in pair.split("-"))
        yield f"cut {pair}", lambda a=a, b=b, side=side, place=place: arrays_of(cut_file(a, side, place), b)
    cats = [data / "tosca" / f"cat{i}.off" for i in (1, 2)]
    known = np.stack([np.loadtxt(data / f"tosca/corres/{one.stem}.vts", int)[:3000:1000] - 1 for one in cats], axis=1)
    yield "landmarks", lambda: arrays_of(*cats, landmarks=known)
    yield "paper", lambda: arrays_of(*cats, preset="paper", votes=200_000)
    for name in ("cat0", "michael2"):
        yield f"symmetry {name}", lambda name=name: symmetry_of(data / "tosca" / f"{name}.off")


def cut_file(path: Path, side: tuple[float, float, float], place: float) -> tuple[np.ndarray, np.ndarray]:
    """Vertices and faces of one side of a plane."""
    mesh = mm.read_mesh(path)
    vertices, faces, _ = cut(mesh.vertices, mesh.faces, np.array(side), place)
    return vertices, faces


def symmetry_of(path: Path) -> Iterator[tuple[str, np.ndarray]]:
    """The intrinsic symmetry of one shape."""
    found = mm.symmetry(path)
    for field in ("pairs", "confidence", "stationary", "score"):
        yield field, np.asarray(getattr(found, field))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data", type=Path)
    parser.add_argument("-o", "--output", type=Path)
    parser.add_argument("--compare", type=Path)
    parser.add_argument("--only", default="", help="tasks whose name holds this text")
    args = parser.parse_args()
    if bool(args.output) == bool(args.compare):
        parser.error("give either --output or --compare")
    before = dict(np.load(args.compare)) if args.compare else {}
    found: dict[str, np.ndarray] = {}
    for name, run in tasks(args.data):
        if args.only not in name:
            continue
        mine = {f"{name}/{field}": np.asarray(values) for field, values in run()}
        found |= mine
        if args.compare:
            theirs = {field: values for field, values in before.items() if field.startswith(f"{name}/")}
            differing = list(differences(theirs, mine))
            print(f"{name}: {'same' if not differing else '; '.join(differing)}", flush=True)
        else:
            print(f"{name}: {len(mine)} arrays", flush=True)
    if args.output:
        with tempfile.NamedTemporaryFile(dir=args.output.parent, suffix=".npz", delete=False) as file:
            np.savez_compressed(file, **found)
        Path(file.name).replace(args.output)
        return
    before = {name: values for name, values in before.items() if args.only in name.split("/")[0]}
    sys.exit(any(True for _ in differences(before, found)))


def differences(before: dict[str, np.ndarray], after: dict[str, np.ndarray]) -> Iterator[str]:
    """A line for each array that is not the same, byte for byte."""
    for name in sorted(before.keys() | after.keys()):
        if name not in before or name not in after:
            yield f"{name} only {'before' if name in before else 'after'}"
            continue
        old, new = before[name], after[name]
        if old.shape != new.shape:
            yield f"{name} has shape {old.shape} before and {new.shape} after"
        elif old.tobytes() != new.tobytes():
            unequal = (old != new).reshape(len(old), -1).any(axis=1) if old.ndim else np.array([True])
            apart = f", by {np.nanmax(np.abs(old - new)):.2g} at most" if old.dtype.kind == "f" else ""
            yield f"{name} differs in {unequal.mean():.1%} of its rows{apart}"


if __name__ == "__main__":
    main()
