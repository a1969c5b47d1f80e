"""Geometry: line meshes of bladed disks and casings."""

from bladewhirl.meshes.bladed_disk import bladed_disk_mesh
from bladewhirl.meshes.casing import RingMesh
from bladewhirl.meshes.line_mesh import LineMesh

__all__ = ["LineMesh", "RingMesh", "bladed_disk_mesh"]
