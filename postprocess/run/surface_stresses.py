"""Largest von Mises stress on the surface of each blade of a superelement over time.

A contact force acts on a point, at which the stress of a fine mesh has no limit. Points near
contact nodes are therefore left out.
"""

from typing import NamedTuple

import numpy as np
import xarray as xr
from scipy.spatial import KDTree

from bladewhirl.postprocess.fields.by_blade import blade_count, blade_length
from bladewhirl.postprocess.fields.kinematics import Array
from bladewhirl.postprocess.fields.point_stresses import PointStresses
from bladewhirl.postprocess.fields.points import contact_nodes, points_of
from bladewhirl.postprocess.fields.result import portions

PORTION_BYTES = 3e7  #: size of the stresses computed in one matrix product [bytes]

NEAR = 0.1
"""Distance from the nearest contact node, divided by the length of a blade, up to which points are
left out."""


class SurfaceStresses(NamedTuple):
    """Largest von Mises stress on the surface of each blade."""

    largest: Array  #: at each record [Pa], (time, blade)
    peak: Array  #: at any record [Pa], (blade,)
    time: Array  #: time of the peak [s], (blade,)
    radius: Array  #: radius of its point in the undeformed body [m], (blade,)


def surface_stresses(dataset: xr.Dataset) -> SurfaceStresses:
    """Return the largest von Mises stress on the surface of each blade, away from contact nodes.

    A point of a wheel belongs to the blade of the nearest contact node.

    Args:
        dataset: result of a superelement with stresses.
    """
    stresses, points = PointStresses(dataset), points_of(dataset, 1)
    blade, places = points.blade, points.rest
    blades, time = blade_count(dataset), dataset["time"].values
    distance = KDTree(contact_nodes(dataset)).query(places)[0]
    order = np.argsort(blade, kind="stable")
    order = order[distance[order] > NEAR * blade_length(dataset)]
    starts = np.searchsorted(blade[order], np.arange(blades))
    radius = np.hypot(*places[:, :2].T)
    largest = np.zeros((len(time), blades))
    peak, when, where = np.zeros(blades), np.zeros(blades), np.zeros(blades)
    present = np.flatnonzero(np.diff(np.append(starts, len(order))))
    for portion in portions(dataset, stresses.together(PORTION_BYTES)):
        values = stresses.at(np.arange(portion.start, portion.stop))[:, order]
        largest[portion, present] = np.maximum.reduceat(values, starts[present], axis=1)
        for number in present:
            record = int(largest[portion, number].argmax())
            if (value := largest[portion.start + record, number]) > peak[number]:
                end = np.append(starts, len(order))[number + 1]
                own = int(values[record, starts[number] : end].argmax())
                peak[number], when[number] = value, time[portion.start + record]
                where[number] = radius[order[starts[number] + own]]
    return SurfaceStresses(largest, peak, when, where)
