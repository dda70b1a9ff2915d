"""The family of errors: who catches what."""

import pytest

from mobius_match import errors


@pytest.mark.parametrize(
    ("child", "parents"),
    [
        (errors.FormatError, (errors.MeshError, errors.MobiusError, ValueError)),
        (errors.TopologyError, (errors.MeshError, errors.MobiusError, ValueError)),
        (errors.SettingsError, (errors.MobiusError, ValueError)),
        (errors.NothingFoundError, (errors.MobiusError, ValueError)),
    ],
)
def test_family(child, parents):
    assert all(issubclass(child, parent) for parent in parents)
    assert issubclass(child, errors.MeshError) == (errors.MeshError in parents)
    assert str(child("what went wrong")) == "what went wrong"
