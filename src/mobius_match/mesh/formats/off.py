"""OFF, read here: the words of each row are counted, then vertices and faces are read as two arrays of numbers."""

from __future__ import annotations

import re
import warnings

import numpy as np

from ...errors import FormatError
from ..mesh import Floats, Ints
from .raw import RawMesh, from_polygons, promised

BLANK = np.isin(np.arange(256), np.frombuffer(b" \t\n\r\v\f", np.uint8))


def read_off(data: bytes) -> RawMesh:
    """Read the text form of OFF, with or without colours, normals or texture coordinates after x y z."""
    if b"#" in data:
        data = re.sub(rb"#[^\r\n]*", b"", data)
    head = re.match(rb"\s*(?:ST)?C?N?OFF\b[ \t\v\f]*([^\r\n]*)", data)
    if head is None:
        raise FormatError(
            "the first line must begin with OFF; binary and four-dimensional OFF cannot be read. "
            "Export it as plain OFF."
        )
    if not head[1].strip():
        head = re.compile(rb"\s*([^\r\n]*)").match(data, head.end()) or head
    counts = head[1].split()
    if len(counts) < 2 or not all(word.isdigit() and len(word) < 16 for word in counts):
        raise FormatError(
            "the numbers of vertices, faces and edges expected after OFF, found "
            f"{b' '.join(counts)[:40].decode('latin-1')!r}. Export it as plain text OFF."
        )
    n, m = int(counts[0]), int(counts[1])
    words, places = _words(data, head.end())
    promised(n + m, f"rows ({n} vertices and {m} faces)", len(words), "rows")
    few = np.flatnonzero(words[:n] < 3)
    if len(few):
        raise FormatError(
            f"vertex {few[0]} (counting from 0) has {words[few[0]]} coordinates, not 3. The file is damaged: "
            "export it again."
        )
    first = np.cumsum(words) - words
    vertices = _numbers(data[places[0] : places[n]])[first[:n, None] + np.arange(3)]
    sizes, corners = _faces(data[places[n] : places[n + m]], words[n : n + m], n)
    extra = len(words) - n - m
    return from_polygons(vertices, sizes, corners, [f"{extra} line(s) after the last face ignored."] if extra else [])


def _words(data: bytes, begin: int) -> tuple[Ints, Ints]:
    """Number of words of each row that is not empty (R,), and where these rows begin and the last ends (R + 1,)."""
    text = np.frombuffer(data, np.uint8)[begin:]
    blank = BLANK[text]
    start = np.flatnonzero(~blank & np.concatenate([[True], blank[:-1]]))
    end = np.append(np.flatnonzero((text == 10) | (text == 13)), len(text))
    before = np.searchsorted(start, end)
    words = np.diff(before, prepend=0)
    filled = np.flatnonzero(words)
    places = start[(before - words)[filled]] + begin
    return words[filled], np.append(places, len(data))


def _numbers(text: bytes) -> Floats:
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # numpy only warns where the text ends in something else
        try:
            return np.fromstring(text, sep=" ")
        except (DeprecationWarning, ValueError):  # of older and newer versions
            return np.array([float(word.decode("latin-1")) for word in text.split()])


def _faces(text: bytes, words: Ints, n: int) -> tuple[Ints, Ints]:
    """The number of corners of each face (F,), and the corners of all faces, concatenated."""
    try:
        found = _numbers(text)
    except ValueError:  # colours may have names
        found = np.array([_number(word) for word in text.split()])
    first = np.cumsum(words) - words
    sizes = found[first]
    bad = np.flatnonzero(~((sizes >= 0) & (sizes < words) & (sizes == np.floor(sizes))))
    if len(bad):
        raise FormatError(
            f"face {bad[0]} (counting from 0) should have {_word(text, first[bad[0]])} corners, but "
            f"{words[bad[0]] - 1} numbers follow. The file is damaged or was cut short: export it again."
        )
    sizes = sizes.astype(np.int64)
    place = np.arange(sizes.sum()) + np.repeat(first + 1 - (np.cumsum(sizes) - sizes), sizes)
    corners = found[place]
    bad = np.flatnonzero(~((corners >= 0) & (corners < n) & (corners == np.floor(corners))))
    if len(bad):
        face = np.searchsorted(np.cumsum(sizes), bad[0], side="right")
        raise FormatError(
            f"face {face} (counting from 0) names vertex {_word(text, place[bad[0]])}, but there are {n} vertices, "
            f"numbered 0 to {n - 1}. The file is damaged: export it again."
        )
    return sizes, corners.astype(np.int64)


def _number(word: bytes) -> float:
    try:
        return float(word)
    except ValueError:
        return float("nan")


def _word(text: bytes, place: int) -> str:
    return text.split()[place][:40].decode("latin-1")
