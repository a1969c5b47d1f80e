"""Picture of a superelement: its surface with clamped nodes, contact nodes, cut faces and axis."""

from pathlib import Path

import numpy as np
import scipy.sparse as sp
from PIL import Image

from bladewhirl.files import replacing
from bladewhirl.meshes.line_mesh import IntArray
from bladewhirl.models.superelements.superelement import FIXED, Superelement
from bladewhirl.postprocess.pictures.appearance import FAINT, FONT, INK
from bladewhirl.postprocess.pictures.offscreen import off_screen_plotter, pixels_of
from bladewhirl.postprocess.pictures.render import WINDOW
from bladewhirl.postprocess.pictures.solids import METAL, surface_of
from bladewhirl.postprocess.plotting.files import checked_target

COLOURS = {
    "clamped": "#20262e",
    "contact": "#d55e00",
    "left face": "#56b4e9",
    "right face": "#009e73",
    "axis": "#cc79a7",
}
"""Colours of the groups, in the order of the key."""

DOT = 20.0  #: diameter of nodes [rendered points]
VIEW = (1.0, -1.3, 0.9)  #: direction towards the viewer, in the axes of the superelement


def part_groups(part: Superelement) -> dict[str, IntArray]:
    """Return the points of a superelement that are clamped and those on its cut faces, by name."""
    assert part.recovery is not None
    rows = sp.csr_array(part.recovery)
    held = np.diff(rows.indptr).reshape(-1, 3).sum(axis=1) == 0
    groups = {"clamped": np.flatnonzero(held)}
    moved = sp.csr_array(abs(rows) > 0.0)
    for name in ("left", "right"):
        if (dofs := getattr(part, f"{name}_dofs")) is not None:
            own = np.zeros(part.size)
            own[dofs[dofs != FIXED]] = 1.0
            groups[f"{name} face"] = np.flatnonzero((moved @ own).reshape(-1, 3).any(axis=1))
    return groups


def draw_part(part: Superelement, path: str | Path) -> Path:
    """Draw a superelement with a surface as PNG; return the path.

    Raises:
        ViewError: the path does not end in .png.
        OffScreenError: the system cannot draw without a display.
    """
    assert part.points is not None
    assert part.triangles is not None
    target = checked_target(path, ".png")
    places = {name: part.points[nodes] for name, nodes in part_groups(part).items()}
    places["contact"] = part.contact_position
    with off_screen_plotter(WINDOW) as plotter:
        plotter.add_mesh(
            surface_of(part.points, part.triangles),
            color=METAL,
            ambient=0.4,
            show_edges=True,
            edge_color=FAINT,
        )
        for name, at in places.items():
            if len(at):
                plotter.add_points(
                    *(at,), color=COLOURS[name], point_size=DOT, render_points_as_spheres=True
                )
        low, high = part.points[:, 2].min(), part.points[:, 2].max()
        margin = 0.2 * float(np.ptp(part.points, axis=0).max())
        ends = np.array([[0.0, 0.0, low - margin], [0.0, 0.0, high + margin]])
        plotter.add_lines(ends, color=COLOURS["axis"], width=4)
        shown = [name for name in COLOURS if name == "axis" or len(places.get(name, ()))]
        plotter.add_legend(
            [[f"{name} z" if name == "axis" else name, COLOURS[name]] for name in shown],
            bcolor="white",
            face="circle",
            size=(0.15, 0.03 * len(shown)),
            loc="upper left",
        )
        legend = plotter.legend.GetEntryTextProperty()
        text = plotter.add_text(part.name, position="upper_edge", color=INK, font_size=16)
        for letters in (legend, text.prop):
            letters.SetFontFamily(4)  # that of a file
            letters.SetFontFile(FONT)
        plotter.camera_position = [VIEW, (0.0, 0.0, 0.0), (1.0, 0.0, 0.0)]
        plotter.reset_camera()
        picture = pixels_of(plotter)
    with replacing(target) as draft:
        Image.fromarray(picture).save(draft, format="png")
    return target
