"""``mobius cache``."""

from __future__ import annotations

from typing import Annotated

from typer import Option

from .match import Verbose
from .output import STDOUT, to_json, write


def cache(
    clear: Annotated[bool, Option("--clear", help="Delete the prepared surfaces that are kept.")] = False,
    json: Annotated[bool, Option("--json", help="Print JSON.")] = False,
    verbose: Verbose = False,
) -> None:
    """Show where prepared surfaces are kept, how many, and how large they are.

    'mobius match' and others keep what they prepared there, and need not prepare a mesh twice. What was not
    used for longest is deleted first when it gets too large. The environment variables MOBIUS_CACHE_DIR and
    MOBIUS_CACHE_MB name another folder, and how many megabytes it may have.
    """
    from ..surface.cache import cache_folder, cache_limit, cached_files, clear_cache

    folder, limit = cache_folder().absolute(), cache_limit()
    if clear:
        clear_cache()
    sizes = [stat.st_size for _, stat in cached_files(folder)]
    if json:
        found = {"folder": str(folder), "surfaces": len(sizes), "bytes": sum(sizes), "limit": limit}
        write(STDOUT, to_json(found))
    else:
        write(STDOUT, f"{folder}: {_count(len(sizes))}, {sum(sizes) / 1e6:.1f} of {limit / 1e6:.0f} MB\n".encode())


def _count(number: int) -> str:
    return f"{number} prepared surface{'s' if number != 1 else ''}"
