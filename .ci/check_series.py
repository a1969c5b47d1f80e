"""Check that ParaView reads, warps and draws an exported series; called by `.ci/paraview`.

    pvbatch .ci/check_series.py SERIES.pvd FIRST LAST FRAMES PICTURE.png

FIRST and LAST are the start and end time of the series [s], FRAMES is its number of instants.
Requires ParaView 5.11 or later, not bladewhirl, and a series in which blades touch the casing.
"""

import sys

from paraview import servermanager, simple
from vtkmodules.util.numpy_support import vtk_to_numpy

ARROW = 0.1  # length of the arrow of the largest force [m]
SLACK = 1e-3  # tolerance of the first and last time, relative to the duration


def parts_of(composite):
    """Return the datasets of a multiblock by the name that ParaView shows for each block."""
    found = {}
    for number in range(composite.GetNumberOfBlocks()):
        block = composite.GetBlock(number)
        while block.IsA("vtkMultiBlockDataSet") or block.IsA("vtkMultiPieceDataSet"):
            pieces = (
                [block.GetBlock(i) for i in range(block.GetNumberOfBlocks())]
                if block.IsA("vtkMultiBlockDataSet")
                else [block.GetPiece(i) for i in range(block.GetNumberOfPieces())]
            )
            block = next(piece for piece in pieces if piece is not None)
        name = composite.GetMetaData(number).Get(composite.NAME())
        found[name] = block
    return found


def expect(held, what):
    """Print the outcome of a check; exit with code 1 if the check failed."""
    print(("ok: " if held else "FAILED: ") + what)
    if not held:
        sys.exit(1)


def points(dataset):
    """Return the points of a dataset (point, 3)."""
    return vtk_to_numpy(dataset.GetPoints().GetData())


def busiest_time(series):
    """Return the time at which most tips have a contact force, and the number of these tips."""
    best = (-1, 0.0)
    for time in series.TimestepValues:
        series.UpdatePipeline(time)
        parts = parts_of(servermanager.Fetch(series))
        force = vtk_to_numpy(parts["contact"].GetPointData().GetArray("contact_force"))
        best = max(best, (int((abs(force) > 0).any(axis=1).sum()), time))
    return best[1], best[0]


def main():
    """Open the series named on the command line; check times, parts, warping and arrows."""
    path, first, last, frames, picture = sys.argv[1:]
    first, last, frames = float(first), float(last), int(frames)
    version = simple.GetParaViewVersion()
    expect(
        version >= (5, 11) if isinstance(version, tuple) else version >= 5.11, f"version {version}"
    )

    series = simple.PVDReader(FileName=path)
    times = list(series.TimestepValues)
    slack = SLACK * (last - first)
    expect(len(times) == frames, f"{len(times)} instants")
    expect(
        abs(times[0] - first) <= slack and abs(times[-1] - last) <= slack,
        f"times from {times[0]:g} s to {times[-1]:g} s",
    )

    time, touching = busiest_time(series)
    series.UpdatePipeline(time)
    rest = parts_of(servermanager.Fetch(series))
    named = ["rotor", "casing", "contact", "supports"]
    expect(list(rest) == named, f"parts {', '.join(map(str, rest))}")
    expect(touching > 0, f"at {time:g} s {touching} blades are touched")

    moved = {name: vtk_to_numpy(p.GetPointData().GetArray("warp")) for name, p in rest.items()}
    warp = simple.WarpByVector(Input=series)
    expect(warp.Vectors[1] == "warp", "Warp By Vector selects the array warp by default")
    warp.ScaleFactor = 1.0
    warp.UpdatePipeline(time)
    warped = parts_of(servermanager.Fetch(warp))
    for name, part in rest.items():
        off = abs(points(warped[name]) - points(part) - moved[name]).max()
        far = abs(points(warped[name]) - points(part)).max()
        expect(off < 1e-6 < far, f"Warp By Vector moves {name} by up to {1e3 * far:.3g} mm")

    glyph = simple.Glyph(Input=warp, GlyphType="Arrow")
    glyph.OrientationArray = ["POINTS", "contact_force"]
    glyph.ScaleArray = ["POINTS", "contact_force"]
    glyph.GlyphMode = "All Points"
    force = vtk_to_numpy(rest["contact"].GetPointData().GetArray("contact_force"))
    largest = float((force**2).sum(axis=1).max() ** 0.5)
    glyph.ScaleFactor = ARROW / largest
    glyph.UpdatePipeline(time)
    ends = parts_of(servermanager.Fetch(glyph))["contact"]
    span = points(ends).reshape(force.shape[0], -1, 3)
    length = span.max(axis=1) - span.min(axis=1)
    drawn = int((length > 1e-6).any(axis=1).sum())
    expect(drawn == touching, f"Glyph draws {drawn} forces, up to {largest:.3g} N")

    view = simple.GetActiveViewOrCreate("RenderView")
    view.ViewSize = [1200, 900]
    view.ViewTime = time
    simple.GetAnimationScene().AnimationTime = time
    shown, arrows = simple.Show(warp, view), simple.Show(glyph, view)
    surface = rest["rotor"].GetCell(0).GetCellDimension() == 3
    simple.ColorBy(shown, ("POINTS", "surface_stress"))
    simple.Render(view)
    shown.RescaleTransferFunctionToDataRange(False, True)
    shown.SetScalarBarVisibility(view, True)
    arrows.ColorArrayName = ["POINTS", ""]
    arrows.DiffuseColor = [0.84, 0.37, 0.0]
    simple.ResetCamera(view)
    view.GetActiveCamera().Elevation(-25.0 if surface else 0.0)
    view.GetActiveCamera().Zoom(1.4)
    simple.Render(view)
    simple.SaveScreenshot(picture, view)
    print(f"wrote {picture}")


main()
