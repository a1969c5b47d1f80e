"""Make twisted_blade.npz: a twisted blade of titanium, of eight hexahedra, at 7000 rpm.

python examples/twisted_blade.py
"""

from dataclasses import replace
from pathlib import Path

import numpy as np
import skfem
from skfem.io.meshio import to_meshio

import bladewhirl as bw

ROOT, TIP, CHORD = 0.18, 0.3, 0.06  #: radii of root and tip, and chord [m]
THICKNESS = 6e-3, 3e-3  #: at root and tip [m]
STAGGER = np.radians([25.0, 55.0])  #: angle of the chord from the axis at root and tip

block = skfem.MeshHex.init_tensor(
    np.linspace(0.0, 1.0, 5), np.linspace(-0.5, 0.5, 3), np.array([-0.5, 0.5])
)
mesh = to_meshio(skfem.MeshHex2.from_mesh(block))
s, c, t = mesh.points.T  # along the span, along the chord and through the thickness
stagger, thickness = np.interp(s, [0, 1], STAGGER), np.interp(s, [0, 1], THICKNESS)
y = CHORD * c * np.sin(stagger) + thickness * t * np.cos(stagger)
z = CHORD * c * np.cos(stagger) - thickness * t * np.sin(stagger)
mesh.points = np.column_stack([np.sqrt((ROOT + (TIP - ROOT) * s) ** 2 - y**2), y, z])
mesh.point_sets = {"root": np.flatnonzero(s < 1e-9), "tip": np.flatnonzero(s > 1 - 1e-9)}
part = bw.mesh3d(
    mesh,
    young_modulus="114 GPa",
    poisson_ratio=0.32,
    density="4430 kg/m3",
    contacts=5,
    speed="7000 rpm",
    stress=True,
    name="twisted blade",
)
part = replace(part, speed=None)  # the cases with this blade run near 7000 rpm, not at it alone

if __name__ == "__main__":
    bw.write_superelement(Path(__file__).with_suffix(".npz"), part)
