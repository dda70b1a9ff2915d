"""Seconds and memory of one match of the shipped person, from files to JSON.

    python benchmarks/speed.py [SOURCE TARGET]

The process is warm in the first table: everything is compiled and imported. The second table times whole commands.
"""

from __future__ import annotations

import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import mobius_match as mm
from mobius_match import examples


def main() -> None:
    pair = [Path(name) for name in sys.argv[1:3]] or list(examples.paths("person"))
    with tempfile.TemporaryDirectory() as folder:
        output = Path(folder) / "result.json"
        runs = []
        for _ in range(4):
            start = time.perf_counter()
            result = mm.match(*pair)
            result.save(output)
            runs.append((time.perf_counter() - start, result.timings))
        seconds, timings = min(runs[1:], key=lambda run: run[0])
        for name, part in timings.items():
            print(f"{name:24} {part:7.3f} s")
        print(f"{'files to JSON, warm':24} {seconds:7.3f} s (best of 3; first in this process {runs[0][0]:.3f} s)")
        print(f"{'peak memory':24} {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024:7.0f} MB")
        mobius = [sys.executable, "-m", "mobius_match"]
        for name, command in {
            "mobius --help": [*mobius, "--help"],
            "mobius match": [*mobius, "match", *map(str, pair), "-o", str(output), "--quiet"],
        }.items():
            best = 1e9
            for _ in range(3):
                start = time.perf_counter()
                subprocess.run(command, check=True, capture_output=True)
                best = min(best, time.perf_counter() - start)
            print(f"{name:24} {best:7.3f} s (whole command, best of 3)")


if __name__ == "__main__":
    main()
