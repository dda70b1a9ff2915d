"""Work on two meshes at once: the same results, told from the calling thread, errors as they come."""

import threading

import numpy as np
import pytest

import mobius_match as mm
from mobius_match._core.threads import map_threads
from tests.shapes import lump, tube


@pytest.mark.parametrize("jobs", [1, 2, None])
def test_results_in_order_and_progress_from_the_calling_thread(jobs):
    told, here = [], threading.get_ident()

    def work(i, tell):
        for done in range(3):
            tell(f"work {i}", done, 3)
        return i**2

    def note(*event):
        assert threading.get_ident() == here
        told.append(event)

    assert map_threads(work, 4, jobs, note) == [0, 1, 4, 9]
    for i in range(4):
        assert [event for event in told if event[0] == f"work {i}"] == [(f"work {i}", done, 3) for done in range(3)]


@pytest.mark.parametrize("jobs", [1, 2])
def test_the_first_error_is_raised(jobs):
    def work(i, tell):
        raise ValueError(f"number {i}")

    with pytest.raises(ValueError, match="number 0"):
        map_threads(work, 2, jobs, None)


def test_an_interruption_ends_the_other_threads():
    begun, stopped = threading.Event(), threading.Event()

    def work(i, tell):
        try:
            begun.set()
            for _ in range(10**7):
                tell("working", 0, 1)
        except BaseException:
            stopped.set()
            raise

    def interrupt(*event):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        map_threads(work, 2, 2, interrupt)
    assert begun.is_set()
    assert stopped.is_set()


def test_threads_change_no_bit():
    first, second = (mm.match(lump(3), tube(), samples=30, jobs=jobs, threshold=0.0) for jobs in (1, 2))
    for name in ("positions", "distances", "eigenfunctions", "curvatures"):
        for side in ("source", "target"):
            np.testing.assert_array_equal(getattr(getattr(first, side), name), getattr(getattr(second, side), name))
    np.testing.assert_array_equal(first.confidence, second.confidence)
