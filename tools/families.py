"""Write families of shapes with exact truth: people, animals, tools, vessels, in poses and proportions.

    python tools/families.py OUT --kinds all --instances 6 --seed 0

OUT/KIND is a data set for `mobius bench OUT/KIND --dense`. The same seed and versions write the same bytes.
"""

import argparse
import json
import zlib
from itertools import combinations
from pathlib import Path

import igl
import numpy as np
import trimesh
from bodies import Bone, Kind, Template, symmetry
from implicit import surface
from instances import Instance, individual, make
from kinds_living import LIVING
from kinds_objects import OBJECTS
from relax import Floats, Ints
from scipy.spatial.transform import Rotation

from mobius_match.mesh.simplify import simplify

KINDS: dict[str, Kind] = {kind.name: kind for kind in (kind() for kind in LIVING + OBJECTS)}
VERTICES = (2000, 6000)  # of an instance, fewest and most
KNOWN = 2500  # points whose vertices are listed, at most
POSES = 2  # of one individual
RELATED = ("person", "quadruped", "longneck", "lizard", "armadillo", "teddy")
"""Kinds with head, limbs and trunk, whose landmarks of one name belong together."""
UNRELATED = (
    ("person", "vase"), ("chair", "fish"), ("ant", "mug"), ("glasses", "quadruped"), ("octopus", "table"),
    ("hand", "bird"), ("bone", "person"), ("molar", "cup"), ("pliers", "fish"), ("aeroplane", "spider"),
    ("bust", "chair"), ("lizard", "scissors"), ("teddy", "pliers"), ("armadillo", "table"), ("vase", "fish"),
)  # fmt: skip
WITH_SOLIDS = (("person", "ball"), ("person", "cube"), ("octopus", "ball"), ("chair", "cube"), ("fish", "ball"))


class Family:
    """A kind and some of its instances."""

    def __init__(self, kind: Kind, instances: int, seed: int, vertices: tuple[int, int] = VERTICES) -> None:
        self.kind = kind
        self.template = Template(kind, vertices[1])
        self.instances: list[Instance] = []
        rng = np.random.default_rng([seed, zlib.crc32(kind.name.encode())])
        for number in range(instances):
            if number % POSES == 0:
                proportions = individual(self.template, rng)
            count = int(rng.integers(vertices[0], vertices[1] + 1))
            self.instances.append(make(self.template, proportions, count, rng))
        self.pairs = [pair if rng.random() < 0.5 else pair[::-1] for pair in combinations(range(instances), 2)]

    def name(self, number: int) -> str:
        """The name of an instance, and of its files without ending."""
        return f"{self.kind.name}{number}"

    def words(self) -> list[str]:
        """The symmetries of the kind beside the identity."""
        return ["sym"] * self.kind.mirror + [f"turn{k}" for k in range(1, self.kind.turns)]

    def known(self, points: Floats, normals: Floats) -> list[Ints]:
        """For each instance its vertices nearest to points at rest."""
        template = self.template
        at, where = template.locate(points, normals)
        lists = []
        for one in self.instances:
            directions = igl.per_vertex_normals(one.posed, template.faces)
            corners = template.faces[at]
            places, facing = (np.einsum("ki,kij->kj", where, rows[corners]) for rows in (one.posed, directions))
            lists.append(one.vertices_at(places, facing))
        return lists

    def landmarks(self) -> dict[str, list[int]]:
        """Vertices of the named points in each instance."""
        places = {}
        for name, place in self.kind.landmarks.items():
            places[name] = place
            if name.endswith(".L"):
                places[name[:-1] + "R"] = np.multiply(place, [-1, 1, 1])
        _, face, points = igl.point_mesh_squared_distance(
            np.array(list(places.values()), float), self.template.vertices, self.template.faces
        )
        normals = igl.per_face_normals(self.template.vertices, self.template.faces, np.zeros(3))[face]
        lists = self.known(points, normals)
        return {name: [int(vertices[i]) for vertices in lists] for i, name in enumerate(places)}

    def write(self, folder: Path) -> None:
        """The data set of this kind."""
        (folder / "corres").mkdir(parents=True, exist_ok=True)
        (folder / "truth").mkdir(exist_ok=True)
        for number, one in enumerate(self.instances):
            _write_mesh(folder / f"{self.name(number)}.ply", one.vertices, one.faces)
            np.savez(
                folder / "truth" / f"{self.name(number)}.npz",
                template_faces=one.template_faces.astype(np.int32),
                barycentric=one.barycentric.astype(np.float32),
                posed=one.posed.astype(np.float32),
            )
        _write_mesh(folder / "truth" / "template.ply", self.template.vertices, self.template.faces)
        chosen = simplify(self.template.vertices, self.template.faces, KNOWN)[0]
        if self.kind.cut is not None:
            chosen = chosen[self.template.vertices[chosen, 1] > self.kind.cut]
        normals = igl.per_vertex_normals(self.template.vertices, self.template.faces)[chosen]
        for word in ["", *self.words()]:
            matrix = symmetry(self.kind, word) if word else np.eye(3)
            lists = self.known(self.template.vertices[chosen] @ matrix.T, normals @ matrix.T)
            for number, vertices in enumerate(lists):
                path = folder / "corres" / (self.name(number) + (f".{word}" if word else "") + ".vts")
                path.write_text("".join(f"{vertex + 1}\n" for vertex in vertices))
        lines = [f"{self.name(i)} {self.name(j)}\n" for i, j in self.pairs]
        (folder / "pairs.txt").write_text("".join(lines))
        facts = {
            "kind": self.kind.name,
            "genus": self.kind.genus,
            "open": self.kind.cut is not None,
            "mirror": self.kind.mirror,
            "turns": self.kind.turns,
            "every_turn": self.kind.smooth,
            "symmetries": self.words(),
            "poses_of_one_individual": POSES,
            "landmarks": self.landmarks(),
        }
        (folder / "family.json").write_text(json.dumps(facts, indent=1) + "\n")


def _write_mesh(path: Path, vertices: Floats, faces: Ints) -> None:
    mesh = trimesh.Trimesh(vertices, faces, process=False)
    path.write_bytes(trimesh.exchange.ply.export_ply(mesh, vertex_normal=False))


def write_related(families: dict[str, Family], folder: Path) -> None:
    """A manifest of pairs of different kinds with the landmarks that they share."""
    rows = []
    for a, b in combinations([name for name in RELATED if name in families], 2):
        marks = families[a].landmarks(), families[b].landmarks()
        shared = [name for name in marks[0] if name in marks[1]]
        for number in range(min(len(families[a].instances), len(families[b].instances))):
            names = families[a].name(number), families[b].name(number)
            lists = [[mark[name][number] for name in shared] for mark in marks]
            other = {"L": "R", "R": "L"}
            swapped = [name[:-1] + other[name[-1]] if name[-2:] in (".L", ".R") else name for name in shared]
            lists.append([marks[1][name][number] for name in swapped])
            stem = f"{names[0]}-{names[1]}"
            files = [f"{stem}.{word}.vts" for word in ("source", "target", "mirrored")]
            (folder / "related").mkdir(parents=True, exist_ok=True)
            for file, vertices in zip(files, lists, strict=True):
                (folder / "related" / file).write_text("".join(f"{vertex}\n" for vertex in vertices))
            meshes = [f"../{kind}/{name}.ply" for kind, name in zip((a, b), names, strict=True)]
            rows.append(",".join([*meshes, *files, "0", f"{a}-{b}"]))
    if rows:
        head = "source,target,source_landmarks,target_landmarks,mirrored_landmarks,base,category"
        (folder / "related" / "manifest.csv").write_text("\n".join([head, *rows]) + "\n")


def write_unrelated(families: dict[str, Family], folder: Path) -> None:
    """A ball and a cube, and a list of pairs, relative to the folder, of shapes that do not belong together."""
    (folder / "solids").mkdir(parents=True, exist_ok=True)
    ball = trimesh.creation.icosphere(subdivisions=4)
    _write_mesh(folder / "solids" / "ball.ply", ball.vertices, ball.faces)
    side = Bone("side", "", (-0.5, 0, 0), (0.5, 0, 0), 0.5, 0.5, box=0.05)
    vertices, faces = surface(np.array([side.solid()]), 0.025, Rotation.random(rng=0).as_matrix(), np.full(3, 0.5))
    kept, faces, _ = simplify(vertices, faces, KNOWN)
    _write_mesh(folder / "solids" / "cube.ply", vertices[kept], faces)
    lines = [
        f"{kind}/{families[kind].name(number)}.ply solids/{solid}.ply\n"
        for kind, solid in WITH_SOLIDS
        if kind in families
        for number in range(len(families[kind].instances))
    ]
    lines += [
        f"{a}/{families[a].name(number)}.ply {b}/{families[b].name(number)}.ply\n"
        for a, b in UNRELATED
        if a in families and b in families
        for number in range(min(len(families[a].instances), len(families[b].instances)))
    ]
    (folder / "unrelated.txt").write_text("".join(lines))


def write_readme(kinds: list[Kind], folder: Path) -> None:
    """What a user of the data must know: the symmetries of each kind, and where to read on."""
    lines = [
        "# Families of shapes with exact truth",
        "",
        "Written by `tools/families.py` of mobius-match; its `docs/families.md` says what each file means.",
        "A map is right up to the symmetry if it agrees with `corres/NAME.vts` or one of `corres/NAME.turnK.vts`;",
        "`corres/NAME.sym.vts` is the mirror image, which reverses orientation.",
        "",
        "| kind | surface | mirror plane | turns about its axis that change nothing at rest |",
        "|---|---|---|---|",
    ]
    for kind in kinds:
        shape = "open, one rim" if kind.cut is not None else f"closed, genus {kind.genus}"
        turns = f"all ({kind.turns} are listed)" if kind.smooth else str(kind.turns)
        lines.append(f"| {kind.name} | {shape} | {'yes' if kind.mirror else 'no'} | {turns} |")
    (folder / "README.md").write_text("\n".join(lines) + "\n")


def main(arguments: list[str] | None = None) -> None:
    """Write the families that are asked for."""
    parser = argparse.ArgumentParser(description="Write families of shapes with exact truth.")
    parser.add_argument("out", type=Path, metavar="OUT", help="folder for them")
    parser.add_argument("--kinds", default="all", help=f"all, or some of these, with commas: {', '.join(KINDS)}")
    parser.add_argument("--instances", type=int, default=6, help="number of each kind (6)")
    parser.add_argument("--seed", type=int, default=0, help="another seed, other proportions, poses and meshes (0)")
    parser.add_argument("--vertices", type=int, nargs=2, default=VERTICES, metavar=("FEWEST", "MOST"), help="of a mesh")
    given = parser.parse_args(arguments)
    names = list(KINDS) if given.kinds == "all" else given.kinds.split(",")
    unknown = [name for name in names if name not in KINDS]
    if unknown:
        parser.error(f"no such kinds: {', '.join(unknown)}; there are {', '.join(KINDS)}")
    families = {}
    for name in names:
        families[name] = Family(KINDS[name], given.instances, given.seed, tuple(given.vertices))
        families[name].write(given.out / name)
    write_readme([KINDS[name] for name in names], given.out)
    write_related(families, given.out)
    write_unrelated(families, given.out)


if __name__ == "__main__":
    main()
