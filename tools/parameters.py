"""Write docs/parameters.md, the list of all constants of the method, from the records in the code.

python tools/parameters.py [-o docs/parameters.md]
"""

from __future__ import annotations

import argparse
import importlib
import inspect
import pkgutil
import re
from collections.abc import Iterator
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

import mobius_match
from mobius_match._core.parameters import HAND, Parameter, parameters_of

PAGE = Path(__file__).parents[1] / "docs/parameters.md"

HEADING = """# Parameters

All {count} constants of the method, generated from the records in the code by `python tools/parameters.py`: each with
its meaning, its unit and its origin. [The method](method.md) has the formulas that they belong to. They are not
[settings](settings.md): the defaults are the method. To study it, pass other records, as [the ablation](ablation.md)
does: `mm.match(source, target, parameters=...)`.

"By hand" means {hand}, without a script that fits the number; the ablation shows
what it contributes.

"""


def records() -> Iterator[tuple[str, Any]]:
    """Room and default of every record of parameters, from the bottom of the package up."""
    names = [module.name for module in pkgutil.walk_packages(mobius_match.__path__, "mobius_match.")]
    order = ("mesh", "geometry", "surface", "voting", "landmarks", "registration", "alignments", "matching")
    for name in sorted(
        (name for name in names if name.endswith(".parameters") and "._core." not in name),
        key=lambda name: (order.index(name.split(".")[1]), name.count("."), name),
    ):
        for label, record in vars(importlib.import_module(name)).items():
            if inspect.isclass(record) and record.__module__ == name and label.endswith("Parameters"):
                yield name.removeprefix("mobius_match.").removesuffix(".parameters").replace(".", "/"), record()


def own_parameters(record: Any) -> list[Parameter]:
    """The parameters of a record without those of the stages that it is made of."""
    stages = tuple(
        f"{one.name}."
        for one in fields(record)
        if is_dataclass(getattr(record, one.name)) and type(getattr(record, one.name)).__name__.endswith("Parameters")
    )
    return [one for one in parameters_of(record) if not stages or not one.name.startswith(stages)]


def page() -> str:
    """The text of the page."""
    text, count = "", 0
    for room, record in records():
        rows = own_parameters(record)
        if not rows:
            continue
        count += sum(len(one.value) if isinstance(one.value, tuple) else 1 for one in rows)
        about = " ".join((inspect.getdoc(record) or "").split("\n\n")[0].split())
        about = re.sub(r":\w+:(`[^`]+`)", r"\1", about)
        text += f"## {type(record).__name__}\n\n{about} In `{room}/parameters.py`.\n\n"
        text += "| parameter | value | unit | meaning | origin |\n|---|---|---|---|---|\n"
        for one in rows:
            value = ", ".join(map(str, one.value)) if isinstance(one.value, tuple) else one.value
            text += f"| `{one.name}` | {value} | {one.unit} | {one.meaning} | {one.origin.replace(HAND, 'by hand')} |\n"
        text += "\n"
    return HEADING.format(count=count, hand=HAND) + text.rstrip("\n") + "\n"


def main() -> None:
    """Write the page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", "--output", type=Path, default=PAGE)
    parser.parse_args().output.write_text(page(), encoding="utf-8")


if __name__ == "__main__":
    main()
