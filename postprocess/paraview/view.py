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
ARROW = 0.17  # length of the largest force, in tip radii or sizes of the blades
SIZE = [1280, 960]  # of a picture [pixels]


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
    shown = simple.Show(drawn, view)
    shown.LineWidth = 1.5
    shown.PointSize = 1.0
    simple.ColorBy(shown, ("POINTS", "displacement", "Magnitude"))
    colours = simple.GetColorTransferFunction("displacement")
    colours.AutomaticRescaleRangeMode = "Never"
    colours.ApplyPreset("Viridis (matplotlib)", True)
    colours.RescaleTransferFunction(0.0, SERIES["largest_displacement"] or 1.0)
    colours.NanColor = [0.13, 0.15, 0.18]
    shown.SetScalarBarVisibility(view, True)
    bar = simple.GetScalarBar(colours, view)
    bar.Title, bar.ComponentTitle = SERIES["scale"], ""
    bar.TitleColor = bar.LabelColor = [0.13, 0.15, 0.18]

    if SERIES["largest_force"]:
        forces = simple.Glyph(registrationName="contact forces", Input=drawn, GlyphType="Arrow")
        forces.OrientationArray = forces.ScaleArray = ["POINTS", "contact_force"]
        forces.ScaleFactor = ARROW * SERIES["size"] / SERIES["largest_force"]
        forces.GlyphMode = "All Points"
        forces.GlyphTransform.Translate = [-1.0, 0.0, 0.0]  # arrows end on the tips
        arrows = simple.Show(forces, view)
        simple.ColorBy(arrows, None)
        arrows.DiffuseColor = arrows.AmbientColor = [0.84, 0.37, 0.0]

    factor = SERIES["exaggeration"]
    note = (
        "true size" if factor == 1 else f"displacement, clearance drawn {factor:g} times as large"
    )
    words = simple.Text(registrationName="title", Text=f"{SERIES['title']}\n{note}")
    clock = simple.AnnotateTimeFilter(registrationName="time", Input=series)
    clock.Format = "t = {time:.4f} s" if simple.GetParaViewVersion() >= (5, 11) else "t = %.4f s"
    for source, place in ((words, "Upper Left Corner"), (clock, "Upper Right Corner")):
        written = simple.Show(source, view)
        written.WindowLocation = place
        written.Color = [0.13, 0.15, 0.18]
        written.Justification = "Left"

    view.CameraParallelProjection = 1
    view.ViewSize = SIZE
    view.CameraFocalPoint, view.CameraPosition = [0.0, 0.0, 0.0], SERIES["towards"]
    view.CameraViewUp = [0.0, 1.0, 0.0]
    simple.ResetCamera(view)
    view.CameraParallelScale = 1.35 * SERIES["size"]
    simple.Render(view)
    if len(sys.argv) > 1:
        simple.SaveScreenshot(sys.argv[1], view, ImageResolution=SIZE)


main()
