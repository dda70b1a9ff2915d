"""The directive ``commands``: every command of ``mobius`` with its arguments and options, as the program has them."""

from __future__ import annotations

from typing import Any

import typer.main
from docutils import nodes
from sphinx.util.docutils import SphinxDirective

from mobius_match.cli.app import app as mobius


def lines_of(name: str, command: Any) -> list[str]:
    """The section of one command, as reStructuredText."""
    arguments = [one for one in command.params if one.param_type_name == "argument"]
    options = [one for one in command.params if one.param_type_name == "option"]
    usage = " ".join(["mobius", name, *(one.metavar for one in arguments), "[OPTIONS]"])
    lines = [f".. _mobius-{name}:", "", f"mobius {name}", "-" * (len(name) + 7), "", "::", "", f"   {usage}", ""]
    lines += [*escaped(command.help).splitlines(), ""]
    rows = [(f"``{one.metavar}``", one.help) for one in arguments]
    rows += [(f"``{spelled(one)}``", with_default(one)) for one in options if not one.hidden]
    lines += [".. list-table::", "   :widths: 38 62", "   :class: options", ""]
    for left, right in rows:
        lines += [f"   * - {left}", f"     - {escaped(' '.join((right or '').split()))}"]
    return [*lines, ""]


def spelled(option: Any) -> str:
    """Short and long name, and what stands for the value."""
    names = ", ".join(sorted((*option.opts, *option.secondary_opts), key=len))
    return f"{names} {option.metavar}" if option.metavar and not option.is_flag else names


def with_default(option: Any) -> str:
    """The help, with the default where the help does not name it and there is one worth telling."""
    text = option.help or ""
    told = option.is_flag or option.default is None or "[default" in text
    return text if told else f"{text}  [default: {option.default}]"


def escaped(text: str) -> str:
    """Plain text that reStructuredText takes for nothing else."""
    for character in "\\*`_|":
        text = text.replace(character, f"\\{character}")
    return text


class Commands(SphinxDirective):
    """All commands, one section each."""

    def run(self) -> list[nodes.Node]:
        """Called by Sphinx where the directive stands."""
        commands = typer.main.get_command(mobius).commands  # type: ignore[attr-defined]
        lines = [line for name, command in commands.items() for line in lines_of(name, command)]
        return self.parse_text_to_nodes("\n".join(lines), allow_section_headings=True)


def setup(app: Any) -> dict[str, bool]:
    """Called by Sphinx."""
    app.add_directive("commands", Commands)
    return {"parallel_read_safe": True}
