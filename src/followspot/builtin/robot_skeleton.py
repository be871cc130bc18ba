"""The robot's bones: from a few joint angles and two foot places to a transform for every bone.

Angles are (roll, pitch, yaw) in degrees about X, Y and Z, applied in that order; a positive pitch
leans forward and a positive yaw turns left. Arrays hold all frames of an animation at once.
"""

from dataclasses import dataclass

import numpy as np

from followspot.arrays import Floats

SIDES = {"l": 1, "r": -1}
"""Sign of y by the suffix of a bone of a pair; index 0 and 1 where an array has a side axis."""

HIP = np.array([0.0, 4.4, 23.4])
KNEE = np.array([0.2, 4.4, 13.4])
ANKLE = np.array([0.0, 4.4, 4.2])
_SHOULDER = np.array([0.0, 10.9, 36.4])
_ELBOW = np.array([0.0, 11.2, 28.8])
_WRIST = np.array([0.0, 11.2, 20.6])
_PELVIS = np.array([0.0, 0.0, 23.4])
_WAIST = np.array([0.0, 0.0, 26.0])
_NECK = np.array([0.0, 0.0, 40.6])
_EYES = np.array([7.6, 0.0, 47.3])
_AERIAL = np.array([-0.3, 9.0, 47.0])


class Poses:
    """What moves, (f, ...) for f frames; what is not set stays at rest.

    Attributes:
        frames: f, how many frames there are.
        hips: (f, 3) units by which the pelvis is moved.
        pelvis: (f, 3) angles, in the world.
        chest: (f, 3) angles on the pelvis.
        head: (f, 3) angles on the chest.
        aerial: (f, 3) angles on the head.
        lids: (f,) 1 where the eyes are open, to 0 where they are closed.
        shoulders: (f, 2, 3) angles on the chest; a positive roll lifts the arm to its side.
        elbows: (f, 2, 3) angles on the upper arm, likewise.
        wrists: (f, 2, 3) angles on the forearm, likewise.
        feet: (f, 2, 3) units by which the ankles are moved, in the world.
        soles: (f, 2) pitch of the feet in the world; positive lifts the heel.
    """

    def __init__(self, frames: int) -> None:
        self.frames = frames
        self.hips, self.pelvis, self.chest, self.head, self.aerial = np.zeros((5, frames, 3))
        self.shoulders, self.elbows, self.wrists, self.feet = np.zeros((4, frames, 2, 3))
        self.lids, self.soles = np.ones(frames), np.zeros((frames, 2))


@dataclass(frozen=True, eq=False)
class Placed:
    """A bone in the world, frame by frame.

    Attributes:
        pivot: (3,) where it is hinged at rest.
        linear: (f, 3, 3) what turns it.
        at: (f, 3) where its pivot is.
    """

    pivot: Floats
    linear: Floats
    at: Floats

    def points(self, rest: Floats) -> Floats:
        """(f, n, 3) places of (n, 3) points at rest."""
        return (rest - self.pivot) @ self.linear.transpose(0, 2, 1) + self.at[:, None]

    def normals(self, rest: Floats) -> Floats:
        """(f, n, 3) unit normals of (n, 3) normals at rest."""
        turned = rest @ np.linalg.inv(self.linear)
        unit: Floats = turned / np.linalg.norm(turned, axis=2, keepdims=True)
        return unit

    def child(self, pivot: Floats, linear: Floats) -> "Placed":
        """The bone hinged to this one at a place at rest."""
        return Placed(pivot, self.linear @ linear, self.points(pivot[None])[:, 0])


def rotations(angles: Floats) -> Floats:
    """(..., 3, 3) rotations of (..., 3) angles: roll, pitch, yaw in degrees."""
    x, y, z = np.moveaxis(np.radians(angles), -1, 0)
    one, nought = np.ones_like(x), np.zeros_like(x)

    def matrix(*rows: Floats) -> Floats:
        return np.stack(rows, axis=-1).reshape(*x.shape, 3, 3)

    cos, sin = np.cos(x), np.sin(x)
    roll = matrix(one, nought, nought, nought, cos, -sin, nought, sin, cos)
    cos, sin = np.cos(y), np.sin(y)
    pitch = matrix(cos, nought, sin, nought, one, nought, -sin, nought, cos)
    cos, sin = np.cos(z), np.sin(z)
    yaw = matrix(cos, -sin, nought, sin, cos, nought, nought, nought, one)
    turned: Floats = yaw @ pitch @ roll
    return turned


def place_bones(poses: Poses) -> dict[str, Placed]:
    """Place every bone in every frame; of pairs, ``.l`` and ``.r``."""
    bones = {"pelvis": Placed(_PELVIS, rotations(poses.pelvis), _PELVIS + poses.hips)}
    bones["chest"] = bones["pelvis"].child(_WAIST, rotations(poses.chest))
    bones["head"] = head = bones["chest"].child(_NECK, rotations(poses.head))
    bones["antenna"] = head.child(_AERIAL, rotations(poses.aerial))
    squeezed = np.zeros((poses.frames, 3, 3)) + np.eye(3)
    squeezed[:, 2, 2] = 0.12 + 0.88 * poses.lids
    bones["eyes"] = head.child(_EYES, squeezed)
    for i, (side, sign) in enumerate(SIDES.items()):
        across = np.array([1, sign, 1])
        mirror = np.array([sign, 1, sign])  # of angles: pitch keeps its sense
        parent = bones["chest"]
        for name, pivot, angles in (
            ("upper_arm", _SHOULDER, poses.shoulders),
            ("forearm", _ELBOW, poses.elbows),
            ("hand", _WRIST, poses.wrists),
        ):
            parent = parent.child(pivot * across, rotations(angles[:, i] * mirror))
            bones[f"{name}.{side}"] = parent
        sole = poses.soles[:, i, None] * [0, 1, 0]
        foot = Placed(ANKLE * across, rotations(sole), ANKLE * across + poses.feet[:, i])
        hip = bones["pelvis"].points(HIP[None] * across)[:, 0]
        bones[f"foot.{side}"] = foot
        bones |= _leg(side, across, hip, foot.at)
    return bones


def _leg(side: str, across: Floats, hip: Floats, ankle: Floats) -> dict[str, Placed]:
    """Bend the knee forward so that thigh and shin, of fixed lengths, reach from hip to ankle.

    A leg that is too short is stretched out straight and does not reach; animations see to it that
    this never happens.
    """
    thigh, shin = np.linalg.norm(HIP - KNEE), np.linalg.norm(KNEE - ANKLE)
    distance = np.linalg.norm(ankle - hip, axis=1, keepdims=True)
    along = (ankle - hip) / distance
    outward = np.cross(along, [1.0, 0.0, 0.0])
    outward /= np.linalg.norm(outward, axis=1, keepdims=True)
    # thigh, shin and the distance make a triangle; the knee is so far down it, and so high over it
    down = (distance**2 + thigh**2 - shin**2) / (2 * distance)
    height = np.sqrt(np.maximum(thigh**2 - down**2, 0))
    knee = hip + down * along + height * np.cross(outward, along)
    rest = {"thigh": (HIP, KNEE, hip, knee), "shin": (KNEE, ANKLE, knee, ankle)}
    bones = {}
    for name, (top, bottom, high, low) in rest.items():
        at_rest = _frame((bottom - top)[None], np.array([[0.0, -1.0, 0.0]]))
        linear = _frame(low - high, outward) @ at_rest.transpose(0, 2, 1)
        bones[f"{name}.{side}"] = Placed(top * across, linear, high)
    return bones


def _frame(down: Floats, across: Floats) -> Floats:
    """(f, 3, 3) rotations whose columns are a direction, one across it, and what is left."""
    z = down / np.linalg.norm(down, axis=1, keepdims=True)
    return np.stack([np.cross(across, z), across, z], axis=2)
