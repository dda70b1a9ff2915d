"""``mobius cache``."""

from __future__ import annotations

from typing import Annotated

from typer import Option

from .options import Verbose
from .output import STDOUT, to_json, write


def cache(
    clear: Annotated[bool, Option("--clear", help="Delete all cached surfaces.")] = False,
    json: Annotated[bool, Option("--json", help="Print JSON.")] = False,
    verbose: Verbose = False,
) -> None:
    """Show the folder, number and size of the cached surfaces.

    'mobius match' and other commands store each prepared surface there, so that a mesh is prepared only once. When
    the cache exceeds its limit, the surfaces not used for longest are deleted. The environment variables
    MOBIUS_CACHE_DIR and MOBIUS_CACHE_MB set the folder and the limit in megabytes.
    """
    from ..surface.cache import cache_folder, cache_limit, cached_files, clear_cache

    folder, limit = cache_folder().absolute(), cache_limit()
    if clear:
        clear_cache()
    sizes = [stat.st_size for _, stat in cached_files(folder)]
    if json:
        write(STDOUT, to_json({"folder": str(folder), "surfaces": len(sizes), "bytes": sum(sizes), "limit": limit}))
    else:
        write(STDOUT, f"{folder}: {_count(len(sizes))}, {sum(sizes) / 1e6:.1f} of {limit / 1e6:.0f} MB\n".encode())


def _count(number: int) -> str:
    return f"{number} prepared surface{'s' if number != 1 else ''}"
