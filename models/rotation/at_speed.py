"""The bladed disk of a case, linearised about the state in which it rotates steadily."""

from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.case.case import Case
from bladewhirl.models.case.file import case_fault
from bladewhirl.models.elements.bladed_disk import BladedDiskModel
from bladewhirl.models.inputs.errors import CaseError
from bladewhirl.models.rotation.matrices import RotationMatrices, rotation_matrices


def static_displacement(
    matrices: RotationMatrices, omega: float, *, follows: bool = True
) -> FloatArray:
    """Return the static displacement u due to steady rotation, (size,).

    Args:
        matrices: matrices of the bladed disk.
        omega: speed of rotation [rad/s].
        follows: let the load increase with the displacement: (K - Omega^2 M_t) u = Omega^2 M_t X,
            see `matrices`. If false, u is proportional to Omega^2; it is then 0.02 % smaller at the
            reference frequency.
    """
    if not follows:
        return omega**2 * matrices.growth
    softened = sp.csc_array(matrices.structure.stiffness - omega**2 * matrices.mass)
    return np.asarray(spla.spsolve(softened, omega**2 * matrices.load))


def tip_growth(disk: BladedDiskModel, matrices: RotationMatrices, omega: float) -> FloatArray:
    """Return the radial growth of each tip [m], (blades,), at a speed of rotation [rad/s]."""
    return static_displacement(matrices, omega)[disk.tip_radial]


def speed_of_growth(
    disk: BladedDiskModel, matrices: RotationMatrices, gap: float | FloatArray
) -> float:
    """Return the lowest speed of rotation at which the growth of a tip equals its gap [rad/s].

    Growth is assumed to be proportional to Omega^2, which is accurate to about 0.1 %. The speed is
    infinite if no tip grows.

    Args:
        disk: the bladed disk.
        matrices: matrices of the bladed disk.
        gap: gap of each tip [m], (blades,), or one value for all tips.
    """
    rate = matrices.growth[disk.tip_radial]
    squares = np.divide(gap, rate, out=np.full(len(rate), np.inf), where=rate > 0.0)
    return float(np.sqrt(squares.min()))


@dataclass(frozen=True, kw_only=True)
class TurningDisk:
    """A bladed disk at the speed of rotation of its case."""

    disk: BladedDiskModel  #: bladed disk with K_Omega and any Coriolis forces
    matrices: RotationMatrices
    omega: float  #: speed of rotation [rad/s]

    @property
    def growth(self) -> FloatArray:
        """Radial growth of each tip [m], (blades,)."""
        return self.growth_at(self.omega)

    def growth_at(self, omega: float) -> FloatArray:
        """Return the radial growth of each tip [m], (blades,), at a speed omega [rad/s]."""
        return tip_growth(self.disk, self.matrices, omega)

    def tip_answer(self, axis: int, omega: float) -> FloatArray:
        """Return the radial displacement of each tip due to a steady unit force at the centre
        [m/N], (blades,).

        Args:
            axis: direction of the force in the rotating frame, 0 for x and 1 for y.
            omega: speed of rotation [rad/s].
        """
        force = np.zeros(self.disk.structure.size)
        force[self.disk.centre[axis]] = 1.0
        answer = spla.spsolve(self.matrices.stiffness(omega).tocsc(), force)
        return np.asarray(answer[self.disk.tip_radial])


def tip_recess(
    case: Case, disk: BladedDiskModel, turning: TurningDisk | None, omega: float | None = None
) -> FloatArray:
    """Return the distance by which each tip lies inside the radius from which the clearance is
    measured [m], (blades,).

    For a hot clearance the tip radius is the radius at rest. For a cold clearance, that is, a
    clearance measured at rest, the tip radius includes the growth at speed.

    Args:
        case: case with the clearance.
        disk: bladed disk of the case.
        turning: the same bladed disk at speed; None without rotation effects.
        omega: speed of rotation [rad/s]; the speed of the case if None.
    """
    if turning is None or case.rotation.clearance == "hot":
        return disk.model.tip_recess
    return disk.model.tip_recess - turning.growth_at(turning.omega if omega is None else omega)


def turning_disk(case: Case, at_rest: BladedDiskModel, reference: float) -> TurningDisk | None:
    """Return the bladed disk at the speed of a case; None if the case has no rotation effects.

    Args:
        case: case with the effects and the speed.
        at_rest: bladed disk of the case at rest.
        reference: reference frequency, for speeds that are given as multiples of it [rad/s].

    Raises:
        CaseError: the speed reaches the lowest critical speed, and there are no Coriolis forces.
    """
    effects = case.rotation.effects
    if effects == "none":
        return None
    omega = case.march.speed.rad_per_s(reference)
    matrices = rotation_matrices(at_rest)
    check_stable(case, matrices, omega, reference)
    disk = replace(at_rest, structure=matrices.at_speed(omega, effects))
    return TurningDisk(disk=disk, matrices=matrices, omega=omega)


def check_stable(case: Case, matrices: RotationMatrices, omega: float, reference: float) -> None:
    """Check that a bladed disk without Coriolis forces is stable at a speed omega [rad/s].

    Raises:
        CaseError: the speed reaches the lowest critical speed.
    """
    highest = np.inf
    if case.rotation.effects == "centrifugal":
        highest = lowest_critical_speed(matrices)
    if abs(omega) >= highest:
        expected = (
            f"less than {highest / reference:.6g}, the critical speed; above it only Coriolis"
            ' forces (rotation.effects = "full") stabilise the bladed disk'
        )
        raise CaseError([case_fault(case, "march.speed", expected)])


def lowest_critical_speed(matrices: RotationMatrices) -> float:
    """Return the lowest speed at which K_Omega is singular [rad/s]; infinite if there is none."""
    pulled = (matrices.mass - matrices.geometric).tocsc()
    (share,) = spla.eigsh(
        pulled,
        k=1,
        M=matrices.structure.stiffness.tocsc(),
        which="LA",
        return_eigenvectors=False,
        v0=np.random.default_rng(0).standard_normal(matrices.structure.size),
    )
    return float(1.0 / np.sqrt(share)) if share > 0.0 else np.inf
