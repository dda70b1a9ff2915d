"""``mobius transfer RESULT --what WHAT -o OUT``."""

from __future__ import annotations

import io
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from typer import Option

from .common import Reporter
from .match import NoCache, Quiet, Verbose
from .output import STDOUT, check_output, write
from .results import ResultFile, load_map

if TYPE_CHECKING:
    import numpy as np

    from ..landmarks.tables import Landmarks
    from ..mesh.appearance import Appearance
    from ..transfer.transfer import Transfer

WORDS = ("colors", "uv", "labels", "positions")
ENDINGS = (".ply", ".glb", ".obj", ".npz", ".csv", ".txt")


def transfer(
    result: ResultFile,
    what: Annotated[
        list[str],
        Option(
            metavar="colors|uv|labels|positions|FILE",
            help="What to carry; may be given several times. 'colors' and 'uv' (with the texture) are those of the "
            "mesh file, 'labels' its labels of faces; 'positions' writes the target's shape in the source's "
            "triangulation. A FILE (.csv, .txt, .npy, .npz) has a row for each vertex, a whole number for each face, "
            "or landmarks (columns vertex or x, y, z).",
        ),
    ],
    output: Annotated[
        Path,
        Option(
            "--output",
            "-o",
            metavar="OUT",
            help="A .ply, .glb, .obj, .npz, .csv or .txt file; '-' prints as .csv does.",
        ),
    ],
    back: Annotated[bool, Option("--back", help="From the target to the source.")] = False,
    donor: Annotated[
        Path | None,
        Option(
            "--from",
            metavar="MESH",
            help="Take colours, texture or labels from this file, numbered as the source's.",
        ),
    ] = None,
    no_cache: NoCache = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:
    """Carry colours, textures, labels, values, landmarks or the shape itself from one matched mesh to the other."""
    _check(what, output, result, donor)
    with Reporter(quiet, verbose) as reporter:
        surface_map = load_map(result, reporter, cache=not no_cache)

        from ..transfer.transfer import Transfer

        carrier = Transfer(surface_map.inverse if back else surface_map)
        load = _Load(carrier)
        for one in what:
            load.add(one, donor)
        files = load.files(output)
        reporter.notes(load.notes)
        for path, content in files.items():
            write(path, content)
        reporter.notes([] if output == STDOUT else [f"{', '.join(what)} written to {output}"])


def _check(what: list[str], output: Path, result: Path, donor: Path | None) -> None:
    from ..errors import SettingsError

    if output != STDOUT and output.suffix.lower() not in ENDINGS:
        raise SettingsError(f"--output: {output} should end in one of {', '.join(ENDINGS)}.")
    files = [Path(one) for one in what if one not in WORDS]
    for path in files:
        if not path.is_file():
            raise SettingsError(f"--what: {path} is no file, and none of {', '.join(WORDS)}.")
    check_output("--output", output, [result, *files, *([donor] if donor else [])])


@dataclass
class _Load:
    """What is carried, ready to be written."""

    carrier: Transfer
    notes: list[str] = field(default_factory=list)
    mesh: dict[str, Any] = field(default_factory=dict)
    values: dict[str, np.ndarray] = field(default_factory=dict)
    landmarks: Landmarks | None = None
    appearance: Appearance | None = None

    def add(self, what: str, donor: Path | None) -> None:
        if what not in WORDS:
            self._file(Path(what))
        elif what == "positions":
            self.mesh["positions"] = self.carrier.positions()
            self._lost(self._gaps(self.mesh["positions"]), "vertices", "in no face of the mesh that is written")
        else:
            getattr(self, f"_{what}")(self._given(what, donor))

    def _given(self, what: str, donor: Path | None) -> Appearance:
        from ..errors import MeshError
        from ..mesh.appearance import read_appearance

        source = self.carrier.source
        path = donor or source.path
        if path is None:
            raise MeshError(f"{source.name} was given as arrays: name the file that has its {what} with --from")
        if self.appearance is None:
            self.appearance = read_appearance(path)
            mesh = self.appearance.mesh
            if mesh.vertices.shape != source.vertices.shape or (mesh.faces != source.faces).any():
                raise MeshError(f"{path}: its vertices or faces are not numbered as those of {source.name}")
        return self.appearance

    def _need(self, found: Any, what: str, hint: str) -> Any:
        from ..errors import MeshError

        if found is None and self.appearance is not None:
            raise MeshError(f"{self.appearance.mesh.path}: has no {what}; {hint}")
        return found

    def _colors(self, given: Appearance) -> None:
        self._add_colors(self._need(given.colors, "colours", "give a file that has with --from"))
        if given.sampled:
            self.notes.append("the vertices have no colours of their own and take those of the texture")

    def _add_colors(self, colors: np.ndarray) -> None:
        self.mesh["colors"] = self.carrier.colors(colors)
        self._lost(int(self.carrier.missing.sum()), "vertices", "grey")

    def _uv(self, given: Appearance) -> None:
        self._add_uv(self._need(given.uv, "texture coordinates", "give a file that has with --from"))
        self.mesh["image"] = given.image

    def _add_uv(self, uv: np.ndarray) -> None:
        self.mesh["uv"] = self.carrier.uv(uv)
        self._lost(self._gaps(self.mesh["uv"]), "faces", "without texture")

    def _labels(self, given: Appearance) -> None:
        from ..mesh.appearance import LABELS

        hint = f"a .ply file has them as a property of faces ({', '.join(LABELS)}); or give a file of numbers"
        self._add_labels(self._need(given.labels, "labels of faces", hint))

    def _add_labels(self, labels: np.ndarray) -> None:
        self.mesh["labels"] = self.carrier.labels(labels)
        # Counted with other labels, as the given ones may be negative.
        self._lost(int((self.carrier.labels(labels * 0) < 0).sum()), "faces", "labelled -1")

    def _file(self, path: Path) -> None:
        from ..errors import FormatError
        from ..landmarks.tables import Landmarks, as_landmarks, read_table

        found, source = read_table(path), self.carrier.source
        sizes = {len(source.vertices), source.n_file_faces}
        if not isinstance(found, Landmarks) and not {len(a) if a.ndim else 0 for a in found.values()} <= sizes:
            marks = as_landmarks(path, found)
            if marks is None or len(marks) >= min(sizes):
                raise FormatError(
                    f"{path}: {source.name} has {len(source.vertices)} vertices and {source.n_file_faces} faces, and "
                    f"there are {', '.join(f'{name} {a.shape}' for name, a in found.items())}; give a row for each, or "
                    "landmarks (columns vertex, or x, y, z)"
                )
            self.notes.append(f"{path}: {len(marks)} rows without headings, taken for landmarks")
            found = marks
        if isinstance(found, Landmarks):
            self._carry(path, found)
            return
        for name, array in found.items():
            if array.shape == (len(source.faces), 3, 2):
                self._add_uv(array)
            elif array.dtype == "uint8" and array.shape in ((len(source.vertices), 3), (len(source.vertices), 4)):
                self._add_colors(array)
            elif len(array) == len(source.vertices):
                self.values[name] = self.carrier.values(array)
                how = "-1" if self.values[name].dtype.kind == "i" else "NaN"
                self._lost(int(self.carrier.missing.sum()), "vertices", how)
            else:
                self._add_labels(array)

    def _carry(self, path: Path, given: Landmarks) -> None:
        self.landmarks, apart = self.carrier.landmarks(given)
        if given.points is not None:
            self.notes.append(
                f"{path}: {len(given)} points moved onto the surface of {self.carrier.source.name}, "
                f"by {apart.max(initial=0):.3g} at most"
            )
        self._lost(int((self.landmarks.vertices < 0).sum()), "points", "NaN and vertex -1")

    def _lost(self, number: int, what: str, how: str) -> None:
        if number:
            self.notes.append(f"{number} {what} have no counterpart: {how}")

    @staticmethod
    def _gaps(values: np.ndarray) -> int:
        """How many rows are not numbers."""
        return int((values != values).reshape(len(values), -1).any(axis=1).sum())

    def files(self, output: Path) -> dict[Path, bytes]:
        """The files to write, the one that was asked for last."""
        from ..errors import SettingsError
        from ..mesh.writing import MESH_ENDINGS

        kind, positions = output.suffix.lower(), self.mesh.get("positions")
        if kind == ".npz":
            return {output: self._arrays()}
        if kind not in MESH_ENDINGS:
            return {output: self._text(output)}
        if self.landmarks is not None:
            raise SettingsError(f"--output: landmarks are written as .csv, .txt or .npz, not as {kind}")
        if positions is not None and (len(self.mesh) > 1 or self.values):
            raise SettingsError(
                "--what: positions make a mesh of the source's faces, all else one of the target's; ask twice"
            )
        return self._shape(output) if positions is not None else self._dressed(output)

    def _dressed(self, output: Path) -> dict[Path, bytes]:
        """The target with what it has got."""
        import numpy as np

        from ..mesh.writing import mesh_files, split_seams

        target, parts = self.carrier.target, dict(self.mesh)
        if "labels" in parts:
            parts["labels"] = parts["labels"][target.face_ids]
        if "uv" in parts:
            parts["uv"] = np.nan_to_num(parts["uv"])
            if output.suffix.lower() == ".glb":
                extra = len(split_seams(len(target.vertices), target.faces, parts["uv"])[0]) - len(target.vertices)
                self.notes.append(f"{extra} vertices on seams have copies behind the others, as .glb files need")
        return mesh_files(output, target.vertices, target.faces, **parts, values=self.values)

    def _shape(self, output: Path) -> dict[Path, bytes]:
        """The source's triangulation at its place on the target."""
        import numpy as np

        from ..mesh.writing import mesh_files

        places, faces = self.mesh["positions"].copy(), self.carrier.source.faces
        gone = np.isnan(places).any(axis=1)
        places[gone] = places[~gone].mean(axis=0)  # in no face
        return mesh_files(output, places, faces[~gone[faces].any(axis=1)])

    def _arrays(self) -> bytes:
        import numpy as np

        arrays = {name: a for name, a in self.mesh.items() if name != "image"} | self.values
        if "image" in self.mesh and self.mesh["image"] is not None:
            arrays["image"] = np.frombuffer(self.mesh["image"], np.uint8)
        if "positions" in arrays:
            arrays["faces"] = self.carrier.source.faces
        if self.landmarks is not None:
            arrays |= {"points": self.landmarks.points, "vertices": self.landmarks.vertices}
            arrays |= {"names": np.array(self.landmarks.names)} if self.landmarks.names else {}
        buffer = io.BytesIO()
        np.savez(buffer, allow_pickle=False, **arrays)
        return buffer.getvalue()

    def _text(self, output: Path) -> bytes:
        from ..errors import SettingsError
        from ..landmarks.tables import text_of

        arrays = [a for name, a in self.mesh.items() if name != "image"] + list(self.values.values())
        if len(arrays) + (self.landmarks is not None) != 1:
            raise SettingsError(f"--output: {output} holds one array, and several were asked for; write a .npz file")
        return self.landmarks.text() if self.landmarks is not None else text_of(arrays[0])
