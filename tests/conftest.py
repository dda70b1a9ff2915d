"""What all tests share."""

from hypothesis import settings

# The first example may compile a kernel, so time says nothing. The same examples every time, so that a
# failure can be looked at.
settings.register_profile("project", deadline=None, derandomize=True)
settings.load_profile("project")
