"""Jobs in separate processes: one that crashes does not affect the others, and none outlives the program."""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import signal
import threading
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from typing import Any


class Died:
    """The result of a job whose process ended without one."""


DIED = "its process was killed, most likely for lack of memory; fewer `jobs` need less"


class Workers:
    """A pool of processes; a context manager, which ends them if the work is interrupted."""

    def __init__(self, processes: int) -> None:
        self.processes = processes

    def __enter__(self) -> Workers:
        self._others = set(multiprocessing.active_children())
        self._pool = self._fresh(self.processes)
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        if kind is not None:
            for process in set(multiprocessing.active_children()) - self._others:
                process.kill()
        self._pool.shutdown(wait=True, cancel_futures=True)

    def results(self, work: Callable[..., Any], jobs: Mapping[str, tuple[Any, ...]]) -> Iterator[tuple[str, Any]]:
        """Call ``work`` with each job's arguments; yield each job's name and result, in the order in which they end.

        A job whose process dies (no memory left, a crash in a library) has the result ``Died``.
        """
        waiting, suspects = deque(jobs), deque[str]()
        while waiting or suspects:
            # It is not known which job's process died: each job that was running is tried again, alone.
            queue, most = (suspects, 1) if suspects else (waiting, self.processes)
            running: dict[Future[Any], str] = {}
            try:
                while queue or running:
                    while queue and len(running) < most:
                        with _uninterrupted():
                            future = self._pool.submit(work, *jobs[queue[0]])
                        running[future] = queue.popleft()
                    for future in wait(running, return_when=FIRST_COMPLETED).done:
                        result = future.result()
                        yield running.pop(future), result
            except BrokenProcessPool:
                self._pool.shutdown()
                self._pool = self._fresh(self.processes)
                if len(running) == 1:
                    yield running.popitem()[1], Died
                suspects.extend(running.values())

    @staticmethod
    def _fresh(processes: int) -> ProcessPoolExecutor:
        return ProcessPoolExecutor(processes, multiprocessing.get_context("spawn"), _begin)


@contextlib.contextmanager
def _uninterrupted() -> Iterator[None]:
    """Delay signals while a process is started, and keep Ctrl-C, which a terminal sends to all, from new processes.

    The caller gets the signal afterwards.
    """
    if threading.current_thread() is not threading.main_thread():  # where Python handles signals
        yield
        return
    received: list[int] = []
    both = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    handlers = {number: handler for number, handler in both.items() if handler is not None}  # None: not Python's
    for number in handlers:
        signal.signal(number, lambda which, _: received.append(which))
    if hasattr(signal, "pthread_sigmask"):  # processes inherit it
        mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        if hasattr(signal, "pthread_sigmask"):
            signal.pthread_sigmask(signal.SIG_SETMASK, mask)
        for number, handler in handlers.items():
            signal.signal(number, handler)
        if received:
            signal.raise_signal(received[0])


def _begin() -> None:
    """Initialise a process."""
    from threadpoolctl import threadpool_limits

    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()
    threadpool_limits(limits=1)  # the processes are the parallel part


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
