"""What can be matched and what is refused, with the numbers that users need."""

import numpy as np
import pytest
import trimesh

from mobius_match.errors import MeshError, TopologyError
from mobius_match.mesh import Mesh, repair, require_matchable
from mobius_match.mesh.pieces import main_piece


def test_of_two_spheres_one_is_enough_and_an_unrepaired_bowtie_is_refused(shapes):
    v, f = shapes.sphere()
    require_matchable(main_piece(repair(Mesh(*shapes.union((v, f), (v + 5, f))))))
    pinched = shapes.grid(8, 8)[2]
    pinched[pinched == 80] = 0  # two corners of a sheet made one
    vertices = np.random.default_rng(0).random((81, 3))
    with pytest.raises(TopologyError, match="touch at single vertices"):
        require_matchable(Mesh(vertices, pinched))
    require_matchable(repair(Mesh(vertices, pinched)))


def test_refuses_what_was_not_repaired(shapes):
    for name, text in (("book", r"6 edge\(s\) have more than two faces, the first joins vertices 0 and 7 \(3 faces\)"),
                       ("moebius", "only one side")):  # fmt: skip
        with pytest.raises(TopologyError, match=text):
            require_matchable(Mesh(*getattr(shapes, name)()))


@pytest.mark.parametrize("n_faces", [0, 1, 19])
def test_refuses_too_few_faces(shapes, n_faces):
    vertices, faces = shapes.disc()
    with pytest.raises(MeshError, match=f"{n_faces} usable faces .* at least 20 faces and 12 vertices"):
        require_matchable(repair(Mesh(vertices, faces[:n_faces])))


def test_a_cube_cut_once_is_enough():
    require_matchable(repair(Mesh(*(lambda m: (m.vertices, m.faces))(trimesh.creation.box().subdivide()))))


@pytest.mark.parametrize("vertices", [np.zeros((49, 3)), np.linspace(0, 1, 49)[:, None] * [1, 2, 3]])
def test_refuses_no_area(shapes, vertices):
    with pytest.raises(MeshError, match="72 of 72 faces have no area"):
        require_matchable(repair(Mesh(vertices, shapes.disc()[1])))
