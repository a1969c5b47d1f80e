"""Make overhung_fan.npz: a sector of a small fan of titanium with 6 blades and a hub.

python examples/overhung_fan.py
"""

from pathlib import Path

import numpy as np
import skfem
from skfem.io.meshio import to_meshio

import bladewhirl as bw

SECTORS = 6
BORE, RIM, TIP, WIDTH = 0.025, 0.06, 0.16, 0.03  #: radii and axial width [m]
THICKNESS, LEAN = 4e-3, 0.015  #: of a blade; axial distance of its tip from the disk [m]

block = skfem.MeshHex.init_tensor(
    np.linspace(0.0, 1.0, 6), np.linspace(-0.5, 0.5, 4), np.array([-0.5, 0.5])
)
span, pitch, _ = block.p[:, block.t].mean(axis=1)
chosen = block.restrict(np.flatnonzero((span < 0.4) | (abs(pitch) < 1 / 6)))
mesh = to_meshio(skfem.MeshHex2.from_mesh(chosen))
u, v, w = mesh.points.T  # along the radius, around the axis and along the axis
radius = np.interp(u, [0.0, 0.4, 1.0], [BORE, RIM, TIP])
along = np.maximum(radius - RIM, 0.0) / (TIP - RIM)
stagger = np.radians(50.0) * along
across = 3.0 * THICKNESS * v
blade = across * np.cos(stagger) + WIDTH * w * np.sin(stagger)
share = np.minimum(4.0 * along, 1.0)
around = (1.0 - share) * radius * 2.0 * np.pi / SECTORS * v + share * blade
axial = WIDTH * w * np.cos(stagger) - across * np.sin(stagger) * share + LEAN * along
angle = around / radius
mesh.points = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), axial])
mesh.point_sets = {
    "bore": np.flatnonzero(u < 1e-9),
    "tip": np.flatnonzero((u > 1 - 1e-9) & (abs(v) < 1e-9)),
    "left": np.flatnonzero((v < -0.5 + 1e-9) & (u < 0.4 + 1e-9)),
    "right": np.flatnonzero((v > 0.5 - 1e-9) & (u < 0.4 + 1e-9)),
}
part = bw.mesh3d(
    mesh,
    young_modulus="114 GPa",
    poisson_ratio=0.32,
    density="4430 kg/m3",
    hub="bore",
    contacts=3,
    left="left",
    right="right",
    copies=SECTORS,
    name="overhung fan",
)

if __name__ == "__main__":
    bw.write_superelement(Path(__file__).with_suffix(".npz"), part)
