"""What the tip of a blade mostly does in a mode: bending, torsion, stretching."""

import numpy as np

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray

MOST = 0.5  #: share of the squared displacement from which a motion has a name


def tip_motion(position: FloatArray, moved: ComplexArray | FloatArray) -> str:
    """Return the largest part of the motion of the contact nodes of a blade: "flapwise" across or
    "edgewise" along the chord, "torsion" about the radius, "chordwise" bending of the chord,
    "radial", or "mixed" if no part has more than half of the squared displacement; "" for nodes on
    one radius, whose chord is not known.

    The chord is the line through the nodes, seen along the radius.

    Args:
        position: positions of the nodes [m], (c, 3); the axis of rotation is z.
        moved: radial, tangential and axial displacements of the nodes, (c, 3).
    """
    radius = np.hypot(position[:, 0], position[:, 1])
    middle = np.angle(np.exp(1j * np.arctan2(position[:, 1], position[:, 0])).mean())
    around = np.angle(np.exp(1j * (np.arctan2(position[:, 1], position[:, 0]) - middle)))
    place = np.column_stack([radius * around, position[:, 2]])
    place = place - place.mean(axis=0)
    size = float(np.linalg.norm(place))
    if size <= 1e-6 * radius.max():
        return ""
    chord = np.linalg.svd(place)[2][0]
    across = np.array([-chord[1], chord[0]])
    plane = moved[:, 1:]
    mean = plane.mean(axis=0)
    turned = np.column_stack([-place[:, 1], place[:, 0]]) / size  # of unit size
    angle = np.vdot(turned, plane)
    rest = plane - mean - angle * turned
    parts = {
        "flapwise": len(plane) * abs(mean @ across) ** 2,
        "edgewise": len(plane) * abs(mean @ chord) ** 2,
        "torsion": abs(angle) ** 2,
        "chordwise": float((np.abs(rest @ across) ** 2).sum()),
        "radial": float((np.abs(moved[:, 0]) ** 2).sum()),
    }
    largest = max(parts, key=lambda name: parts[name])
    whole = float((np.abs(moved) ** 2).sum())
    return largest if parts[largest] > MOST * whole else "mixed"
