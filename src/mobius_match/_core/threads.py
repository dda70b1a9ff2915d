"""Work divided among threads; results do not depend on their number."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable
from concurrent.futures import CancelledError, ThreadPoolExecutor
from queue import SimpleQueue
from typing import Any, TypeVar

from threadpoolctl import threadpool_limits

Result = TypeVar("Result")

Progress = Callable[[str, int, int], None]
"""Called with the name of a stage, the amount done, and the total."""


def map_threads(
    work: Callable[[int, Progress], Result], number: int, jobs: int | None, progress: Progress | None
) -> list[Result]:
    """Results of ``work(0, progress), work(1, progress), ...`` in this order, computed in several threads.

    Parameters
    ----------
    work
        Takes the number of a piece of work and a function to report progress to.
    jobs
        Threads; None for every processor.
    progress
        Called in the calling thread only.
    """
    report = progress or (lambda stage, done, total: None)
    if min(jobs or os.cpu_count() or 1, number) == 1:
        return [work(i, report) for i in range(number)]
    events: SimpleQueue[tuple[str, int, int] | None] = SimpleQueue()
    ended = threading.Event()

    def note(*event: Any) -> None:
        if ended.is_set():
            raise CancelledError
        events.put(event)

    def run(i: int) -> Result:
        try:
            return work(i, note)
        finally:
            events.put(None)

    # The limit of BLAS threads is global: set here, no thread lifts it while another works.
    with threadpool_limits(limits=1, user_api="blas"), ThreadPoolExecutor(jobs) as pool:
        try:
            running = [pool.submit(run, i) for i in range(number)]
            for _ in running:
                while (event := events.get()) is not None:
                    report(*event)
            return [future.result() for future in running]
        finally:
            ended.set()
