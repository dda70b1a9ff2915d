"""A template: one symmetric body at rest, with skeleton and skin, that can be put into poses."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from relax import Floats, Ints, relaxed
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation


@dataclass(frozen=True)
class Bone:
    """A bone: where it turns (its head at rest), where it ends, and the bone that it hangs from (or "")."""

    head: Floats
    tail: Floats
    parent: str


@dataclass(frozen=True)
class Template:
    """A body at rest; x points to the body's left, y up, z forward."""

    vertices: Floats  # (n, 3), metres
    faces: Ints  # (m, 3), outward
    bones: Mapping[str, Bone]  # parents before children
    weights: Floats  # (n, number of bones), rows sum to 1
    swell: Mapping[str, float]  # how many times smaller than elsewhere triangles shall be from these bones on

    def posed(self, turns: Mapping[str, Sequence[float]], swollen: bool = False) -> Floats:
        """Vertices (n, 3) of a pose that stands on the plane y = 0.

        A turn is a rotation vector in degrees, in the axes of the rest pose; bones further out go along.
        Swollen, the pose has larger hands, say: equal triangles on it are small triangles on the true hands.
        """
        pose = relaxed(self._skinned({}, swollen), self._skinned(turns, swollen), self.faces)
        return pose - [0, pose[:, 1].min(), 0]

    def _skinned(self, turns: Mapping[str, Sequence[float]], swollen: bool) -> Floats:
        """Linear blend skinning."""
        unknown = set(turns) - set(self.bones)
        if unknown:
            raise KeyError(f"no such bones: {sorted(unknown)}")
        rotation: dict[str, Floats] = {"": np.eye(3)}
        offset: dict[str, Floats] = {"": np.zeros(3)}
        skinned = np.zeros_like(self.vertices)
        for column, (name, bone) in enumerate(self.bones.items()):
            turn = Rotation.from_rotvec(turns.get(name, (0, 0, 0)), degrees=True).as_matrix()
            rotation[name] = rotation[bone.parent] @ turn * (self.swell.get(name, 1) if swollen else 1)
            head = rotation[bone.parent] @ bone.head + offset[bone.parent]
            offset[name] = head - rotation[name] @ bone.head
            share = self.weights[:, column, None]
            skinned += share * (self.vertices @ rotation[name].T + offset[name])
        return skinned

    def mirror(self) -> Ints:
        """For each vertex, the one on the other side of the plane x = 0 (n,)."""
        distance, twin = cKDTree(self.vertices).query(self.vertices * [-1, 1, 1])
        if distance.max() > 1e-9 or (twin[twin] != np.arange(len(twin))).any():
            raise ValueError("the template is not symmetric")
        return twin
