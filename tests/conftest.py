"""What all tests share."""

from functools import cache

import pytest
from hypothesis import settings

import mobius_match as mm
from mobius_match.evaluation import examples
from tests.shapes import lump

# The first example may compile a kernel, so time says nothing. The same examples every time, so that a
# failure can be looked at.
settings.register_profile("project", deadline=None, derandomize=True)
settings.load_profile("project")


@pytest.fixture(autouse=True)
def cache_folder(monkeypatch, tmp_path_factory, request):
    """An empty cache of prepared surfaces for each test, also in the processes that it starts."""
    folder = tmp_path_factory.getbasetemp() / "caches" / f"{abs(hash(request.node.nodeid))}"
    monkeypatch.setenv("MOBIUS_CACHE_DIR", str(folder))
    return folder


# Surfaces and results are frozen, so that tests may share them: a shape is prepared, and a pair matched, once a run.


@pytest.fixture(scope="session")
def lump_surface():
    """A prepared surface without any symmetry."""
    return mm.prepare(lump(4))


@pytest.fixture(scope="session")
def shipped():
    """A function: the two prepared surfaces of a shipped pair, by its name."""
    return cache(lambda name: tuple(mm.prepare(path) for path in examples.paths(name)))


@pytest.fixture(scope="session")
def shipped_match(shipped):
    """A function: the match of a shipped pair with the default settings, by the pair's name and the seed."""
    return cache(lambda name, seed=0: mm.match(*shipped(name), seed=seed))


@pytest.fixture(scope="session")
def shipped_dense(shipped_match):
    """A function: the dense map of that match, by the pair's name."""
    return cache(lambda name: shipped_match(name).dense())


@pytest.fixture(scope="session")
def person(shipped):
    """The two prepared poses of the shipped person."""
    return shipped("person")


@pytest.fixture(scope="session")
def quadruped(shipped):
    """The two prepared poses of the shipped quadruped."""
    return shipped("quadruped")
