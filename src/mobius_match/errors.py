"""The one family of errors that users meet; every message says what is wrong, where, and what to do."""

from __future__ import annotations


class MobiusError(ValueError):
    """Root of the family: catch this to catch everything the package raises on purpose."""


class MeshError(MobiusError):
    """A mesh that cannot be used (the command line exits with 3)."""


class FormatError(MeshError):
    """A mesh file that is unreadable, truncated or of an unknown kind (exit code 3)."""


class TopologyError(MeshError):
    """A surface of the wrong shape: non-manifold, with handles, in several pieces (exit code 3)."""


class SettingsError(MobiusError):
    """A setting outside its range, or settings that exclude each other (exit code 2)."""


class NothingFoundError(MobiusError):
    """The search ended without a correspondence (exit code 4)."""


class MissingPackageError(MobiusError, ImportError):
    """A package that is optional, needed for what was asked, and not installed."""
