"""Vectors in the plane: directions, and rotation about the origin or, in space, about z."""

import numpy as np
from numpy.typing import ArrayLike

from bladewhirl.meshes.line_mesh import FloatArray


def rotate(vectors: ArrayLike, angle: ArrayLike, axis: int = -1) -> FloatArray:
    """Return vectors (..., 2), or (..., 3) with the same z, turned counter-clockwise by `angle`
    (...) [rad]; the arguments are broadcast. `axis` contains the components."""
    cos, sin = np.cos(angle), np.sin(angle)
    x, y, *rest = np.moveaxis(np.asarray(vectors, dtype=np.float64), axis, 0)
    first = cos * x - sin * y
    same = (np.broadcast_to(z, first.shape) for z in rest)
    return np.stack([first, sin * x + cos * y, *same], axis=axis)


def directions(angle: ArrayLike) -> FloatArray:
    """Return unit vectors (..., 2) at the angles (...) [rad], counter-clockwise from +x."""
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def unit(vectors: FloatArray) -> FloatArray:
    """Return vectors (..., size) divided by their lengths; vectors of zero length stay zero."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.asarray(np.divide(vectors, length, out=np.zeros_like(vectors), where=length > 0))
