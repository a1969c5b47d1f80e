"""Vectors in the plane: directions, and rotation about the origin or, in space, about z."""

import numpy as np
from numpy.typing import ArrayLike

from bladewhirl.meshes.line_mesh import FloatArray


def rotate(vectors: ArrayLike, angle: ArrayLike, axis: int = -1) -> FloatArray:
    """Return vectors (..., 2), or (..., 3) with the same z, turned counter-clockwise by `angle`
    (...) [rad]; the arguments are broadcast. `axis` contains the components."""
    cos, sin = np.cos(angle), np.sin(angle)
    given = np.asarray(vectors, dtype=np.float64)
    if axis != -1:
        given = np.moveaxis(given, axis, -1)
    x, y = given[..., 0], given[..., 1]
    first = cos * x - sin * y
    turned = np.empty((*first.shape, given.shape[-1]))
    turned[..., 0], turned[..., 1] = first, sin * x + cos * y
    turned[..., 2:] = given[..., 2:]
    return turned if axis == -1 else np.ascontiguousarray(np.moveaxis(turned, -1, axis))


def directions(angle: ArrayLike) -> FloatArray:
    """Return unit vectors (..., 2) at the angles (...) [rad], counter-clockwise from +x."""
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def unit(vectors: FloatArray) -> FloatArray:
    """Return vectors (..., size) divided by their lengths; vectors of zero length stay zero."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.asarray(np.divide(vectors, length, out=np.zeros_like(vectors), where=length > 0))
