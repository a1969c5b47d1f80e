"""Responses of a wheel with joints in the steps of an implicit march."""

from functools import cached_property

import numpy as np

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray
from bladewhirl.solvers.periodic.joints import JointGrid


class MarchGrid(JointGrid):
    """Responses of an implicit march: forces are constant in a step, with the value at its end, and
    slips are backward differences. All harmonics of an odd number of instants are unknown."""

    @property
    def instants(self) -> int:
        return 2 * self.harmonics + 1

    @property
    def _turn(self) -> FloatArray:
        return np.asarray(2.0 * np.pi / self.instants * self.number)

    @property
    def rates(self) -> ComplexArray:
        return np.asarray(1.0 - np.exp(-1j * self._turn))

    @property
    def turning(self) -> FloatArray:
        return np.asarray(super().turning * self._turn[1])

    @cached_property
    def _modes(self) -> ComplexArray:
        """Modal coordinates by modal forces, (harmonics + 1, modes)."""
        wave, step = self.wheel.wave(0), self.period / self.instants
        root = np.sqrt(wave.stiffness + 0j)
        ratio = np.diag(wave.damping) / 2.0 / root
        pole = root * (-ratio + 1j * np.sqrt(1.0 - ratio**2))
        z = np.exp(1j * self._turn)[:, None]
        found = np.zeros((len(z), len(root)), dtype=np.complex128)
        for one, other in ((pole, pole.conj()), (pole.conj(), pole)):
            held = (np.exp(one * step) - 1.0) / one / (one - other)
            found += held * z / (z - np.exp(one * step))
        return found

    @cached_property
    def responses(self) -> ComplexArray:
        return self.wheel.flexibilities(self.number * self.order, self._modes)

    @cached_property
    def free(self) -> ComplexArray:
        wheel, order = self.wheel, self.order
        found = np.zeros((len(self.number), wheel.values), dtype=np.complex128)
        mean = np.exp(-0.5j * self._turn[1]) * np.sinc(self._turn[1] / 2.0 / np.pi)
        modal = self._modes[1] * mean * wheel.loads[order]
        found[1] = wheel.joined(order, wheel.wave(order).rows @ modal + wheel.static[order])
        return found
