"""What the command line does before any work."""

import importlib.metadata
import json

import numba
import pytest

import mobius_match
from mobius_match.cli.common import Reporter

HEAVY = {"numpy", "scipy", "numba", "trimesh", "meshio", "igl", "matplotlib", "rich"}

REPORT_MODULES = """
import atexit, json, sys
atexit.register(lambda: sys.stderr.write(json.dumps(sorted(sys.modules))))
from mobius_match.cli import main
main()
"""


COMMANDS = ("match", "view", "info", "demo", "bench", "symmetry", "convert", "landmarks", "transfer", "morph")
COMMANDS += ("prepare", "cache")


@pytest.mark.parametrize("arguments", [["--help"], ["--version"], *([name, "--help"] for name in COMMANDS)])
def test_help_loads_nothing_heavy(start_process, arguments):
    out, err = start_process("-c", REPORT_MODULES, *arguments)
    assert out
    assert HEAVY & set(json.loads(err)) == set()


def test_the_package_loads_nothing_heavy(start_process):
    _, err = start_process("-c", "import json, sys, mobius_match; sys.stderr.write(json.dumps(sorted(sys.modules)))")
    assert HEAVY & set(json.loads(err)) == set()


def test_version(mobius):
    assert mobius("--version") == (0, f"mobius-match {mobius_match.__version__}\n", "")
    assert importlib.metadata.version("mobius-match") == mobius_match.__version__


def test_the_command_is_installed():
    (script,) = (e for e in importlib.metadata.entry_points(group="console_scripts") if e.name == "mobius")
    assert script.load() is mobius_match.cli.main


def test_help_names_every_command(mobius):
    ended = mobius("--help")
    assert ended.code == 0
    for name in COMMANDS:
        assert f"\n  {name}  " in ended.out


@pytest.mark.parametrize("quiet", [False, True])
def test_compiling_is_reported_once_and_not_if_quiet_or_cached(capsys, quiet):
    for source in ("def kernel(x): return x + 1", "def kernel(x): return x + 2"):
        names = {}
        exec(source, names)
        kernel = numba.njit(names["kernel"])
        for value in (1, 2.0, 3):  # compiled twice
            with Reporter(quiet) as reporter, reporter.compiling():
                kernel(value)
                kernel(value)
            said = capsys.readouterr()
            told = "compiling (up to a minute, in the first run only) ...\n"
            assert said == ("", "" if quiet or value == 3 else told)


MATCH = """
import json, sys
from mobius_match.cli import main
try:
    main()
except SystemExit as ending:
    sys.stderr.write("\\n" + json.dumps([ending.code or 0, sorted(sys.modules)]))
"""


def test_a_match_of_prepared_surfaces_loads_no_more_than_it_needs(start_process, mobius, pair, tmp_path):
    result = tmp_path / "result.json"
    options = ("--samples", "30", "--votes", "2000", "-o", str(result))
    assert mobius("match", *pair[:2], *options).code == 0
    _, err = start_process("-c", MATCH, "match", *map(str, pair[:2]), *options)
    *lines, last = err.splitlines()
    code, modules = json.loads(last)
    assert code == 0
    # The kernels were kept, so nothing is compiled, and nothing said of it.
    number = len(json.loads(result.read_text())["correspondences"])
    assert [line for line in lines if line] == [f"{number} correspondences written to {result}"]
    unneeded = (HEAVY | {"scipy.spatial", "scipy.optimize"}) - {"numpy", "scipy", "numba"}
    assert unneeded & set(modules) == set()


READ_ONLY = """
import sys
import numba.core.caching as caching
caching.CacheImpl._locator_classes = []  # as if no folder could be written
from mobius_match._core import compiling

@compiling.jit
def kernel(x):
    return x + 1

told = []
with compiling.on_compiling(lambda: told.append(compiling.compiling())):
    sys.stdout.write(str(kernel(1)))
sys.stderr.write("".join(told))
"""


def test_kernels_work_where_none_can_be_cached(start_process):
    out, err = start_process("-c", READ_ONLY)
    assert out == "2"
    why = "in every run: no cache folder is writable; set NUMBA_CACHE_DIR to one"
    assert err == f"compiling (up to a minute, {why}) ..."
