"""Seconds that stages take."""

from __future__ import annotations

import time
from collections.abc import Mapping


class Stopwatch:
    """The durations of stages that follow each other, by name."""

    def __init__(self) -> None:
        self._start = self._last = time.perf_counter()
        self.laps: dict[str, float] = {}

    def lap(self, stage: str) -> None:
        """Say which stage ends now; it began when the last one ended. Durations of one name are added up."""
        now = time.perf_counter()
        self.laps[stage] = self.laps.get(stage, 0.0) + now - self._last
        self._last = now

    def add(self, timings: Mapping[str, float]) -> None:
        """Durations of parts of the stage that is under way."""
        self.laps |= timings

    def with_total(self) -> dict[str, float]:
        """All durations, and the total since the start."""
        return {**self.laps, "total": time.perf_counter() - self._start}
