"""Reading the result file: JSON that holds all of a result but its surfaces."""

from __future__ import annotations

import json
import math
from functools import partial
from pathlib import Path
from typing import Any

from ..errors import FormatError
from .matches import Alternative, from_rows, to_rows

FORMAT = "mobius-match/correspondence"
VERSION = 1


def row_of_alternative(alternative: Alternative) -> dict[str, Any]:
    """An alternative as it stands in the file."""
    probability = {} if math.isnan(alternative.probability) else {"probability": alternative.probability}
    return {
        "margin": alternative.margin,
        "share": alternative.share,
        **probability,
        "correspondences": to_rows(alternative),
    }


def fields_of_file(path: Path) -> dict[str, Any]:
    """The fields of the :class:`.Correspondence` that a file holds.

    Raises
    ------
    FormatError
        If the file cannot be read or is no result file of this version.
    """
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise FormatError(f"{path}: not a readable result file ({error}); make one with mobius match -o") from error
    if not isinstance(content, dict) or content.get("format") != FORMAT:
        raise FormatError(f"{path}: not a result of mobius match; its 'format' should be '{FORMAT}'")
    if content.get("version") != VERSION:
        raise FormatError(
            f"{path}: has version {content.get('version')!r} and this program reads {VERSION}; "
            "make it again, or use the program that made it"
        )
    try:
        probability = content.get("probability")
        return {
            **from_rows(content["correspondences"]),
            "source_info": dict(content["source"]),
            "target_info": dict(content["target"]),
            "settings": dict(content["settings"]),
            "timings": dict(content["timings"]),
            "software": dict(content["software"]),
            "diagnostics": dict(content.get("diagnostics", {})),
            "warnings": tuple(content.get("warnings", ())),
            "probability": None if probability is None else float(probability),
            "symmetry": content.get("symmetry"),
            "reflected": bool(content.get("reflected", False)),
            "_make_alternatives": partial(tuple, [_alternative(one) for one in content.get("alternatives", ())]),
        }
    except (KeyError, TypeError, ValueError, OverflowError) as error:
        raise FormatError(f"{path}: the result file is damaged ({error!r}); make it again") from error


def _alternative(content: dict[str, Any]) -> Alternative:
    margin, share, probability = (float(content.get(name, "nan")) for name in ("margin", "share", "probability"))
    return Alternative(**from_rows(content["correspondences"]), margin=margin, share=share, probability=probability)
