"""Geometry: line meshes of bladed disks and casings."""

from bladewhirl.meshes.casing import RingMesh
from bladewhirl.meshes.curve import points_along
from bladewhirl.meshes.line_mesh import LineMesh

__all__ = ["LineMesh", "RingMesh", "points_along"]
