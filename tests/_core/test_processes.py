"""Jobs in processes of their own."""

import multiprocessing
import os
import time

import pytest

from mobius_match._core.processes import Died, Workers


def die_of_three(number):
    if number == 3:
        os._exit(1)
    return number * number


@pytest.mark.parametrize("processes", [1, 3])
def test_a_process_that_dies_takes_no_other_job_with_it(processes):
    with Workers(processes) as workers:
        found = dict(workers.results(die_of_three, {str(i): (i,) for i in range(8)}))
        assert found == {str(i): Died if i == 3 else i * i for i in range(8)}
        assert dict(workers.results(pow, {"again": (2, 5)})) == {"again": 32}


def test_an_error_in_a_job_is_raised():
    with pytest.raises(TypeError), Workers(1) as workers:
        list(workers.results(pow, {"bad": ("two", 5)}))


def test_processes_end_when_the_work_is_interrupted():
    before = set(multiprocessing.active_children())
    with pytest.raises(KeyboardInterrupt), Workers(2) as workers:
        for _ in workers.results(time.sleep, {"short": (0,), "long": (600,)}):
            assert len(set(multiprocessing.active_children()) - before) == 2
            raise KeyboardInterrupt
    assert set(multiprocessing.active_children()) == before
