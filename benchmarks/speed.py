"""Seconds and memory of one match of the shipped person, from files to JSON, and what the cache spares.

    python benchmarks/speed.py [SOURCE TARGET]

In the first two tables the process is warm: everything is compiled and imported. The last table times whole commands.
The cache is one of its own, empty at first.
"""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import mobius_match as mm
from mobius_match.evaluation import examples

REPEATS = 3


def main() -> None:
    pair = [Path(name) for name in sys.argv[1:3]] or list(examples.paths("person"))
    with tempfile.TemporaryDirectory() as folder:
        os.environ["MOBIUS_CACHE_DIR"] = f"{folder}/cache"
        output = Path(folder) / "result.json"
        stages(pair, output)
        print()
        loading(pair[0])
        print()
        commands(pair, output)


def stages(pair: list[Path], output: Path) -> None:
    """A match without and with the cache, in this process."""
    for cache, name in ((False, "prepared anew"), (True, "cached")):
        runs = []
        for _ in range(1 + REPEATS):
            start = time.perf_counter()
            result = mm.match(*pair, cache=cache)
            result.save(output)
            runs.append((time.perf_counter() - start, result.timings))
        seconds, timings = min(runs[1:], key=lambda run: run[0])
        for stage, part in timings.items():
            print(f"{stage:32} {part:7.3f} s")
        line("files to JSON, " + name, seconds, f"best of {REPEATS}, the first took {runs[0][0]:.3f} s")
    print(f"{'peak memory':32} {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024:7.0f} MB")


def loading(path: Path) -> None:
    """One mesh prepared, against the same from the cache: its bytes hashed, and the surface loaded."""
    mm.prepare(path, cache=True)
    preparing = best(lambda: mm.prepare(path))
    from_cache = best(lambda: mm.prepare(path, cache=True))
    line(f"preparing {path.name}", preparing)
    line("from the cache", from_cache, f"1/{preparing / from_cache:.0f} of preparing")


def commands(pair: list[Path], output: Path) -> None:
    """Whole commands, the second match with all that the first one kept."""
    mobius = [sys.executable, "-m", "mobius_match"]
    match = [*mobius, "match", *map(str, pair), "-o", str(output), "--quiet"]
    fresh = 0.0
    for name, command in {
        "mobius --help": [*mobius, "--help"],
        "mobius match --no-cache": [*match, "--no-cache"],
        "mobius match, cached": match,
    }.items():
        seconds = best(lambda command=command: subprocess.run(command, check=True, capture_output=True))
        note = f", 1/{fresh / seconds:.1f} of without" if command is match else ""
        line(name, seconds, f"best of {REPEATS}{note}")
        fresh = seconds


def best(work: Callable[[], object]) -> float:
    """Least of the seconds that some runs take."""
    least = float("inf")
    for _ in range(REPEATS):
        start = time.perf_counter()
        work()
        least = min(least, time.perf_counter() - start)
    return least


def line(name: str, seconds: float, note: str = "") -> None:
    """One row of a table."""
    print(f"{name:32} {seconds:7.3f} s{f' ({note})' if note else ''}")


if __name__ == "__main__":
    main()
