"""Work shared between threads, whose results do not depend on how many there are."""

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
"""Called with the name of a stage, how much of it is done, and how much there is."""


def map_threads(
    work: Callable[[int, Progress], Result], number: int, jobs: int | None, progress: Progress | None
) -> list[Result]:
    """Results of ``work(0, tell), work(1, tell), ...`` in this order, worked out in as many threads as there may be.

    Parameters
    ----------
    work
        Given the number of a piece of work and what to tell progress to.
    jobs
        Threads; None for every processor.
    progress
        Called from the calling thread, whatever thread the news come from.
    """
    tell = progress or (lambda stage, done, total: None)
    if min(jobs or os.cpu_count() or 1, number) == 1:
        return [work(i, tell) for i in range(number)]
    news: SimpleQueue[tuple[str, int, int] | None] = SimpleQueue()
    ended = threading.Event()

    def note(*event: Any) -> None:
        if ended.is_set():
            raise CancelledError
        news.put(event)

    def run(i: int) -> Result:
        try:
            return work(i, note)
        finally:
            news.put(None)

    # The limit of BLAS threads is everyone's: set here, no thread lifts it while another works.
    with threadpool_limits(limits=1, user_api="blas"), ThreadPoolExecutor(jobs) as pool:
        try:
            running = [pool.submit(run, i) for i in range(number)]
            for _ in running:
                while (event := news.get()) is not None:
                    tell(*event)
            return [one.result() for one in running]
        finally:
            ended.set()
