"""Jobs in processes of their own: one that dies takes no other with it, and none outlives the program."""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import signal
import threading
from collections import deque
from collections.abc import Callable, Hashable, Iterator, Mapping
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from typing import Any


class Died:
    """Stands for the result of a job whose process ended without one."""


def in_processes(
    work: Callable[..., Any], jobs: Mapping[Hashable, tuple[Any, ...]], processes: int
) -> Iterator[tuple[Hashable, Any]]:
    """Call ``work`` with each job's arguments, and give its key and result, in the order in which they end.

    A job whose process dies (no memory left, a crash in a library) gives ``Died``. If the caller stops or is
    interrupted, the processes are ended.
    """
    waiting = deque(jobs)
    while waiting:
        running: dict[Future[Any], Hashable] = {}
        before = set(multiprocessing.active_children())
        pool = ProcessPoolExecutor(processes, multiprocessing.get_context("spawn"), _begin)
        try:
            while waiting or running:
                while waiting and len(running) < processes:
                    with _uninterrupted():
                        future = pool.submit(work, *jobs[waiting[0]])
                    running[future] = waiting.popleft()
                for future in wait(running, return_when=FIRST_COMPLETED).done:
                    result = future.result()
                    yield running.pop(future), result
        except BrokenProcessPool:
            suspects = list(running.values())
            if len(suspects) == 1:
                yield suspects[0], Died
            else:  # whose process it was is not told: each again, alone
                yield from in_processes(work, {key: jobs[key] for key in suspects}, 1)
        except BaseException:
            for process in set(multiprocessing.active_children()) - before:
                process.kill()
            raise
        finally:
            pool.shutdown(wait=True, cancel_futures=True)


@contextlib.contextmanager
def _uninterrupted() -> Iterator[None]:
    """Processes started in here never see Ctrl-C, which a terminal sends to all; the caller gets it afterwards."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _begin() -> None:
    """First thing in a process."""
    from threadpoolctl import threadpool_limits

    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()
    threadpool_limits(limits=1)  # the processes are the parallel part


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
