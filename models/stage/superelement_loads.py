"""Engine-order forces on the contact nodes of a superelement."""

from collections.abc import Iterator

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.models.case.excitation import EngineOrder
from bladewhirl.models.stage.boundary_problem import BoundaryLoad


def engine_order_loads(
    load: EngineOrder, contact: FloatArray, angle: FloatArray, blade: IntArray, speed: float
) -> Iterator[BoundaryLoad]:
    """Yield the loads of engine-order forces, two for each order.

    The force on blade n is F cos(r (Omega t + theta_n) + phase), with equal parts on its contact
    nodes; theta_n is the mean angle of these nodes. The force acts on the modes; the residual
    flexibility of the contact nodes does not respond to it.

    Args:
        load: the excitation, at the tip.
        contact: displacements of the contact nodes of a copy for unit modal coordinates
            [kg^-1/2], (3 nodes, modes).
        angle: angle of each contact node at t = 0 [rad], (copies, nodes).
        blade: blade of each contact node of a copy, (nodes,).
        speed: speed of rotation [rad/s].
    """
    inclination = {"radial": 0.0, "tangential": 0.5 * np.pi}.get(str(load.direction))
    way = float(load.direction) if inclination is None else inclination
    along = np.cos(way) * contact[::3] + np.sin(way) * contact[1::3]
    count = int(blade.max()) + 1
    member = (blade == np.arange(count)[:, None]).astype(float)
    member /= member.sum(axis=1, keepdims=True)
    middle = np.angle(np.exp(1j * angle) @ member.T)  # (copies, blades of a copy)
    factors = np.broadcast_to(np.asarray(load.factors or 1.0), middle.size).reshape(middle.shape)
    phases = np.broadcast_to(np.asarray(load.phase), middle.size).reshape(middle.shape)
    for order in load.order:
        complex_force = load.amplitude * factors * np.exp(1j * (order * middle + phases))
        modal = complex_force @ (member @ along)
        for pattern, phase in ((modal.real, 0.0), (modal.imag, 0.5 * np.pi)):
            yield BoundaryLoad(
                amplitude=pattern, frequency=order * speed, phase=phase, ramp=load.ramp
            )
