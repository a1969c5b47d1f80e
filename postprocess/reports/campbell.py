"""Page of Campbell diagrams, with the values under the pointer, and a table of coincidences."""

from collections.abc import Iterator

import xarray as xr

from bladewhirl.meshes.line_mesh import BoolArray
from bladewhirl.postprocess.modal import campbell
from bladewhirl.postprocess.modal.operating_range import operating_range
from bladewhirl.postprocess.reports.page import (
    Page,
    PageSection,
    PageTable,
    ReportFigure,
    with_picture,
)

COINCIDENT = ("family", "casing_family")

CAPTION = (
    "Point at a line or a mark to see its frequency and speed. Circles are coincidences of a wave"
    " that travels forward on the casing with a wave that travels backward on the bladed disk;"
    " crosses are critical speeds."
)


def campbell_page(data: xr.Dataset) -> Page:
    """Return a page with the Campbell diagrams in both frames and a table of the coincidences, from
    `campbell`."""
    inside = campbell.in_diagram(data)
    name, operated = "operating", inside & data["in_operating_range"].values.astype(bool)
    if (ends := operating_range(data)) is None:
        name, operated, ends = "speed", inside, data.attrs["speeds"]
    count = int(operated.sum())
    return Page(
        title=f"{data.attrs['case']}, Campbell diagram",
        subject=f"Rotation effects: {data.attrs.get('rotation_effects', 'none')}",
        verdict=f"Coincidences in the {name} range: {count}",
        tone="fair" if count else "good",
        reason=(
            "Where k Ω = ω of the casing + ω of the bladed disk, the waves of both bodies travel at"
            f" the same speed and contact can drive them. The {name} range is"
            f" {ends[0]:.4g} to {ends[1]:.4g} ω₁."
        ),
        warnings=[],
        figures=[*_glance(data)],
        sections=[
            PageSection(
                name="diagrams",
                title="Campbell diagrams",
                blocks=[_diagram(data, frame) for frame in campbell.frames_of(data)],
            ),
            PageSection(name="coincidences", title="Coincidences", blocks=[_table(data, inside)]),
        ],
    )


def _glance(data: xr.Dataset) -> Iterator[tuple[str, str, str]]:
    hertz = float(data.attrs["reference_frequency_hz"])
    yield "ω₁", f"{hertz:.5g} Hz", "lowest frequency of the bladed disk, free centre"
    if "branch" not in data.dims:
        return
    names = "speed", "nodal_diameter", "family_at_rest", "family"
    parts = (data[f"critical_{name}"].values for name in names)
    for speed, k, at_rest, family in zip(*parts, strict=True):
        remark = f"{60 * hertz * speed:.1f} rpm, {at_rest} at rest, k = {k}"
        if family != at_rest:
            remark += f"; most of its strain energy there is that of the {family}"
        yield "critical speed", f"{speed:.4f} ω₁", remark
    gone = float(data.attrs["clearance_gone"])
    yield "clearance at rest used up", f"{gone:.4f} ω₁", f"{60.0 * hertz * gone:.1f} rpm"


def _table(data: xr.Dataset, inside: BoolArray) -> PageTable:
    names = ("nodal_diameter", *COINCIDENT, "normalised_speed", "speed", "in_operating_range")
    columns = (data[name].values[inside] for name in names)
    shown = len(names) - (operating_range(data) is None)
    return PageTable(
        name="all-coincidences",
        title="Coincidences by speed",
        head=("k", "bladed disk", "casing", "Ω / ω₁", "rpm", "operating range")[:shown],
        rows=[
            (str(k), family, casing, f"{ratio:.4f}", f"{rpm:.1f}", "inside" if operated else "")[
                :shown
            ]
            for k, family, casing, ratio, rpm, operated in zip(*columns, strict=True)
        ],
        numbers=True,
    )


def _diagram(data: xr.Dataset, frame: campbell.Frame) -> ReportFigure:
    title = f"{frame.capitalize()} frame"
    caption = CAPTION if frame == "rotating" else ""
    block = ReportFigure(name=f"{frame}-frame", title=title, caption=caption)
    return with_picture(block, campbell.plot_campbell(data, frame))
