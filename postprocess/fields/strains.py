"""Axial and bending strain of beams and of the casing's wall, from modal coordinates.

The strain of a beam at a distance y from its axis is eps - y kappa, with the axial strain eps and
the change of curvature kappa. Both are computed by the shape functions of the finite elements
(`models.elements`), so that the strains have the strain energy of the model. For a beam of the
rotor y is positive to the left of its direction, for the casing outward. The bending strain
kappa t / 2 is the value at the right surface of a beam and at the inner surface of the casing; at
the opposite surface the bending strain has the opposite sign.

In a straight beam element of constant section eps is constant and kappa linear, so the extremes are
at the ends of the element; for a tapered beam the local thickness is used. Both strains jump from
one element to the next, so each element has its own stations.
"""

from typing import Literal, NamedTuple

import numpy as np
import xarray as xr

from bladewhirl.meshes.hermite import cubic_weights, curvature_weights, slope_weights
from bladewhirl.meshes.line_mesh import BoolArray
from bladewhirl.postprocess.fields.kinematics import (
    Array,
    IntArray,
    element_lengths,
    line_shapes,
    wall_rows,
)


class Strains(NamedTuple):
    """Axial and bending strain: for unit modal coordinates (element, station, mode) [kg^-1/2/m], or
    at some records (record, element, station) [1]."""

    axial: Array
    bending: Array

    def at(self, coordinates: Array) -> "Strains":
        """Return strains at records from strains for unit modal coordinates; `coordinates` are
        (record, mode)."""
        axial, bending = (
            (coordinates @ row.reshape(-1, row.shape[-1]).T).reshape(-1, *row.shape[:2])
            for row in self
        )
        return Strains(axial, bending)

    def at_surfaces(self, field: str, modulus: Array) -> Array:
        """Return "axial-strain", "bending-strain" [1] or "stress" [Pa] at both surfaces (record,
        element, station, side), for a Young's modulus (element, station or 1) [Pa]. The first side
        is the right side of beams and the inner side of the casing."""
        bend = self.bending[..., None] * np.array([1.0, -1.0])
        axial = self.axial[..., None] + 0.0 * bend
        if field == "bending-strain":
            return np.asarray(bend)
        return np.asarray(axial if field == "axial-strain" else modulus[..., None] * (axial + bend))


def rotor_sections(
    dataset: xr.Dataset, name: Literal["thickness", "width", "young_modulus"], pieces: int
) -> Array:
    """Return thickness or width [m] or Young's modulus [Pa] at the ends of equal pieces of every
    beam, (rotor_line, pieces + 1).
    """
    middle, change = dataset[f"rotor_{name}"].values, dataset[f"rotor_{name}_change"].values
    return np.asarray(middle[:, None] + change[:, None] * np.linspace(-0.5, 0.5, pieces + 1))


def rotor_strain_rows(dataset: xr.Dataset, per_line: int = 1) -> Strains:
    """Return strains for unit modal coordinates at the ends of `per_line` equal pieces of every
    beam: (rotor_line, per_line + 1, rotor_mode), with eps = u' and kappa = w''.
    """
    _, span, _, local, rotation = line_shapes(dataset)
    length = np.linalg.norm(span, axis=1)[:, None, None]
    x = np.linspace(0.0, 1.0, per_line + 1)
    axial = (local[:, 1, 0] - local[:, 0, 0])[:, None] / length
    curvature = np.einsum("es,lem->lsm", curvature_weights(x)[::2], local[:, :, 1]) / length**2
    curvature += np.einsum("es,lem->lsm", curvature_weights(x)[1::2], rotation) / length
    half = rotor_sections(dataset, "thickness", per_line)[..., None] / 2
    return Strains(np.repeat(axial, len(x), axis=1), half * curvature)


def surface_strain_rows(dataset: xr.Dataset, lines: IntArray, x: Array, left: BoolArray) -> Array:
    """Return strains along the surface of beams for unit modal coordinates, (point, rotor_mode).

    Args:
        dataset: a result.
        lines: number of the beam of each point, (point,).
        x: position from 0 to 1 along the beam, (point,).
        left: true on the surface to the left of the beam's direction, (point,).
    """
    ends, half = rotor_strain_rows(dataset), rotor_sections(dataset, "thickness", 1) / 2
    weights = np.stack([1.0 - x, x], axis=1)  # curvature and thickness are linear in a beam
    curvature = np.einsum("pe,pem->pm", weights, ends.bending[lines] / half[lines, :, None])
    distance = np.where(left, 1.0, -1.0) * np.sum(weights * half[lines], axis=1)
    return np.asarray(ends.axial[lines, 0] - distance[:, None] * curvature)


def casing_strain_rows(dataset: xr.Dataset, per_element: int) -> Strains:
    """Return strains for unit modal coordinates at the ends of `per_element` equal pieces of every
    casing element: (casing_node, per_element + 1, casing_mode). The axial strain is u' + w / R, the
    change of curvature w'' - u' / R or, if the case specifies the shallow arch, w''. The wall is
    thin, as in the finite elements: y / R is neglected.
    """
    radius = float(dataset.attrs["casing_radius"])
    length = element_lengths(dataset)[:, None, None]
    x = np.linspace(0.0, 1.0, per_element + 1)
    radial = wall_rows(dataset, cubic_weights(x))[:, :, 0]
    stretch = wall_rows(dataset, slope_weights(x))[:, :, 1] / length
    curvature = wall_rows(dataset, curvature_weights(x))[:, :, 0] / length**2
    if str(dataset["casing_curvature"].values) == "exact":
        curvature -= stretch / radius
    half = dataset["casing_thickness"].values[:, None, None] / 2
    return Strains(stretch + radial / radius, half * curvature)
