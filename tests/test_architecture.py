"""The layout of the package: no circle of imports, few entries at the top, short files."""

import ast
from pathlib import Path

import mobius_match

SOURCE = Path(mobius_match.__file__).parent
LONGEST = 320
"""Lines of a file, at most."""
MOST_ENTRIES = 20
"""Files and folders at the top of the package, at most."""


def name_of(path):
    parts = path.relative_to(SOURCE.parent).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


MODULES = {name_of(path): path for path in sorted(SOURCE.rglob("*.py"))}


def imports_of(name):
    """Modules of the package that a module imports, wherever the import stands: in functions and for types as well."""
    path = MODULES[name]
    package = name if path.name == "__init__.py" else name.rpartition(".")[0]
    found = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            above = package.split(".")[: 1 - node.level or None] if node.level else []
            base = ".".join([*above, *filter(None, [node.module])])
            submodules = {f"{base}.{alias.name}" for alias in node.names}
            found |= submodules & MODULES.keys()
            # The package itself is imported from only if a name is its own.
            found |= {base} if submodules - MODULES.keys() else set()
    return (found & MODULES.keys()) - {name}


def in_or_above_circles(graph):
    """Modules (sorted) that are in a circle of imports or lead to one."""
    left = dict(graph)
    while ends := {name for name, targets in left.items() if not targets & left.keys()}:
        left = {name: targets for name, targets in left.items() if name not in ends}
    return sorted(left)


def test_no_circle_of_imports():
    assert in_or_above_circles({name: imports_of(name) for name in MODULES}) == []


def test_a_circle_would_be_found():
    assert in_or_above_circles({"a": {"b"}, "b": {"c"}, "c": {"b"}, "d": {"e"}, "e": set()}) == ["a", "b", "c"]
    assert imports_of("mobius_match.cli.app") > {"mobius_match.cli.match", "mobius_match"}
    assert "mobius_match.evaluation.examples" in imports_of("mobius_match"), "imported in a function and for types"


def test_the_top_of_the_package_is_small():
    assert len([path for path in SOURCE.iterdir() if path.name != "__pycache__"]) <= MOST_ENTRIES


def test_files_are_short():
    lines = {name: len(path.read_text(encoding="utf-8").splitlines()) for name, path in MODULES.items()}
    assert {name: count for name, count in lines.items() if count > LONGEST} == {}
