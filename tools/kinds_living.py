"""Bodies of people and animals. Units are about the height of a person; x to the left, y up, z forward."""

import numpy as np
from bodies import Bone, Kind

B = Bone


def person() -> Kind:
    """A person with mittens."""
    bones = [
        B("hips", "", (0, 0.51, 0), (0, 0.57, 0), 0.082, 0.074, 0.03, (0, 0, 1), 0.85),
        B("belly", "hips", (0, 0.58, 0), (0, 0.66, 0), 0.07, 0.072, 0.04, (0, 0, 1), 0.85, joint=(20, 15, 12)),
        B("chest", "belly", (0, 0.68, 0), (0, 0.765, 0), 0.078, 0.08, 0.04, (0, 0, 1), 0.8, joint=(15, 15, 8)),
        B("shoulder.L", "chest", (0.03, 0.785, 0), (0.11, 0.785, 0), 0.045, 0.04, 0.03, joint=(0, 8, 10)),
        B("upperarm.L", "shoulder.L", (0.12, 0.782, 0), (0.21, 0.675, 0), 0.038, 0.03, 0.015, joint=(45, 30, (-30, 40))),
        B("forearm.L", "upperarm.L", (0.21, 0.675, 0), (0.295, 0.56, 0.01), 0.031, 0.021, 0.01,
          hinge=((-0.8, -0.6, 0), 0, 95)),
        B("hand.L", "forearm.L", (0.302, 0.548, 0.012), (0.34, 0.49, 0.02), 0.027, 0.018, 0.01, (0.8, 0.55, 0.1), 0.6,
          joint=(20, 20, 25)),
        B("thumb.L", "hand.L", (0.306, 0.545, 0.025), (0.312, 0.512, 0.062), 0.0135, 0.0125, 0.008, joint=(15, 15, 15)),
        B("neck", "chest", (0, 0.82, 0), (0, 0.87, 0.005), 0.036, 0.034, 0.03, joint=(15, 25, 12)),
        B("head", "neck", (0, 0.915, 0.012), (0, 0.945, 0.012), 0.06, 0.058, 0.02, (1, 0, 0), 0.85, joint=(15, 25, 12)),
        B("nose", "head", (0, 0.92, 0.068), (0, 0.908, 0.080), 0.010, 0.013, 0.012),
        B("ear.L", "head", (0.052, 0.93, 0.0), (0.06, 0.935, -0.004), 0.016, 0.016, 0.006, (1, 0, 0.2), 0.8),
        B("thigh.L", "hips", (0.055, 0.49, 0), (0.082, 0.275, 0.005), 0.06, 0.043, 0.02, joint=((-70, 25), 10, (-3, 25))),
        B("shin.L", "thigh.L", (0.082, 0.275, 0.005), (0.098, 0.06, -0.01), 0.043, 0.024, 0.01, joint=((0, 80), 0, 0)),
        B("foot.L", "shin.L", (0.098, 0.03, -0.01), (0.106, 0.022, 0.085), 0.028, 0.02, 0.015, joint=(25, 10, 0)),
    ]  # fmt: skip
    landmarks = {
        "head": (0, 1.0, 0.01), "nose": (0, 0.91, 0.095), "hand.L": (0.352, 0.474, 0.022), "foot.L": (0.107, 0.02, 0.105),
        "elbow.L": (0.232, 0.70, -0.02), "knee.L": (0.085, 0.275, 0.05), "chest": (0, 0.73, 0.07), "back": (0, 0.7, -0.07),
        "rump": (0, 0.52, -0.08), "belly": (0, 0.60, 0.07), "neck": (0, 0.845, -0.04),
    }  # fmt: skip
    return Kind("person", bones, landmarks)


def _four_legged(name: str, neck: float, tail: float, leg: float, ear: float, mane: float = 1.0) -> Kind:
    """A four-legged animal; lengths of neck, tail, legs and ears are given in those of a fox."""
    up = 0.55 * leg
    nx, nz = 0.20 * neck, 0.15 * neck  # the neck rises so much, and comes forward so much
    hy, hz = up + 0.06 + nx, 0.24 + nz  # the head
    ty = 0.28 * tail
    bones = [
        B("chest", "", (0, up, 0.0), (0, up - 0.01, 0.18), 0.118, 0.122, 0.0),
        B("loin", "chest", (0, up + 0.005, -0.02), (0, up + 0.02, -0.24), 0.112, 0.094, 0.02, joint=(10, 12, 5)),
        B("rump", "loin", (0, up + 0.02, -0.24), (0, up + 0.01, -0.35), 0.094, 0.094, 0.01, joint=(8, 8, 5)),
        B("neck1", "chest", (0, up + 0.06, 0.22), (0, up + 0.05 + nx / 2, 0.23 + nz / 2), 0.09 * mane, 0.07 * mane, 0.06,
          joint=((-25, 15), 20, 8)),
        B("neck2", "neck1", (0, up + 0.05 + nx / 2, 0.23 + nz / 2), (0, hy - 0.02, hz - 0.01), 0.07 * mane, 0.06, 0.02,
          joint=((-20, 20), 20, 8)),
        B("head", "neck2", (0, hy, hz + 0.01), (0, hy, hz + 0.06), 0.074, 0.066, 0.03, joint=((-20, 25), 20, 10)),
        B("snout", "head", (0, hy - 0.02, hz + 0.09), (0, hy - 0.045, hz + 0.20), 0.048, 0.030, 0.04),
        B("ear.L", "head", (0.045, hy + 0.05, hz), (0.07, hy + 0.06 + 0.10 * ear, hz - 0.01), 0.034, 0.018, 0.02,
          joint=(20, 15, 15)),
        B("tail1", "rump", (0, up + 0.05, -0.43), (0, up + 0.03, -0.44 - ty * 0.45), 0.034, 0.032, 0.04,
          joint=((-40, 40), 25, 0)),
        B("tail2", "tail1", (0, up + 0.03, -0.44 - ty * 0.45), (0, up, -0.44 - ty), 0.032, 0.026, 0.01,
          joint=((-30, 30), 30, 0)),
        B("tail3", "tail2", (0, up, -0.44 - ty), (0, up - 0.03, -0.44 - ty * 1.5), 0.026, 0.016, 0.01,
          joint=((-30, 30), 30, 0)),
        B("shoulder.L", "chest", (0.065, up, 0.17), (0.085, up - 0.12, 0.19), 0.074, 0.06, 0.03, joint=((-15, 15), 0, 4)),
        B("upperarm.L", "shoulder.L", (0.085, up - 0.12, 0.19), (0.092, 0.40 * up / 0.55 - 0.07, 0.15), 0.06, 0.045, 0.01,
          joint=((-30, 25), 0, 5)),
        B("forearm.L", "upperarm.L", (0.092, 0.40 * up / 0.55 - 0.07, 0.15), (0.092, 0.15, 0.16), 0.045, 0.03, 0.01,
          joint=((-40, 10), 0, 0)),
        B("forepaw.L", "forearm.L", (0.092, 0.15, 0.16), (0.092, 0.045, 0.165), 0.031, 0.031, 0.0, joint=((-10, 40), 0, 0)),
        B("foretoes.L", "forepaw.L", (0.092, 0.037, 0.175), (0.092, 0.031, 0.220), 0.036, 0.030, 0.02,
          joint=((-10, 20), 0, 0)),
        B("thigh.L", "rump", (0.062, up - 0.03, -0.33), (0.095, up - 0.19, -0.27), 0.09, 0.06, 0.03, joint=((-35, 25), 0, 5)),
        B("shin.L", "thigh.L", (0.095, up - 0.19, -0.27), (0.093, 0.19, -0.39), 0.06, 0.034, 0.01, joint=((-10, 35), 0, 0)),
        B("hindpaw.L", "shin.L", (0.093, 0.19, -0.39), (0.093, 0.045, -0.365), 0.034, 0.031, 0.0, joint=((-25, 15), 0, 0)),
        B("hindtoes.L", "hindpaw.L", (0.093, 0.037, -0.355), (0.093, 0.031, -0.31), 0.035, 0.030, 0.02,
          joint=((-10, 20), 0, 0)),
    ]  # fmt: skip
    landmarks = {
        "head": (0, hy + 0.08, hz + 0.02), "nose": (0, hy - 0.05, hz + 0.235), "hand.L": (0.092, 0.02, 0.25),
        "foot.L": (0.093, 0.02, -0.28), "elbow.L": (0.092, 0.40 * up / 0.55 - 0.07, 0.10), "knee.L": (0.095, up - 0.2, -0.21),
        "chest": (0, up - 0.02, 0.31), "back": (0, up + 0.12, 0.02), "rump": (0, up, -0.45), "belly": (0, up - 0.1, -0.2),
        "tail": (0, up - 0.03, -0.46 - ty * 1.5), "ear.L": (0.07, hy + 0.075 + 0.10 * ear, hz - 0.01),
        "neck": (0, up + 0.1 + nx / 2, 0.16 + nz / 2),
    }  # fmt: skip
    return Kind(name, bones, landmarks)


def quadruped() -> Kind:
    """Like a dog or a fox."""
    return _four_legged("quadruped", neck=1.0, tail=1.0, leg=1.0, ear=1.0)


def longneck() -> Kind:
    """Like a dinosaur or a giraffe: neck and tail are long."""
    return _four_legged("longneck", neck=2.3, tail=2.0, leg=1.25, ear=0.3)


def bird() -> Kind:
    """A bird with spread wings."""
    bones = [
        B("body", "", (0, 0, -0.08), (0, 0.02, 0.12), 0.10, 0.10, 0.0),
        B("neck", "body", (0, 0.06, 0.18), (0, 0.10, 0.25), 0.06, 0.05, 0.05, joint=(25, 25, 10)),
        B("head", "neck", (0, 0.12, 0.29), (0, 0.12, 0.31), 0.06, 0.058, 0.03, joint=(20, 25, 15)),
        B("beak", "head", (0, 0.11, 0.36), (0, 0.095, 0.44), 0.026, 0.013, 0.02),
        B("tail", "body", (0, 0.0, -0.2), (0, -0.02, -0.38), 0.055, 0.085, 0.04, (0, 1, 0), 0.28, joint=(25, 15, 10)),
        B("arm.L", "body", (0.07, 0.05, 0.06), (0.26, 0.07, 0.08), 0.075, 0.085, 0.03, (0, 1, 0), 0.24,
          joint=(10, 12, (-25, 30))),
        B("wing.L", "arm.L", (0.28, 0.07, 0.075), (0.46, 0.08, 0.03), 0.085, 0.075, 0.02, (0, 1, 0), 0.24,
          joint=(8, (-15, 25), (-25, 30))),
        B("tip.L", "wing.L", (0.48, 0.08, 0.02), (0.66, 0.08, -0.10), 0.07, 0.036, 0.02, (0, 1, 0), 0.36,
          joint=(5, (-10, 25), (-20, 20))),
        B("leg.L", "body", (0.045, -0.08, -0.03), (0.055, -0.17, -0.04), 0.03, 0.020, 0.02, joint=(30, 0, 10)),
        B("foot.L", "leg.L", (0.055, -0.19, -0.03), (0.06, -0.195, 0.03), 0.020, 0.018, 0.01, joint=(20, 0, 0)),
    ]  # fmt: skip
    landmarks = {
        "head": (0, 0.18, 0.3), "nose": (0, 0.095, 0.45), "hand.L": (0.69, 0.08, -0.11), "foot.L": (0.06, -0.195, 0.05),
        "elbow.L": (0.27, 0.09, 0.07), "tail": (0, -0.02, -0.46), "chest": (0, -0.02, 0.22), "back": (0, 0.11, 0),
        "belly": (0, -0.1, 0), "neck": (0, 0.15, 0.2),
    }  # fmt: skip
    return Kind("bird", bones, landmarks)


def _legs(count: int, thin: float, reach: float, waist: float, long: float) -> list[Bone]:
    """Pairs of legs of three members, spread from front to back."""
    bones = []
    for k in range(count):
        angle = np.radians(np.linspace(55, -55, count)[k])
        x, z = np.cos(angle), np.sin(angle)
        a = np.array([0.05, -0.02, waist * (1 - 2 * k / (count - 1)) * 0.5])
        b = a + np.array([reach * 0.35 * x, 0.10, reach * 0.35 * z])
        c = b + np.array([reach * 0.45 * x, -0.08, reach * 0.45 * z])
        d = c + np.array([reach * long * x, -0.18, reach * long * z])
        swing = ((-8, 8), (-16, 16), (-12, 14))
        bones += [
            B(f"coxa{k}.L", "thorax", tuple(a), tuple(b), thin * 1.3, thin * 1.1, 0.02, joint=swing, size="coxa"),
            B(
                f"femur{k}.L",
                f"coxa{k}.L",
                tuple(b),
                tuple(c),
                thin * 1.1,
                thin,
                0.005,
                joint=(5, 14, 14),
                size="femur",
            ),
            B(
                f"tibia{k}.L",
                f"femur{k}.L",
                tuple(c),
                tuple(d),
                thin,
                thin * 0.8,
                0.005,
                joint=(5, 14, 20),
                size="tibia",
            ),
        ]
    return bones


def ant() -> Kind:
    """Six legs, three parts of the body, antennae."""
    bones = [
        B("thorax", "", (0, 0, -0.11), (0, 0.01, 0.11), 0.058, 0.066, 0.0),
        B("waist", "thorax", (0, 0.0, -0.17), (0, 0.01, -0.22), 0.03, 0.034, 0.02, joint=(15, 15, 5)),
        B("abdomen", "waist", (0, 0.03, -0.33), (0, 0.03, -0.43), 0.105, 0.10, 0.02, joint=(20, 12, 5)),
        B("sting", "abdomen", (0, 0.02, -0.5), (0, 0.0, -0.57), 0.05, 0.02, 0.04),
        B("head", "thorax", (0, 0.03, 0.23), (0, 0.02, 0.29), 0.086, 0.07, 0.02, (0, 1, 0), 0.8, joint=(20, 20, 10)),
        B("jaw.L", "head", (0.03, 0.0, 0.35), (0.024, -0.01, 0.42), 0.022, 0.014, 0.015, joint=(5, 12, 0)),
        B("antenna1_.L", "head", (0.045, 0.08, 0.30), (0.10, 0.17, 0.40), 0.016, 0.015, 0.01, joint=(20, 15, 15)),
        B("antenna2_.L", "antenna1_.L", (0.10, 0.17, 0.40), (0.14, 0.14, 0.58), 0.015, 0.014, 0.004, joint=(25, 20, 0)),
        *_legs(3, 0.018, 0.5, 0.2, 0.5),
    ]  # fmt: skip
    return Kind("ant", bones, {"head": (0, 0.1, 0.25), "tail": (0, 0, -0.59)})


def spider() -> Kind:
    """Eight legs, two parts of the body."""
    bones = [
        B("thorax", "", (0, 0, -0.08), (0, 0, 0.1), 0.085, 0.08, 0.0, (0, 1, 0), 0.75),
        B("abdomen", "thorax", (0, 0.03, -0.24), (0, 0.04, -0.34), 0.12, 0.13, 0.03, joint=(15, 12, 5)),
        B("head", "thorax", (0, 0.0, 0.17), (0, 0.0, 0.2), 0.05, 0.045, 0.03, joint=(10, 10, 5)),
        B("fang.L", "head", (0.028, -0.01, 0.24), (0.022, -0.05, 0.27), 0.02, 0.016, 0.01, joint=(10, 10, 0)),
        *_legs(4, 0.019, 0.52, 0.2, 0.55),
    ]  # fmt: skip
    return Kind("spider", bones, {"head": (0, 0.04, 0.2), "tail": (0, 0.04, -0.47)})


def octopus() -> Kind:
    """Eight equal arms about an axis."""
    bones = [
        B("mantle", "", (0, 0.06, 0), (0, 0.10, 0), 0.10, 0.10, 0.0),
        B("sack", "mantle", (0, 0.20, 0), (0, 0.34, 0), 0.125, 0.14, 0.06, joint=(25, 0, 25)),
    ]  # fmt: skip
    radii, ends = [0.052, 0.045, 0.038, 0.031, 0.024, 0.017], [0.09, 0.23, 0.36, 0.48, 0.59, 0.69]
    for k in range(8):
        angle = 2 * np.pi * (k + 0.5) / 8
        out, side = np.array([np.sin(angle), 0, np.cos(angle)]), np.array([np.cos(angle), 0, -np.sin(angle)])
        for j in range(5):
            head = ends[j] * out + [0, 0.05 - 0.05 * ends[j], 0]
            tail = ends[j + 1] * out + [0, 0.05 - 0.05 * ends[j + 1], 0]
            parent = f"arm{k}_{j - 1}" if j else "mantle"
            bones.append(
                B(f"arm{k}_{j}", parent, tuple(head), tuple(tail), radii[j], radii[j + 1], 0.0 if j else 0.03,
                  joint=(0, 6 if j == 0 else 18, 0), hinge=(tuple(side), -22, 22), size="arm")
            )  # fmt: skip
    return Kind("octopus", bones, {"head": (0, 0.49, 0)}, turns=8, bumps=0.1, variety=(0, 0, 0))


def fish() -> Kind:
    """A fish; it bends to the sides."""
    bones = [
        B("trunk", "", (0, 0, 0.22), (0, 0, 0.08), 0.12, 0.15, 0.0, (1, 0, 0), 0.5),
        B("head", "trunk", (0, -0.005, 0.28), (0, -0.01, 0.40), 0.105, 0.05, 0.03, (1, 0, 0), 0.6, joint=(5, 12, 0)),
        B("middle", "trunk", (0, 0, 0.06), (0, 0, -0.14), 0.15, 0.10, 0.02, (1, 0, 0), 0.5, joint=(0, 18, 0)),
        B("stem", "middle", (0, 0, -0.16), (0, 0, -0.34), 0.09, 0.045, 0.02, (1, 0, 0), 0.55, joint=(0, 22, 0)),
        B("fluke1", "stem", (0, 0.02, -0.38), (0, 0.13, -0.50), 0.06, 0.03, 0.03, (1, 0, 0), 0.42, joint=(10, 25, 0)),
        B("fluke2", "stem", (0, -0.02, -0.38), (0, -0.11, -0.47), 0.06, 0.03, 0.03, (1, 0, 0), 0.42, joint=(10, 25, 0)),
        B("dorsal", "trunk", (0, 0.13, 0.08), (0, 0.21, -0.04), 0.07, 0.035, 0.03, (1, 0, 0), 0.36, joint=(0, 0, 12)),
        B("anal", "middle", (0, -0.11, -0.12), (0, -0.16, -0.18), 0.045, 0.028, 0.03, (1, 0, 0), 0.45, joint=(0, 0, 12)),
        B("fin.L", "trunk", (0.07, -0.05, 0.18), (0.18, -0.09, 0.10), 0.045, 0.035, 0.02, (0.3, 0.9, 0), 0.35,
          joint=(20, 20, 25)),
    ]  # fmt: skip
    return Kind("fish", bones, {"nose": (0, -0.01, 0.45), "dorsal": (0, 0.25, -0.06)})


def hand() -> Kind:
    """A hand; left and right are not the same."""
    bones = [
        B("wrist", "", (0, -0.16, 0), (0, -0.02, 0), 0.095, 0.10, 0.0, (0, 0, 1), 0.75),
        B("palm", "wrist", (0, 0.06, 0), (0.005, 0.22, 0), 0.13, 0.16, 0.06, (0, 0, 1), 0.4, joint=(35, 5, 20)),
        B("thumb1", "palm", (0.10, 0.04, 0.02), (0.20, 0.16, 0.06), 0.06, 0.045, 0.04, joint=(12, 20, 15)),
        B("thumb2", "thumb1", (0.20, 0.16, 0.06), (0.255, 0.27, 0.07), 0.044, 0.038, 0.0, hinge=((0.6, -0.3, 0.7), 0, 35)),
    ]  # fmt: skip
    for name, x, y, lean, long in (
        ("index", 0.125, 0.34, 0.20, 0.30),
        ("middle", 0.045, 0.365, 0.05, 0.34),
        ("ring", -0.04, 0.35, -0.09, 0.31),
        ("little", -0.115, 0.31, -0.25, 0.24),
    ):
        way = np.array([np.sin(lean), np.cos(lean), 0])
        along = [0, 0.45, 0.75, 1.0]
        for j in range(3):
            head, tail = (np.array([x, y, 0]) + long * along[i] * way for i in (j, j + 1))
            thick = (0.041, 0.037, 0.034, 0.029)
            parent = f"{name}{j}" if j else "palm"
            low, high, spread = ((-12, 55), (0, 55), (0, 40))[j] + ((6, 0, 0)[j],)
            bones.append(
                B(f"{name}{j + 1}", parent, tuple(head), tuple(tail), thick[j], thick[j + 1], 0.0 if j else 0.025,
                  joint=(0, 0, spread), hinge=((np.cos(lean), -np.sin(lean), 0), low, high))
            )  # fmt: skip
    landmarks = {"thumb": (0.27, 0.31, 0.07), "little": (-0.18, 0.55, 0), "wrist": (0, -0.2, 0)}
    return Kind("hand", bones, landmarks, mirror=False, length=1.3, thickness=1.3)


def teddy() -> Kind:
    """A stout toy bear."""
    bones = [
        B("belly", "", (0, 0.25, 0), (0, 0.36, 0), 0.20, 0.18, 0.0),
        B("head", "belly", (0, 0.66, 0.01), (0, 0.68, 0.01), 0.165, 0.165, 0.03, joint=(20, 30, 15)),
        B("snout", "head", (0, 0.63, 0.15), (0, 0.625, 0.20), 0.07, 0.055, 0.03),
        B("ear.L", "head", (0.13, 0.81, 0), (0.15, 0.84, 0), 0.06, 0.06, 0.02, (0, 0, 1), 0.5, joint=(15, 15, 10)),
        B("arm.L", "belly", (0.16, 0.45, 0.02), (0.27, 0.39, 0.04), 0.075, 0.07, 0.02, joint=(35, 20, (-25, 40))),
        B("hand.L", "arm.L", (0.27, 0.39, 0.04), (0.37, 0.33, 0.07), 0.07, 0.075, 0.0, joint=(20, 25, 25)),
        B("leg.L", "belly", (0.13, 0.14, 0.04), (0.20, 0.06, 0.12), 0.10, 0.085, 0.02, joint=((-30, 30), 20, 12)),
        B("foot.L", "leg.L", (0.22, 0.04, 0.16), (0.25, 0.08, 0.28), 0.085, 0.08, 0.0, joint=(20, 15, 10)),
        B("tail", "belly", (0, 0.18, -0.20), (0, 0.18, -0.23), 0.05, 0.05, 0.02),
    ]  # fmt: skip
    landmarks = {
        "head": (0, 0.84, 0), "nose": (0, 0.62, 0.25), "hand.L": (0.43, 0.29, 0.09), "foot.L": (0.26, 0.1, 0.35),
        "ear.L": (0.17, 0.9, 0), "chest": (0, 0.45, 0.17), "back": (0, 0.4, -0.2), "belly": (0, 0.25, 0.2), "tail": (0, 0.18, -0.28),
    }  # fmt: skip
    return Kind("teddy", bones, landmarks, length=1.35, thickness=1.3)


def lizard() -> Kind:
    """Low, with sprawling legs and a long tail."""
    bones = [
        B("trunk", "", (0, 0, 0.02), (0, 0, 0.16), 0.08, 0.07, 0.0, (0, 1, 0), 0.8),
        B("loin", "trunk", (0, 0, 0), (0, 0, -0.15), 0.082, 0.068, 0.02, (0, 1, 0), 0.8, joint=(5, 22, 5)),
        B("neck", "trunk", (0, 0.01, 0.20), (0, 0.015, 0.26), 0.055, 0.05, 0.03, (0, 1, 0), 0.85, joint=(12, 18, 5)),
        B("head", "neck", (0, 0.02, 0.31), (0, 0.01, 0.43), 0.06, 0.03, 0.02, (0, 1, 0), 0.75, joint=(12, 18, 10)),
        B("tail1", "loin", (0, 0, -0.22), (0, 0, -0.38), 0.05, 0.042, 0.03, joint=(8, 25, 0)),
        B("tail2", "tail1", (0, 0, -0.38), (0, 0, -0.56), 0.042, 0.032, 0.0, joint=(10, 28, 0)),
        B("tail3", "tail2", (0, 0, -0.56), (0, 0, -0.74), 0.032, 0.022, 0.0, joint=(10, 28, 0)),
        B("tail4", "tail3", (0, 0, -0.74), (0, 0, -0.92), 0.022, 0.012, 0.0, joint=(10, 28, 0)),
        *[
            bone
            for name, z, way in (("fore", 0.16, 0.06), ("hind", -0.17, -0.06))
            for bone in (
                B(f"{name}arm.L", "trunk" if z > 0 else "loin", (0.055, -0.01, z), (0.16, 0.0, z + way), 0.035, 0.028, 0.02,
                  joint=(0, 28, 14)),
                B(f"{name}shin.L", f"{name}arm.L", (0.16, 0, z + way), (0.19, -0.05, z + 0.12 + way / 2), 0.028, 0.022, 0.0,
                  joint=(10, 25, 10)),
                B(f"{name}foot.L", f"{name}shin.L", (0.195, -0.055, z + 0.135 + way / 2), (0.22, -0.06, z + 0.19 + way / 2),
                  0.026, 0.02, 0.0, (0, 1, 0), 0.7, joint=(10, 25, 0)),
            )
        ],
    ]  # fmt: skip
    landmarks = {
        "head": (0, 0.06, 0.31), "nose": (0, 0.01, 0.46), "hand.L": (0.23, -0.06, 0.40), "foot.L": (0.23, -0.06, 0.01),
        "tail": (0, 0, -0.94), "back": (0, 0.06, 0), "belly": (0, -0.06, -0.05), "elbow.L": (0.18, 0.01, 0.21),
        "knee.L": (0.18, 0.01, -0.25), "neck": (0, 0.06, 0.23), "chest": (0, -0.055, 0.16),
    }  # fmt: skip
    return Kind("lizard", bones, landmarks)


def armadillo() -> Kind:
    """An upright stout beast with shell, snout, ears, claws and tail."""
    bones = [
        B("hips", "", (0, 0.36, 0), (0, 0.42, 0), 0.125, 0.13, 0.0),
        B("chest", "hips", (0, 0.50, 0), (0, 0.62, 0.0), 0.14, 0.125, 0.04, joint=(15, 15, 8)),
        B("shell", "chest", (0, 0.47, -0.06), (0, 0.62, -0.05), 0.13, 0.11, 0.03),
        B("neck", "chest", (0, 0.72, 0.03), (0, 0.77, 0.06), 0.065, 0.06, 0.04, joint=(15, 20, 10)),
        B("head", "neck", (0, 0.83, 0.08), (0, 0.84, 0.11), 0.075, 0.07, 0.02, joint=(15, 25, 12)),
        B("snout", "head", (0, 0.815, 0.16), (0, 0.78, 0.25), 0.045, 0.028, 0.03),
        B("ear.L", "head", (0.055, 0.89, 0.06), (0.11, 0.99, 0.03), 0.035, 0.022, 0.015, (0, 0, 1), 0.6, joint=(20, 15, 20)),
        B("upperarm.L", "chest", (0.13, 0.64, 0.0), (0.25, 0.58, 0.03), 0.06, 0.048, 0.02, joint=(35, 25, (-25, 40))),
        B("forearm.L", "upperarm.L", (0.25, 0.58, 0.03), (0.34, 0.53, 0.12), 0.048, 0.042, 0.0, joint=(30, 30, 30)),
        B("hand.L", "forearm.L", (0.355, 0.52, 0.135), (0.385, 0.51, 0.17), 0.048, 0.04, 0.0, joint=(25, 25, 25)),
        B("claw1_.L", "hand.L", (0.40, 0.53, 0.19), (0.43, 0.54, 0.25), 0.019, 0.016, 0.01, joint=(15, 15, 0)),
        B("claw2_.L", "hand.L", (0.41, 0.48, 0.17), (0.46, 0.46, 0.22), 0.019, 0.016, 0.01, joint=(15, 15, 0)),
        B("thigh.L", "hips", (0.08, 0.32, 0.02), (0.14, 0.19, 0.05), 0.088, 0.065, 0.02, joint=((-40, 20), 10, (-4, 15))),
        B("shin.L", "thigh.L", (0.14, 0.19, 0.05), (0.15, 0.06, 0.0), 0.062, 0.048, 0.0, joint=((-5, 35), 0, 4)),
        B("foot.L", "shin.L", (0.15, 0.035, 0.01), (0.17, 0.03, 0.12), 0.048, 0.045, 0.01, joint=(20, 12, 0)),
        B("tail1", "hips", (0, 0.30, -0.13), (0, 0.22, -0.26), 0.065, 0.045, 0.03, joint=(20, 20, 0)),
        B("tail2", "tail1", (0, 0.22, -0.26), (0, 0.19, -0.42), 0.045, 0.022, 0.0, joint=(25, 25, 0)),
    ]  # fmt: skip
    landmarks = {
        "head": (0, 0.91, 0.08), "nose": (0, 0.77, 0.28), "hand.L": (0.42, 0.5, 0.21), "foot.L": (0.175, 0.03, 0.165),
        "elbow.L": (0.26, 0.6, -0.01), "knee.L": (0.15, 0.2, 0.11), "ear.L": (0.12, 1.01, 0.03), "tail": (0, 0.19, -0.45),
        "chest": (0, 0.58, 0.14), "back": (0, 0.55, -0.18), "belly": (0, 0.42, 0.13), "neck": (0, 0.76, -0.02),
    }  # fmt: skip
    return Kind("armadillo", bones, landmarks, length=1.4)


def bust() -> Kind:
    """Head and shoulders on a flat base."""
    bones = [
        B("shoulders", "", (0, 0.10, 0), (0, 0.12, 0), 0.16, 0.15, 0.0, (0, 0, 1), 0.7),
        B("arm.L", "shoulders", (0.10, 0.11, 0), (0.24, 0.08, 0), 0.11, 0.095, 0.04, joint=(0, 8, 8)),
        B("neck", "shoulders", (0, 0.26, -0.01), (0, 0.36, 0.01), 0.085, 0.08, 0.05, joint=(14, 22, 10)),
        B("head", "neck", (0, 0.50, 0.02), (0, 0.60, 0.015), 0.15, 0.155, 0.03, (1, 0, 0), 0.82, joint=(12, 18, 8)),
        B("chin", "head", (0, 0.40, 0.10), (0, 0.385, 0.12), 0.06, 0.05, 0.06),
        B("nose", "head", (0, 0.57, 0.165), (0, 0.51, 0.195), 0.018, 0.032, 0.03),
        B("brow.L", "head", (0.02, 0.60, 0.16), (0.075, 0.60, 0.135), 0.02, 0.018, 0.02),
        B("ear.L", "head", (0.13, 0.56, 0.0), (0.145, 0.50, 0.005), 0.042, 0.03, 0.015, (1, 0, 0.4), 0.5, joint=(5, 12, 5)),
        B("base", "shoulders", (0, -0.35, 0), (0, -0.0, 0), 0.5, 0.5, 0.02, (0, 0, 1), carved=True, box=0.01,
          size="shoulders"),
    ]  # fmt: skip
    landmarks = {
        "head": (0, 0.76, 0.0), "nose": (0, 0.5, 0.23), "ear.L": (0.17, 0.53, 0), "chest": (0, 0.1, 0.11),
        "neck": (0, 0.31, -0.09), "back": (0, 0.1, -0.11),
    }  # fmt: skip
    return Kind("bust", bones, landmarks, length=1.3, thickness=1.3)


LIVING = (person, quadruped, longneck, bird, ant, spider, octopus, fish, hand, teddy, lizard, armadillo, bust)
