"""The attributes that ``mobius transfer`` transfers, and the files that it writes them to."""

from __future__ import annotations

import io
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import FormatError, MeshError, SettingsError

if TYPE_CHECKING:
    import numpy as np

    from ..landmarks.tables import Landmarks
    from ..mesh.appearance import Appearance
    from ..transfer.transfer import Transfer

WORDS = ("colors", "uv", "labels", "positions")
"""Attributes that come from the mesh files; all others come from files of their own."""


@dataclass
class Attributes:
    """Attributes of the source, transferred to the target and ready to be written.

    Parameters
    ----------
    transfer
        Transfers one attribute at a time.
    notes
        Lines for the user: what has no counterpart, and how files were read.
    mesh
        Colours, texture coordinates with their image, labels or positions, named as
        :func:`mobius_match.mesh.writing.mesh_files` takes them.
    values
        Other values of the target's vertices, by name.
    landmarks
        Landmarks on the target.
    """

    transfer: Transfer
    notes: list[str] = field(default_factory=list)
    mesh: dict[str, Any] = field(default_factory=dict)
    values: dict[str, np.ndarray] = field(default_factory=dict)
    landmarks: Landmarks | None = None
    _appearance: Appearance | None = field(default=None, init=False)

    def add(self, name: str, donor: Path | None) -> None:
        """Transfer one of `WORDS`, from the file ``donor`` or the source's own, or what the file ``name`` holds."""
        if name not in WORDS:
            self._add_file(Path(name))
        elif name == "positions":
            self.mesh["positions"] = self.transfer.positions()
            if self.transfer.map.reflected:
                self.notes.append("the source's faces are flipped, so that they point outward on the target")
            self._report_gaps(self.mesh["positions"], "vertices", "in no face of the written mesh")
        else:
            self._add_appearance(name, self._read_appearance(name, donor))

    def _read_appearance(self, name: str, donor: Path | None) -> Appearance:
        from ..mesh.appearance import read_appearance

        source = self.transfer.source
        path = donor or source.path
        if path is None:
            raise MeshError(f"{source.name} was given as arrays: give a file that has its {name} with --from")
        if self._appearance is None:
            self._appearance = read_appearance(path)
            mesh = self._appearance.mesh
            if mesh.vertices.shape != source.vertices.shape or (mesh.faces != source.faces).any():
                raise MeshError(f"{path}: its vertices or faces differ from those of {source.name}, or in their order")
        return self._appearance

    def _add_appearance(self, name: str, appearance: Appearance) -> None:
        from ..mesh.appearance import LABELS

        array = getattr(appearance, name)
        if array is None:
            hint = "give a file that has them with --from"
            if name == "labels":
                hint = f"a .ply file has them as a property of faces ({', '.join(LABELS)}); or give a file of numbers"
            kind = {"colors": "colours", "uv": "texture coordinates", "labels": "labels of faces"}[name]
            raise MeshError(f"{appearance.mesh.path}: has no {kind}; {hint}")
        if name == "colors":
            self._add_colors(array)
            if appearance.sampled:
                self.notes.append("the vertices have no colours of their own and take those of the texture")
        elif name == "uv":
            self._add_uv(array)
            self.mesh["image"] = appearance.image
        else:
            self._add_labels(array)

    def _add_colors(self, colors: np.ndarray) -> None:
        self.mesh["colors"] = self.transfer.colors(colors)
        self._report(int(self.transfer.missing.sum()), "vertices", "grey")

    def _add_uv(self, uv: np.ndarray) -> None:
        self.mesh["uv"] = self.transfer.uv(uv)
        self._report_gaps(self.mesh["uv"], "faces", "without texture")

    def _add_labels(self, labels: np.ndarray) -> None:
        self.mesh["labels"] = self.transfer.labels(labels)
        # Counted with labels that are all 0, as those of the user may be negative.
        self._report(int((self.transfer.labels(labels * 0) < 0).sum()), "faces", "labelled -1")

    def _add_file(self, path: Path) -> None:
        """Transfer the arrays or the landmarks in a file."""
        from ..landmarks.tables import Landmarks, as_landmarks, read_table

        content, source = read_table(path), self.transfer.source
        if not isinstance(content, Landmarks):
            sizes = {len(source.vertices), source.n_file_faces}
            if {len(array) if array.ndim else 0 for array in content.values()} <= sizes:
                for name, array in content.items():
                    self._add_array(name, array)
                return
            landmarks = as_landmarks(path, content)
            if landmarks is None or len(landmarks) >= min(sizes):
                raise FormatError(
                    f"{path}: {source.name} has {len(source.vertices)} vertices and {source.n_file_faces} faces, but "
                    f"the file has {', '.join(f'{name} {array.shape}' for name, array in content.items())}; give one "
                    "row for each, or landmarks (columns vertex, or x, y, z)"
                )
            self.notes.append(f"{path}: {len(landmarks)} rows without headings, read as landmarks")
            content = landmarks
        self._add_landmarks(path, content)

    def _add_array(self, name: str, array: np.ndarray) -> None:
        """Transfer an array by its shape: texture coordinates, colours, values of vertices or labels of faces."""
        source = self.transfer.source
        if array.shape == (len(source.faces), 3, 2):
            self._add_uv(array)
        elif array.dtype == "uint8" and array.shape in ((len(source.vertices), 3), (len(source.vertices), 4)):
            self._add_colors(array)
        elif len(array) == len(source.vertices):
            self.values[name] = self.transfer.values(array)
            missing = "-1" if self.values[name].dtype.kind == "i" else "NaN"
            self._report(int(self.transfer.missing.sum()), "vertices", missing)
        else:
            self._add_labels(array)

    def _add_landmarks(self, path: Path, landmarks: Landmarks) -> None:
        self.landmarks, distances = self.transfer.landmarks(landmarks)
        if landmarks.points is not None:
            self.notes.append(
                f"{path}: {len(landmarks)} points moved onto the surface of {self.transfer.source.name}, "
                f"by {distances.max(initial=0):.3g} at most"
            )
        self._report(int((self.landmarks.vertices < 0).sum()), "points", "NaN and vertex -1")

    def _report(self, number: int, elements: str, value: str) -> None:
        """Note how many elements have no counterpart, and the value that they get."""
        if number:
            self.notes.append(f"{number} {elements} have no counterpart: {value}")

    def _report_gaps(self, array: np.ndarray, elements: str, value: str) -> None:
        """The same, where rows with NaN have no counterpart."""
        self._report(int((array != array).reshape(len(array), -1).any(axis=1).sum()), elements, value)

    def files(self, output: Path) -> dict[Path, bytes]:
        """The content of each file to write; ``output`` is the last of them.

        Raises
        ------
        SettingsError
            The format of ``output`` cannot hold all attributes.
        """
        from ..mesh.writing import MESH_ENDINGS

        ending = output.suffix.lower()
        if ending == ".npz":
            return {output: self._arrays()}
        if ending not in MESH_ENDINGS:
            return {output: self._text(output)}
        if self.landmarks is not None:
            raise SettingsError(f"--output: landmarks are written as .csv, .txt or .npz, not as {ending}")
        if "positions" not in self.mesh:
            return self._target_files(output)
        if len(self.mesh) > 1 or self.values:
            raise SettingsError(
                "--what: positions are written on the source's faces, other attributes on the target's; run the "
                "command once for each"
            )
        return self._source_files(output)

    def _target_files(self, output: Path) -> dict[Path, bytes]:
        """The target with its new attributes."""
        import numpy as np

        from ..mesh.writing import mesh_files, split_seams

        target, attributes = self.transfer.target, dict(self.mesh)
        if "labels" in attributes:
            attributes["labels"] = attributes["labels"][target.face_ids]
        if "uv" in attributes:
            attributes["uv"] = np.nan_to_num(attributes["uv"])
            if output.suffix.lower() == ".glb":
                split = split_seams(len(target.vertices), target.faces, attributes["uv"])[0]
                extra = len(split) - len(target.vertices)
                self.notes.append(f"{extra} vertices on seams are duplicated at the end of the list, for the .glb file")
        return mesh_files(output, target.vertices, target.faces, **attributes, values=self.values)

    def _source_files(self, output: Path) -> dict[Path, bytes]:
        """The source's triangles with the shape of the target."""
        import numpy as np

        from ..mesh.writing import mesh_files

        positions, faces = self.mesh["positions"].copy(), self._faces
        missing = np.isnan(positions).any(axis=1)
        positions[missing] = positions[~missing].mean(axis=0)  # in no face
        return mesh_files(output, positions, faces[~missing[faces].any(axis=1)])

    @property
    def _faces(self) -> np.ndarray:
        """The source's faces, as they point outward on the target."""
        source = self.transfer.source
        return (source.reflected() if self.transfer.map.reflected else source).faces

    def _arrays(self) -> bytes:
        """All attributes in one .npz file."""
        import numpy as np

        arrays = {name: array for name, array in self.mesh.items() if name != "image"} | self.values
        if self.mesh.get("image") is not None:
            arrays["image"] = np.frombuffer(self.mesh["image"], np.uint8)
        if "positions" in arrays:
            arrays["faces"] = self._faces
        if self.landmarks is not None:
            arrays |= {"points": self.landmarks.points, "vertices": self.landmarks.vertices}
            arrays |= {"names": np.array(self.landmarks.names)} if self.landmarks.names else {}
        buffer = io.BytesIO()
        np.savez(buffer, allow_pickle=False, **arrays)
        return buffer.getvalue()

    def _text(self, output: Path) -> bytes:
        """The only attribute as a table."""
        from ..landmarks.tables import text_of

        arrays = [array for name, array in self.mesh.items() if name != "image"] + list(self.values.values())
        if len(arrays) + (self.landmarks is not None) != 1:
            raise SettingsError(f"--output: {output} can hold one attribute only; write a .npz file")
        return self.landmarks.text() if self.landmarks is not None else text_of(arrays[0])
