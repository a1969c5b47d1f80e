"""Whirling modes of a shaft line: Dataset, JSON document, table, figure."""

from typing import Any

import numpy as np
import xarray as xr

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.case.case import Case
from bladewhirl.models.shaft_line import whirl
from bladewhirl.models.shaft_line.axial import with_axial
from bladewhirl.models.shaft_line.line import LineModel, line_model
from bladewhirl.models.shaft_line.whirl import LineModes
from bladewhirl.studies.modal.study import Figures, Study
from bladewhirl.studies.runs.columns import Column, quantity, rows_of, table

COLUMNS = (
    Column("number", "mode", "d", variable="mode"),
    Column("frequency_hz", "[Hz]", ".5f", variable="frequency"),
    Column("decay_per_s", "decay [1/s]", ".5g", variable="decay"),
    Column("damping_ratio", "damping ratio", ".4g"),
    Column("direction", "whirl"),
    Column("mesh_error", "error of the mesh", ".1e"),
)
DRAWN = 6  #: largest number of modes in the figure
GROWS = 1e-9  #: growth rate divided by the frequency above which a mode grows


def line_modes(case: Case, *, count: int = 12) -> xr.Dataset:
    """Compute the modes of the shaft line of a case at the speed of the case.

    Over `mode`: frequency [Hz], decay, the real part of the eigenvalue, negative if the mode decays
    [1/s], damping_ratio and direction: forward, backward, or planar; axial or torsional with a
    wheel of six unknowns. Frequencies are those in static axes. Over (mode, instant, axis,
    position): displacement of the axis of the shaft in static axes x and y at the instant of the
    largest displacement and a quarter of a period later, without the decay; the largest one of a
    mode is 1; nan for axial and torsional ones. `mesh_error` is the relative change of the
    frequency with twice as many elements of the shaft.

    Raises:
        CaseError: the bearings do not hold the line, or the wheel has no hub.
    """
    line, finer = line_model(case), line_model(_halved(case))
    lateral = whirl.line_modes(line, line.speed, count)
    modes = with_axial(line, lateral, count)
    frequency = modes.eigenvalue.imag
    halved = with_axial(finer, whirl.line_modes(finer, line.speed, count), count).eigenvalue.imag
    halved = halved[: len(frequency)]
    moved = np.full((len(frequency), 2, 2, len(line.position)), np.nan)
    whirls = modes.row < len(lateral.eigenvalue)
    moved[whirls] = _displacement(line, lateral.take(modes.row[whirls]))
    number = np.arange(1, len(frequency) + 1)
    coarse = "relative change of the frequency with twice as many elements"
    return xr.Dataset(
        {
            "frequency": quantity("mode", frequency / (2.0 * np.pi), "Hz", "natural frequency"),
            "decay": quantity("mode", modes.eigenvalue.real, "1/s", "real part of the eigenvalue"),
            "damping_ratio": quantity(
                "mode", 0.0 - modes.eigenvalue.real / np.abs(modes.eigenvalue), "1", "damping ratio"
            ),
            "displacement": quantity(("mode", "instant", "axis", "position"), moved, "1"),
            "mesh_error": quantity("mode", np.abs(halved / frequency - 1.0), "1", coarse),
        },
        coords={
            "mode": number,
            "direction": ("mode", modes.direction),
            "instant": [0.0, 0.25],
            "axis": ["x", "y"],
            "position": quantity("position", line.position, "m", "position along the shaft"),
        },
        attrs={
            "title": case.title,
            "speed_rpm": line.speed * 30.0 / np.pi,
            "rigid_tilt": int(any(wheel.source.of_beams for wheel in line.wheels)),
        }
        | places(line),
    )


def _halved(case: Case) -> Case:
    """Return the case with twice as many elements."""
    table = case.shaft_line
    assert table is not None
    finer = [each.model_copy(update={"elements": 2 * each.elements}) for each in table.segments]
    return case.model_copy(
        update={"shaft_line": table.model_copy(update={"segments": tuple(finer)})}
    )


def _displacement(line: LineModel, modes: LineModes) -> FloatArray:
    """Return the displacement of the axis at the instant of its largest displacement in a turn and
    a quarter of a period later, (modes, 2, 2, nodes)."""
    nodes = slice(0, 2 * len(line.position), 2)
    left, right = modes.left[:, nodes], modes.right[:, nodes]
    most = (np.abs(left) + np.abs(right)).argmax(axis=1)[:, None]
    ahead, back = (np.take_along_axis(each, most, axis=1) for each in (left, right))
    turn = np.exp(0.5j * (np.angle(back) - np.angle(ahead)))
    left, right = left * turn, right / turn
    moved = np.stack([left + right, 1j * (left - right)], axis=1)
    both = np.stack([moved.real, moved.imag], axis=2)
    return np.asarray(both / (np.abs(ahead) + np.abs(back))[:, :, None, None])


def places(line: LineModel) -> dict[str, Any]:
    """Return names and positions of bearings, and positions of disks and wheels, as attributes."""
    table = line.table
    return {
        "bearings": list(table.named()),
        "bearing_position": [each.position for each in table.bearings],
        "disk_position": [
            *(one.position for one in table.disks),
            *(one.position for one in table.every_wheel),
        ],
    }


def report(computed: xr.Dataset) -> Study:
    """Return the document, the table and the figure of `line_modes`."""
    rows = rows_of(computed, COLUMNS)
    rpm = computed.attrs["speed_rpm"]
    title = f"Shaft line at {rpm:.6g} rpm"

    def figures() -> Figures:
        from bladewhirl.postprocess.shaft_line.shapes import plot_line_modes

        drawn = computed.dropna("mode", subset=["displacement"]).isel(mode=slice(DRAWN))
        return {"line-modes": (plot_line_modes(drawn), drawn)}

    return Study(
        name="modes",
        document={"speed_rpm": rpm, "shaft_line": rows},
        tables=[table(rows, COLUMNS, title)],
        figures=figures,
        hints=_hint(computed),
    )


def _hint(computed: xr.Dataset) -> str:
    notes = list[str]()
    if computed.attrs["rigid_tilt"]:
        notes.append("the wheel of beams tilts as a rigid disk")
    decay, hertz = computed["decay"].values, computed["frequency"].values
    growing = computed["mode"].values[decay > GROWS * hertz]
    if len(growing):
        notes.append(
            f"mode {growing[0]} grows: the line is unstable at this speed without more damping"
        )
    return "; ".join(notes)
