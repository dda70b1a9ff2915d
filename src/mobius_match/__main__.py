"""``python -m mobius_match`` is the command ``mobius``."""

from .cli import main

main()
