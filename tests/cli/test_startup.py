"""What the command line does before any work."""

import importlib.metadata
import json

import pytest

import mobius_match
from mobius_match.cli.common import Reporter

HEAVY = {"numpy", "scipy", "numba", "trimesh", "meshio", "igl", "potpourri3d", "matplotlib", "rich"}

REPORT_MODULES = """
import atexit, json, sys
atexit.register(lambda: sys.stderr.write(json.dumps(sorted(sys.modules))))
from mobius_match.cli import main
main()
"""


@pytest.mark.parametrize(
    "arguments", [["--help"], ["--version"], ["match", "--help"], ["info", "--help"], ["demo", "--help"]]
)
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
    for name in ("match", "info", "demo"):
        assert f"\n  {name}  " in ended.out


def test_compiling_is_told_once_and_not_if_quiet(capsys):
    for quiet, said in ((False, "compiling kernels (first run only)...\n"), (True, "")):
        with Reporter(quiet) as reporter:
            for done in (0, 1):
                reporter.progress("compiling", done, 2)
            reporter.progress("voting", 0, 2)
        assert capsys.readouterr() == ("", said)
