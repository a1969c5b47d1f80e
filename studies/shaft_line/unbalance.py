"""Response of a shaft line to its unbalances: Dataset, JSON document, table, figure."""

import numpy as np
import scipy.linalg as la
import xarray as xr

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray
from bladewhirl.models.case.case import Case
from bladewhirl.models.inputs.errors import CaseError, Fault, UserError
from bladewhirl.models.shaft_line.line import LineModel, line_model
from bladewhirl.models.shaft_line.whirl import unbalance_response
from bladewhirl.studies.modal.study import Figures, Study
from bladewhirl.studies.runs.columns import Column, quantity, table
from bladewhirl.studies.shaft_line.modes import places

PEAKS = (
    Column("position", "position [m]", ".4g"),
    Column("rpm", "largest at [rpm]", ".1f"),
    Column("amplitude", "amplitude [mm]", ".4g", 1e3),
    Column("phase_deg", "phase [°]", ".1f"),
)


def line_response(case: Case, *, speeds: FloatArray) -> xr.Dataset:
    """Compute the steady whirl of the shaft line of a case by its unbalances at many speeds.

    The axis moves along static x by the real part of x exp(i Omega t), along y likewise. Over
    (speed, position): complex `x` and `y` [m] and `amplitude`, the largest displacement in a turn
    [m]. Over (speed, bearing): `bearing_force`, the largest force of the bearing on the shaft in a
    turn [N].

    Args:
        case: a case with [shaft_line] and unbalances.
        speeds: speeds of rotation [rad/s], (speeds,).

    Raises:
        CaseError: there is no unbalance, or the bearings do not hold the line.
        UserError: a speed is a critical speed of a line without damping.
    """
    line = line_model(case, float(np.abs(speeds).max(initial=0.0)))
    if not line.table.unbalance:
        expected = 'at least one row, or with a wheel excitation.type = "engine-order"'
        raise CaseError([Fault(key="shaft_line.unbalance", expected=expected)])
    nodes = slice(0, 2 * len(line.position), 2)
    along, across, forces = [], [], []
    for omega in speeds:
        try:
            ahead, back = unbalance_response(line, float(omega))
        except la.LinAlgError:
            raise UserError(
                f"response: speed {omega:.6g} rad/s: expected another speed, or bearings with"
                " damping: it is a critical speed without damping"
            ) from None
        mirrored = back.conj()
        along.append((ahead + mirrored)[nodes])
        across.append((-1j * (ahead - mirrored))[nodes])
        forces.append(_largest_force(line, ahead, back, float(omega)))
    x, y = np.array(along), np.array(across)
    over = ("speed", "position")
    return xr.Dataset(
        {
            "x": quantity(over, x, "m", "displacement along x"),
            "y": quantity(over, y, "m", "displacement along y"),
            "amplitude": quantity(over, _largest(x, y), "m", "largest displacement in a turn"),
            "bearing_force": quantity(
                ("speed", "bearing"), np.array(forces), "N", "largest force in a turn"
            ),
        },
        coords={
            "speed": quantity("speed", speeds * 30.0 / np.pi, "rpm", "speed of rotation"),
            "position": quantity("position", line.position, "m", "position along the shaft"),
            "bearing": list(line.table.named()),
        },
        attrs={"title": case.title} | places(line),
    )


def _largest(x: ComplexArray, y: ComplexArray) -> FloatArray:
    """Return the semi-major axes of ellipses with complex components."""
    square = np.abs(x) ** 2 + np.abs(y) ** 2
    return np.asarray(np.sqrt(0.5 * (square + np.abs(x**2 + y**2))))


def _largest_force(
    line: LineModel, ahead: ComplexArray, back: ComplexArray, omega: float
) -> FloatArray:
    """Return the largest force of each bearing in a turn [N], (bearings,)."""
    turn = np.exp(2j * np.pi * np.arange(360) / 360.0)
    moved = ahead[:, None] * turn + back[:, None] / turn
    rate = 1j * omega * (ahead[:, None] * turn - back[:, None] / turn)
    return np.asarray(np.abs(line.bearing_force(moved, rate)).max(axis=1))


def stations(computed: xr.Dataset) -> FloatArray:
    """Return the positions of disks and bearings [m], ascending."""
    attrs = computed.attrs
    return np.unique([*attrs["disk_position"], *attrs["bearing_position"]])


def report(computed: xr.Dataset, critical: xr.Dataset) -> Study:
    """Return the document, the table of peaks at disks and bearings, and the figure, in which the
    speeds from `line_critical_speeds` are marked."""
    rows = []
    for place in stations(computed):
        own = computed.sel(position=place, method="nearest")
        most = int(own["amplitude"].values.argmax())
        rows.append(
            {
                "position": float(place),
                "rpm": float(own["speed"][most]),
                "amplitude": float(own["amplitude"][most]),
                "phase_deg": float(np.degrees(np.angle(own["x"].values[most]))),
            }
        )
    document = {
        "rpm": computed["speed"].values.tolist(),
        "position": computed["position"].values.tolist(),
        **{
            f"{axis}_{part}": function(computed[axis].values).tolist()
            for axis in ("x", "y")
            for part, function in (("amplitude", np.abs), ("phase_rad", np.angle))
        },
        "bearing_force": computed["bearing_force"].values.tolist(),
        "bearings": list(computed.attrs["bearings"]),
        "peaks": rows,
    }

    def figures() -> Figures:
        from bladewhirl.postprocess.shaft_line.response import drawn_response, plot_line_response

        data = drawn_response(computed, stations(computed), critical)
        return {"unbalance-response": (plot_line_response(data), data)}

    title = "Largest unbalance response at disks and bearings"
    return Study(
        name="response", document=document, tables=[table(rows, PEAKS, title)], figures=figures
    )
