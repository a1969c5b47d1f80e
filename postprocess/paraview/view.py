"""Open the series in this folder in ParaView, drawn like the pictures of `bladewhirl render`.

    paraview --script=view.py
    pvbatch view.py PICTURE.png

Written by `bladewhirl export`; runs in ParaView's own Python, 5.11 or later.
"""

import os
import sys
from typing import Any

from paraview import simple

SERIES: dict[str, Any] = {}
ARROW = 0.17  # length of the largest force, in halves of the height of the picture
SIZE = [1280, 960]  # of a picture [pixels]
INK, FAINT = [0.13, 0.15, 0.18], [0.55, 0.58, 0.62]
GREY = [0.71, 0.73, 0.76]
PLAIN = {
    **{"casing": GREY, "hub": GREY, "shaft": GREY, "bearings": [0.5, 0.62, 0.73]},
    **{"coating": [0.78, 0.63, 0.4], "supports": INK},
}
TURNING = ("rotor", "hub", "shaft", "bearings")  # parts that are not cut open
BARS = {"rotor": 0.08, "casing": 0.52, "coating": 0.52}  # lower ends of colour scales
MARGIN = 1.2


def main() -> None:
    """Show the deformed stage at its strongest contact, with forces on the tips."""
    folder = os.path.dirname(os.path.abspath(globals().get("__file__", "view.py")))
    series = simple.PVDReader(
        registrationName="series", FileName=os.path.join(folder, "series.pvd")
    )
    view = simple.GetActiveViewOrCreate("RenderView")
    view.UseColorPaletteForBackground = 0
    view.Background = [1.0, 1.0, 1.0]
    view.OrientationAxesVisibility = 0
    scene = simple.GetAnimationScene()
    scene.UpdateAnimationUsingDataTimeSteps()
    scene.AnimationTime = SERIES["time"]

    drawn = simple.WarpByVector(registrationName="drawn", Input=series)
    drawn.Vectors = ["POINTS", "warp"]
    drawn.ScaleFactor = 1.0
    for name in SERIES["grids"]:
        if name != "contact":
            show_part(drawn, name, view)

    if SERIES["largest_force"]:
        forces = simple.Glyph(registrationName="contact forces", Input=drawn, GlyphType="Arrow")
        forces.OrientationArray = forces.ScaleArray = ["POINTS", "contact_force"]
        forces.ScaleFactor = ARROW * SERIES["size"] / SERIES["largest_force"]
        forces.GlyphMode = "All Points"
        forces.GlyphTransform.Translate = [-1.0, 0.0, 0.0]  # arrows end on the tips
        arrows = simple.Show(forces, view)
        arrows.ColorArrayName = ["POINTS", ""]
        arrows.DiffuseColor = arrows.AmbientColor = [0.84, 0.37, 0.0]

    factor = SERIES["exaggeration"]
    note = (
        "true size" if factor == 1 else f"displacement, clearance drawn {factor:g} times as large"
    )
    words = simple.Text(registrationName="title", Text=f"{SERIES['title']}\n{note}")
    clock = simple.AnnotateTimeFilter(registrationName="time", Input=series)
    clock.Format = "t = {time:.5f} s" if simple.GetParaViewVersion() >= (5, 11) else "t = %.5f s"
    for source, place in ((words, "Upper Left Corner"), (clock, "Lower Left Corner")):
        written = simple.Show(source, view)
        written.WindowLocation = place
        written.Color = INK
        written.Justification = "Left"

    view.CameraParallelProjection = 1
    view.ViewSize = SIZE
    simple.Render(view)  # the first one moves the camera
    middle = SERIES["focus"]
    view.CameraFocalPoint, view.CameraViewUp = middle, SERIES["up"]
    far = 10.0 * SERIES["size"]
    view.CameraPosition = [m + far * t for m, t in zip(middle, SERIES["towards"])]  # noqa: B905
    view.CameraParallelScale = MARGIN * SERIES["size"]
    simple.Render(view)
    if len(sys.argv) > 1:
        simple.SaveScreenshot(sys.argv[1], view, ImageResolution=SIZE)


def show_part(drawn: Any, name: str, view: Any) -> None:
    """Show a part with the colours of its own scale and with its edges; the wall is cut open."""
    part = simple.ExtractBlock(registrationName=name, Input=drawn)
    part.Selectors = [f"/Root/{name}"]
    cuts = SERIES["cuts"] if name not in TURNING else ()
    if cuts and name == "casing":  # its edges stay where it is cut open
        show_edges(simple.Clean(Input=simple.ExtractSurface(Input=part)), name, view, FAINT)
    for origin, normal in cuts:
        part = simple.Clip(registrationName=f"{name}, cut open", Input=part, ClipType="Plane")
        part.ClipType.Origin, part.ClipType.Normal = origin, normal
    look = SERIES["colours"].get(name)
    if look is not None:
        label = look["label"]
        part = simple.Calculator(registrationName=label, Input=part)
        part.ResultArrayName = label
        size = look["array"] if look["array"] == "wear" else f"mag({look['array']})"
        part.Function = f"{look['factor']!r}*{size}"
    whole = simple.Clean(Input=simple.ExtractSurface(Input=part))
    whole.Tolerance = 1e-4  # joins elements
    if name in TURNING and SERIES["solid"]:
        part = simple.GenerateSurfaceNormals(registrationName="smooth rotor", Input=whole)
        part.FeatureAngle = 35.0
    shown = simple.Show(part, view)
    shown.LineWidth = 1.0 if name == "supports" else 2.5
    shown.Ambient, shown.Diffuse = 0.35, 0.7
    if look is None:
        shown.ColorArrayName = ["POINTS", ""]
        shown.DiffuseColor = shown.AmbientColor = PLAIN.get(name, [1.0, 1.0, 1.0])
    else:
        simple.ColorBy(shown, ("POINTS", label))
        colours = simple.GetColorTransferFunction(label)
        colours.AutomaticRescaleRangeMode = "Never"
        colours.ColorSpace = "RGB"
        colours.RGBPoints = [
            value for share, *rgb in look["shades"] for value in (share * look["end"], *rgb)
        ]
        shown.SetScalarBarVisibility(view, True)
        bar = simple.GetScalarBar(colours, view)
        bar.Title, bar.ComponentTitle = label, ""
        bar.TitleColor = bar.LabelColor = INK
        bar.WindowLocation, bar.ScalarBarLength = "Any Location", 0.36
        bar.Position = [0.87, BARS[name]]
        bar.AddRangeLabels, bar.UseCustomLabels = 0, 1
        bar.CustomLabels = [look["end"] * tick / 4.0 for tick in range(5)]
    if name != "supports":
        show_edges(whole, name, view, INK)


def show_edges(surface: Any, name: str, view: Any, colour: list[float]) -> None:
    """Show the sharp edges of the surface of a part."""
    edges = simple.FeatureEdges(registrationName=f"edges of {name}", Input=surface)
    edges.BoundaryEdges = edges.NonManifoldEdges = 0
    lines = simple.Show(edges, view)
    lines.RenderLinesAsTubes, lines.LineWidth = 1, 1.3  # in front of the faces
    lines.ColorArrayName = ["POINTS", ""]
    lines.DiffuseColor = lines.AmbientColor = colour


main()
