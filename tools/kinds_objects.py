"""Tools, furniture, vessels and the like. They are rigid but for hinges, so their other joints turn little."""

from itertools import pairwise
from typing import Any

import numpy as np
from bodies import Bone, Kind

B = Bone


def aeroplane() -> Kind:
    """An airliner."""
    bones = [
        B("fuselage", "", (0, 0, -0.22), (0, 0, 0.25), 0.052, 0.055, 0.0),
        B("nose", "fuselage", (0, 0, 0.30), (0, -0.01, 0.40), 0.052, 0.032, 0.02),
        B("rear", "fuselage", (0, 0.0, -0.24), (0, 0.02, -0.44), 0.052, 0.026, 0.02),
        B("wing.L", "fuselage", (0.03, -0.02, 0.04), (0.26, 0.0, -0.06), 0.085, 0.055, 0.02, (0, 1, 0), 0.24, joint=(2, 4, 5)),
        B("tip.L", "wing.L", (0.27, 0.0, -0.065), (0.48, 0.02, -0.15), 0.053, 0.032, 0.0, (0, 1, 0), 0.38, joint=(2, 4, 5),
          size="wing"),
        B("engine.L", "wing.L", (0.17, -0.06, 0.07), (0.17, -0.06, -0.02), 0.034, 0.030, 0.01),
        B("plane.L", "rear", (0.015, 0.02, -0.41), (0.17, 0.03, -0.48), 0.042, 0.028, 0.015, (0, 1, 0), 0.45,
          joint=(2, 4, 4)),
        B("fin", "rear", (0, 0.05, -0.40), (0, 0.19, -0.50), 0.052, 0.032, 0.015, (1, 0, 0), 0.4),
    ]  # fmt: skip
    return Kind("aeroplane", bones, {"nose": (0, -0.01, 0.45), "wing.L": (0.52, 0.02, -0.16), "fin": (0, 0.23, -0.52)},
                bumps=0.05)  # fmt: skip


def pliers() -> Kind:
    """Two halves about a pivot; the left handle belongs to the right jaw."""
    bones = [
        B("pivot", "", (0, 0, 0), (0, 0, 0), 0.065, 0.065, 0.0, (0, 0, 1), 0.6),
        B("bolt", "pivot", (0, 0, 0.03), (0, 0, 0.05), 0.026, 0.022, 0.008),
        B("handle1_.L", "pivot", (0.035, -0.03, 0), (0.095, -0.16, 0), 0.034, 0.03, 0.02, hinge=((0, 0, 1), -4, 22),
          together="open", size="grip"),
        B("handle2_.L", "handle1_.L", (0.095, -0.16, 0), (0.105, -0.36, 0), 0.03, 0.033, 0.0, joint=(2, 0, 2), size="grip"),
        B("handle3_.L", "handle2_.L", (0.105, -0.36, 0), (0.085, -0.52, 0), 0.033, 0.028, 0.0, joint=(2, 0, 2), size="grip"),
        B("jaw1_.L", "pivot", (0.045, 0.03, 0), (0.062, 0.12, 0), 0.036, 0.034, 0.02, (0, 0, 1), 0.8,
          hinge=((0, 0, 1), -4, 22), together="-open", size="jaw"),
        B("jaw2_.L", "jaw1_.L", (0.062, 0.12, 0), (0.036, 0.27, 0), 0.034, 0.018, 0.0, (0, 0, 1), 0.9, size="jaw"),
    ]  # fmt: skip
    return Kind(
        "pliers",
        bones,
        {"handle.L": (0.08, -0.55, 0), "jaw.L": (0.035, 0.29, 0)},
        turns=2,
        bumps=0.08,
        variety=(0, 0, 10),
    )


def _ring(name: str, parent: str, centre: tuple, radius: float, thin: float, size: str) -> list[Bone]:
    """A ring of eight members in the plane z = 0."""
    angles = 2 * np.pi * np.arange(9) / 8 + np.pi / 2
    places = np.array([[np.cos(a), 1.25 * np.sin(a), 0] for a in angles]) * radius + centre
    return [
        B(f"{name}{k}_.L", parent, tuple(places[k]), tuple(places[k + 1]), thin, thin, 0.0 if k else 0.02, size=size)
        for k in range(8)
    ]


def scissors() -> Kind:
    """Two blades and two rings for fingers: two handles in the sense of topology."""
    turn = {"hinge": ((0, 0, 1), -3, 18)}
    bones = [
        B("pivot", "", (0, 0, 0), (0, 0, 0), 0.05, 0.05, 0.0, (0, 0, 1), 0.6),
        B("bolt", "pivot", (0, 0, 0.02), (0, 0, 0.035), 0.024, 0.02, 0.008),
        B("shank.L", "pivot", (0.03, -0.03, 0), (0.075, -0.17, 0), 0.028, 0.024, 0.02, together="open", size="grip", **turn),
        *_ring("ring", "shank.L", (0.115, -0.285, 0), 0.085, 0.024, "grip"),
        B("blade.L", "pivot", (0.035, 0.03, 0), (0.085, 0.42, 0), 0.034, 0.014, 0.02, (0, 0, 1), 0.7, together="-open",
          **turn),
    ]  # fmt: skip
    return Kind(
        "scissors", bones, {"blade.L": (0.087, 0.44, 0)}, turns=2, bumps=0.05, genus=2, length=1.5, variety=(0, 0, 3)
    )


def glasses() -> Kind:
    """Spectacles with lenses; upside down they are nearly the same."""
    bones = [
        B("bridge", "", (-0.09, 0, 0), (0.09, 0, 0), 0.022, 0.022, 0.0),
        B("lens.L", "bridge", (0.20, 0, 0), (0.26, 0, 0), 0.135, 0.135, 0.012, (0, 0, 1), 0.16, joint=(0, 4, 0)),
        B("rim.L", "lens.L", (0.37, 0, -0.005), (0.405, 0, -0.03), 0.03, 0.028, 0.015),
        B("temple1_.L", "rim.L", (0.41, 0, -0.04), (0.415, 0, -0.28), 0.024, 0.02, 0.01, joint=(4, (-6, 40), 0), size="temple"),
        B("temple2_.L", "temple1_.L", (0.415, 0, -0.28), (0.405, 0, -0.48), 0.02, 0.02, 0.0, joint=(4, 4, 0), size="temple"),
        B("hook.L", "temple2_.L", (0.405, 0, -0.48), (0.39, 0.0, -0.62), 0.02, 0.024, 0.0, joint=((-40, -10), 5, 0)),
    ]  # fmt: skip
    return Kind("glasses", bones, {"temple.L": (0.39, 0, -0.65), "lens.L": (0.23, 0, 0.03)}, turns=2, axis=(0, 0, 1), variety=(0, 10, 0),
                bumps=0.05)  # fmt: skip


def _lathe(name: str, profile: list[tuple[float, float]], wall: float, **more: object) -> Kind:
    """A hollow vessel of revolution: its outline as heights and radii."""
    bones = []
    for k, ((low, r0), (high, r1)) in enumerate(pairwise(profile)):
        parent = f"part{k - 1}_" if k else ""
        bones.append(
            B(f"part{k}_", parent, (0, low, 0), (0, high, 0), r0, r1, 0.03 if k else 0, joint=(2, 0, 2), size=f"p{k}")
        )
    outer = len(bones)
    # The cavity starts above the floor by its own round end.
    hollow = [(max(height, radius), radius - wall) for height, radius in profile]
    hollow = [place for place, after in pairwise(hollow) if place[0] < after[0]] + hollow[-1:]
    hollow[-1] = (hollow[-1][0] + 0.1, hollow[-1][1])
    for k, ((low, r0), (high, r1)) in enumerate(pairwise(hollow), start=len(profile) - len(hollow)):
        bones.append(B(f"inside{k}_", f"part{k}_", (0, low, 0), (0, high, 0), r0, r1, 0.015, carved=True, size=f"p{k}"))
    rim = profile[-1][0]
    bones.append(B("above", f"part{outer - 1}_", (0, rim, 0), (0, rim + 0.6, 0), 0.6, 0.6, 0.02, carved=True, box=0.01,
                   size=f"p{outer - 1}"))  # fmt: skip
    bones.append(B("below", "part0_", (0, profile[0][0] - 0.6, 0), (0, profile[0][0], 0), 0.6, 0.6, 0.02, carved=True,
                   box=0.01, size="p0"))  # fmt: skip
    return Kind(name, bones, **more)


ROUND: dict[str, Any] = {
    "landmarks": {"base": (0, 0, 0)},
    "turns": 24,
    "smooth": True,
    "length": 1.6,
    "thickness": 1.6,
    "variety": (0, 0, 0),
}
"""What vessels without a handle have in common: every turn about the axis is a symmetry."""


def vase() -> Kind:
    """A vase: every turn about its axis is a symmetry."""
    outline = [(0.0, 0.11), (0.10, 0.15), (0.30, 0.19), (0.45, 0.13), (0.58, 0.085), (0.70, 0.13)]
    return _lathe("vase", outline, 0.045, **ROUND)


def cup() -> Kind:
    """A cup without a handle."""
    outline = [(0.0, 0.13), (0.10, 0.16), (0.25, 0.19), (0.42, 0.21)]
    return _lathe("cup", outline, 0.045, **ROUND)


def mug() -> Kind:
    """A mug with a handle."""
    outline = [(0.0, 0.16), (0.12, 0.165), (0.28, 0.165), (0.42, 0.165)]
    plain = _lathe("mug", outline, 0.045)
    places = [(0.13, 0.36), (0.235, 0.37), (0.29, 0.29), (0.29, 0.19), (0.235, 0.11), (0.13, 0.10)]
    handle = [
        B(f"handle{k}", f"part{1 + (k < 3)}_", (0, b, a), (0, d, c), 0.03, 0.03, 0.02 if k in (0, 4) else 0.0, size=f"p{1 + (k < 3)}")
        for k, ((a, b), (c, d)) in enumerate(pairwise(places))
    ]  # fmt: skip
    outer = [bone for bone in plain.bones if not bone.carved]
    carved = [bone for bone in plain.bones if bone.carved]
    return Kind("mug", outer + handle + carved, {"handle": (0, 0.24, 0.32), "base": (0, 0, 0)}, genus=1, length=1.6,
                bumps=0.05)  # fmt: skip


def bone() -> Kind:
    """A thigh bone; left and right are not the same."""
    bones = [
        B("shaft", "", (0, -0.25, 0), (0, 0.25, 0), 0.048, 0.045, 0.0, joint=(2, 0, 2)),
        B("upper", "shaft", (0, 0.27, 0), (-0.01, 0.36, 0.0), 0.055, 0.062, 0.03, joint=(4, 8, 4)),
        B("trochanter", "upper", (-0.035, 0.37, 0), (-0.055, 0.41, -0.015), 0.05, 0.04, 0.03),
        B("neck", "upper", (0.03, 0.37, 0.01), (0.09, 0.42, 0.025), 0.046, 0.04, 0.03, joint=(4, 6, 4)),
        B("ball", "neck", (0.125, 0.45, 0.03), (0.13, 0.455, 0.03), 0.066, 0.066, 0.01),
        B("lower", "shaft", (0, -0.28, 0), (0, -0.38, 0.01), 0.055, 0.078, 0.03, joint=(4, 6, 4)),
        B("inner", "lower", (0.062, -0.43, -0.035), (0.062, -0.425, 0.03), 0.060, 0.055, 0.02),
        B("outer", "lower", (-0.062, -0.42, -0.025), (-0.062, -0.42, 0.04), 0.052, 0.058, 0.02),
    ]  # fmt: skip
    return Kind("bone", bones, {"ball": (0.18, 0.5, 0.04), "inner": (0.07, -0.5, -0.03)}, mirror=False, thickness=1.35)  # fmt: skip


def molar() -> Kind:
    """The crown of a tooth, an open patch with five cusps; left and right are not the same."""
    bones = [
        B("crown", "", (0, 0.0, -0.07), (0, 0.0, 0.09), 0.22, 0.21, 0.0, joint=(2, 0, 2)),
        B("low", "crown", (0, -0.2, -0.05), (0, -0.2, 0.07), 0.19, 0.18, 0.05, size="crown"),
        B("cusp1", "crown", (0.10, 0.17, 0.13), (0.115, 0.27, 0.14), 0.07, 0.035, 0.05),
        B("cusp2", "crown", (-0.10, 0.16, 0.14), (-0.11, 0.24, 0.15), 0.075, 0.04, 0.05),
        B("cusp3", "crown", (0.11, 0.16, -0.09), (0.12, 0.25, -0.10), 0.065, 0.035, 0.05),
        B("cusp4", "crown", (-0.11, 0.15, -0.10), (-0.12, 0.20, -0.11), 0.08, 0.045, 0.05),
        B("cusp5", "crown", (0.01, 0.13, -0.24), (0.01, 0.17, -0.27), 0.06, 0.04, 0.05),
    ]  # fmt: skip
    landmarks = {f"cusp{k}": tuple(bones[k + 1].tail) for k in range(1, 6)}
    return Kind("molar", bones, landmarks, mirror=False, cut=-0.16, variety=(12, 12, 12))


def chair() -> Kind:
    """Seat, back and four legs."""
    bones = [
        B("seat", "", (-0.2, 0.42, 0), (0.2, 0.42, 0), 0.03, 0.2, 0.0, (0, 1, 0), box=0.02),
        B("back1", "seat", (0, 0.45, -0.175), (0, 0.66, -0.20), 0.028, 0.19, 0.02, (0, 0, 1), box=0.02, joint=(6, 0, 0)),
        B("back2", "back1", (0, 0.62, -0.195), (0, 0.88, -0.235), 0.028, 0.19, 0.0, (0, 0, 1), box=0.02, joint=(4, 0, 0)),
        B("front.L", "seat", (0.165, 0.40, 0.165), (0.18, 0.03, 0.18), 0.032, 0.026, 0.015, joint=(3, 0, 3), size="leg"),
        B("hind.L", "seat", (0.165, 0.40, -0.165), (0.18, 0.03, -0.19), 0.032, 0.026, 0.015, joint=(3, 0, 3), size="leg"),
    ]  # fmt: skip
    return Kind(
        "chair", bones, {"front.L": (0.18, 0, 0.18), "hind.L": (0.18, 0, -0.19)}, length=1.6, thickness=1.3, bumps=0.08
    )


def table() -> Kind:
    """A top and four legs; half a turn changes nothing."""
    bones = [
        B("top", "", (-0.42, 0.5, 0), (0.42, 0.5, 0), 0.03, 0.26, 0.0, (0, 1, 0), box=0.02),
        B("front.L", "top", (0.36, 0.48, 0.20), (0.38, 0.03, 0.21), 0.036, 0.028, 0.015, joint=(3, 0, 3), size="leg"),
        B("hind.L", "top", (0.36, 0.48, -0.20), (0.38, 0.03, -0.21), 0.036, 0.028, 0.015, joint=(3, 0, 3), size="leg"),
    ]  # fmt: skip
    return Kind("table", bones, {"front.L": (0.38, 0, 0.21), "hind.L": (0.38, 0, -0.21)}, turns=2, length=1.6, thickness=1.35, variety=(0, 0, 0),
                bumps=0.08)  # fmt: skip


OBJECTS = (aeroplane, pliers, scissors, glasses, vase, cup, mug, bone, molar, chair, table)
