"""What all tests share."""

import pytest
from hypothesis import settings

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
