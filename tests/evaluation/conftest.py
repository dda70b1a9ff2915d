"""A small data set: one shape four times, rotated and renumbered."""

import numpy as np
import pytest
import trimesh

from tests.shapes import lump, renumbered, rotation

QUICK = {"samples": 25, "votes": 4000}


@pytest.fixture(scope="session")
def lumps(tmp_path_factory):
    """Folder with lump0.off to lump3.off and corres/; the mirrored lists are arbitrary other vertices."""
    folder = tmp_path_factory.mktemp("data") / "lumps"
    (folder / "corres").mkdir(parents=True)
    for number in range(4):
        (vertices, faces), new = renumbered(lump(3), seed=number)
        mesh = trimesh.Trimesh(vertices @ rotation(number).T, faces, process=False)
        (folder / f"lump{number}.off").write_text(mesh.export(file_type="off", digits=17))
        np.savetxt(folder / "corres" / f"lump{number}.vts", new + 1, fmt="%d")
        np.savetxt(folder / "corres" / f"lump{number}.sym.vts", np.roll(new, 300) + 1, fmt="%d")
    return folder
