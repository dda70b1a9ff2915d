"""A picture of families: a row of instances for each kind, as they would stand.

python tools/contact_sheet.py OUT docs/images/families.jpg
"""

import argparse
import json
from pathlib import Path

import igl
import numpy as np
import trimesh
from PIL import Image, ImageDraw
from relax import Floats, Ints

from mobius_match.exporting.rendering import LIGHT, Shape, rasterise, unit

SIZE = 104  # pixels of one picture; it is drawn twice as large
SHOWN = 4  # instances of a kind
COLUMNS = 3  # kinds beside each other
TITLE = 14  # pixels
VIEWS = {"bone": (0.2, 0.1), "pliers": (0.3, 0.1), "scissors": (0.3, 0.1), "hand": (0.3, 0.1), "fish": (1.0, 0.2),
         "lizard": (0.7, 0.7), "ant": (0.6, 0.6), "spider": (0.6, 0.6), "octopus": (0.6, 0.5), "bird": (0.5, 0.5),
         "aeroplane": (0.6, 0.5), "molar": (0.5, 0.5), "vase": (0.5, 0.35), "cup": (0.5, 0.35)}  # fmt: skip


def upright(posed: Floats, rest: Floats) -> Floats:
    """The rotation (3, 3) that takes an instance back to how its kind stands (Kabsch)."""
    left, _, right = np.linalg.svd((posed - posed.mean(axis=0)).T @ (rest - rest.mean(axis=0)))
    return left @ np.diag([1, 1, np.linalg.det(left @ right)]) @ right


def picture(vertices: Floats, faces: Ints, view: tuple[float, float]) -> Image.Image:
    """One shaded surface."""
    normals = igl.per_vertex_normals(np.ascontiguousarray(vertices), faces)
    nothing = np.zeros(0, np.int64)
    shape = Shape(vertices.astype(np.float32), faces.astype(np.int32), normals.astype(np.float32), nothing)
    shape = shape.turned(*view)
    size = 2 * SIZE
    flat = shape.vertices[:, :2]
    scale = 0.94 * size / np.ptp(flat, axis=0).max()
    pixels = np.column_stack([flat * scale + size / 2, shape.vertices[:, 2] * scale]).astype(np.float32)
    depth, facing = rasterise(pixels, shape, (size, size))
    shade = 0.35 + 0.65 * np.clip(unit(facing.reshape(-1, 3)).reshape(facing.shape) @ LIGHT, 0, 1)
    colours = np.where(np.isfinite(depth)[..., None], shade[..., None] * [198, 204, 216], 255)
    return Image.fromarray(colours[::-1].astype(np.uint8)).resize((SIZE, SIZE), Image.Resampling.LANCZOS)


def main() -> None:
    """Draw all families of a folder."""
    parser = argparse.ArgumentParser(description="A picture of families of shapes.")
    parser.add_argument("folder", type=Path, help="that tools/families.py wrote")
    parser.add_argument("picture", type=Path, help="PNG or JPEG file to write")
    given = parser.parse_args()
    kinds = sorted(path.parent for path in given.folder.glob("*/family.json"))
    rows = -(-len(kinds) // COLUMNS)
    sheet = Image.new("RGB", (COLUMNS * SHOWN * SIZE, rows * (SIZE + TITLE)), "white")
    for place, kind in enumerate(kinds):
        x, y = place % COLUMNS * SHOWN * SIZE, place // COLUMNS * (SIZE + TITLE)
        name = json.loads((kind / "family.json").read_text())["kind"]
        ImageDraw.Draw(sheet).text((x + 4, y + 1), name, fill="black")
        rest = trimesh.load(kind / "truth" / "template.ply", process=False).vertices
        for number, path in enumerate(sorted(kind.glob("*.ply"))[:SHOWN]):
            mesh = trimesh.load(path, process=False)
            posed = np.load(kind / "truth" / f"{path.stem}.npz")["posed"].astype(float)
            turned = mesh.vertices @ upright(posed, rest)
            sheet.paste(picture(turned, mesh.faces, VIEWS.get(name, (0.6, 0.25))), (x + number * SIZE, y + TITLE))
    sheet.save(given.picture, quality=82)


if __name__ == "__main__":
    main()
