"""Response of a shaft line to engine-order forces on the blades of its wheel: Dataset, JSON
document, table, figure."""

import numpy as np
import scipy.linalg as la
import xarray as xr

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.case.case import Case
from bladewhirl.models.case.excitation import EngineOrder
from bladewhirl.models.inputs.errors import CaseError, Fault, UserError
from bladewhirl.models.shaft_line.line import LineModel, line_model
from bladewhirl.models.shaft_line.orders import moves_line, order_motion
from bladewhirl.studies.modal.study import Figures, Study
from bladewhirl.studies.runs.columns import Column, quantity, table
from bladewhirl.studies.shaft_line.modes import places

PEAKS = (
    Column("order", "engine order", "d"),
    Column("rpm", "largest at [rpm]", ".1f"),
    Column("tip", "tip [mm]", ".4g", 1e3),
    Column("hub", "hub, sideways [mm]", ".4g", 1e3),
    Column("axial", "hub, axial [mm]", ".4g", 1e3),
)


def line_order_response(case: Case, *, speeds: FloatArray) -> xr.Dataset:
    """Compute the steady motion of a shaft line by engine-order forces on the blades of its wheel.

    Over (order, speed): the largest displacements of a blade tip, tip_tangential and tip_radial,
    and of the hub, axial [m] and torsion [rad]. Over (order, speed, position): deflection, the
    largest displacement of the axis in time [m]. A tip with several contact nodes moves by their
    mean.

    Args:
        case: a case with shaft_line.wheel and excitations of engine order.
        speeds: speeds of rotation [rad/s], (speeds,).

    Raises:
        CaseError: an order moves the blades only, or the wheel has no hub.
        UserError: a speed is a resonance without damping.
    """
    line = line_model(case, float(np.abs(speeds).max(initial=0.0)))
    loads = [
        (load, order)
        for load in case.excitations.values()
        if isinstance(load, EngineOrder)
        for order in load.order
    ]
    _check_orders(line, case)
    tip = np.zeros((len(loads), len(speeds), 2))
    hub, moved = np.zeros_like(tip), np.zeros((*tip.shape[:2], len(line.position)))
    for row, (load, order) in enumerate(loads):
        for column, omega in enumerate(speeds):
            try:
                motion = order_motion(line, float(omega), load, order)
            except la.LinAlgError:
                raise UserError(
                    f"response: speed {omega:.6g} rad/s: expected another speed, or damping: order"
                    f" {order} meets a mode without damping"
                ) from None
            tip[row, column] = np.abs(motion.tip).sum(axis=0)
            hub[row, column] = abs(motion.axial), abs(motion.torsion)
            moved[row, column] = np.abs(motion.forward) + np.abs(motion.backward)
    over = ("order", "speed")
    return xr.Dataset(
        {
            "tip_radial": quantity(over, tip[..., 0], "m", "largest radial displacement of a tip"),
            "tip_tangential": quantity(
                over, tip[..., 1], "m", "largest tangential displacement of a tip"
            ),
            "axial": quantity(over, hub[..., 0], "m", "largest axial displacement of the hub"),
            "torsion": quantity(over, hub[..., 1], "rad", "largest rotation of the hub"),
            "deflection": quantity(
                (*over, "position"), moved, "m", "largest displacement of the axis"
            ),
        },
        coords={
            "order": [order for _, order in loads],
            "speed": quantity("speed", speeds * 30.0 / np.pi, "rpm", "speed of rotation"),
            "position": quantity("position", line.position, "m", "position along the shaft"),
        },
        attrs={
            "title": case.title,
            "hub_position": float(line.position[line.wheels[0].node]),
            **places(line),
        },
    )


def _check_orders(line: LineModel, case: Case) -> None:
    """Check that the engine orders of a case move the line.

    Raises:
        CaseError: an order moves the blades only.
    """
    faults = [
        Fault(
            key=f"{key}.order",
            value=order,
            expected=f"a multiple of the {case.bladed_disk.count} blades, or one more or less:"
            " other orders do not move the line; leave out [shaft_line]",
        )
        for key, load in case.excitations.items()
        if isinstance(load, EngineOrder)
        for order in load.order
        if not moves_line(line, order)
    ]
    if faults:
        raise CaseError(faults)


def report(computed: xr.Dataset) -> Study:
    """Return the document, the table of peaks, and the figure."""
    rows = []
    for number, order in enumerate(computed["order"].values.tolist()):
        own = computed.isel(order=number)
        amplitude = np.hypot(own["tip_radial"].values, own["tip_tangential"].values)
        most = int(amplitude.argmax())
        at = own.isel(speed=most)
        hub = at["deflection"].sel(position=computed.attrs["hub_position"], method="nearest")
        rows.append(
            {
                "order": order,
                "rpm": float(at["speed"]),
                "tip": float(amplitude[most]),
                "hub": float(hub),
                "axial": float(at["axial"]),
            }
        )
    names = ("tip_radial", "tip_tangential", "axial", "torsion", "deflection")
    document = {
        "rpm": computed["speed"].values.tolist(),
        "order": computed["order"].values.tolist(),
        "position": computed["position"].values.tolist(),
        **{name: computed[name].values.tolist() for name in names},
        "peaks": rows,
    }

    def figures() -> Figures:
        from bladewhirl.postprocess.shaft_line.orders import plot_line_orders

        return {"engine-orders": (plot_line_orders(computed), computed)}

    title = "Largest response to engine orders"
    return Study(
        name="response",
        document={"engine_orders": document},
        tables=[table(rows, PEAKS, title)],
        figures=figures,
    )
