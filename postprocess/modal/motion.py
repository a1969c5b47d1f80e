"""Natural and coupled modes in time, as small Datasets for pictures and time series.

A single mode is a standing wave. A pair of degenerate modes, cosine and sine mode, gives standing
and travelling waves. With the convention of `bladewhirl.models.elements.cyclic`, the cosine mode
times cos(omega t) plus the sine mode times sin(omega t) travels forward; the cosine mode times
cos(omega t) minus the sine mode times sin(omega t) travels backward.
"""

from typing import Any

import numpy as np
import xarray as xr
from scipy.integrate import cumulative_trapezoid

from bladewhirl.meshes.line_mesh import FloatArray, IntArray
from bladewhirl.models.coupling.stage_modes import StageModes
from bladewhirl.models.modal.describe import casing_arrays
from bladewhirl.models.modal.labels import Body
from bladewhirl.models.modal.modal_model import ModalModel
from bladewhirl.models.modal.modes import Direction
from bladewhirl.models.modal.whirl_modes import in_sense_of_rotation
from bladewhirl.postprocess.fields.kinematics import casing_rows, clearance_at, tip_rows
from bladewhirl.postprocess.fields.points import points_of
from bladewhirl.postprocess.fields.result import described, stage_dataset
from bladewhirl.solvers.stability.coupled_modes import CoupledMotion, RadialShapes

Wave = Direction

PICTURES = 48  #: number of records in one period of a mode
SHARE_OF_CLEARANCE = 0.7  #: largest displacement of a mode, divided by the clearance
#: largest displacement of a motion, divided by the tip radius, if the clearance is zero
SHARE_OF_RADIUS = 1e-3
BEAM_STATIONS = 8
"""Number of pieces of a beam; the largest displacement is searched at the ends of the pieces."""


def mode_motion(
    stage: ModalModel, body: Body, numbers: IntArray, *, wave: Wave, title: str
) -> xr.Dataset:
    """Return one period of a mode of the bladed disk or of the casing, in the axes of that body.

    With Coriolis forces a mode of the bladed disk is a whirling mode, which has a direction of its
    own.

    The amplitude of a mode is arbitrary: the largest displacement is seven tenths of the clearance,
    so that nothing seems to touch, or a thousandth of the tip radius if the clearance is zero, and
    the attribute `normalised` is 1. The
    body to which the mode does not belong is at rest.

    Args:
        stage: bladed disk and casing in their modes.
        body: body that moves.
        numbers: number of a single mode, or numbers of the cosine and the sine mode of a pair,
            among the modes of the body; for a whirling mode its number.
        wave: "standing" for a single mode or the cosine mode of a pair; "forward" or "backward"
            for a wave of a pair; for a whirling mode only a label.
        title: title of the motion.

    Returns:
        Dataset with geometry, modes, time, modal displacements and velocities, and gaps of tips.

    Raises:
        ValueError: `wave` is a direction of travel, but there is only a single mode.
    """
    on_disk = body == "bladed-disk"
    modes = stage.listed_modes if on_disk else stage.casing_modes
    resting = np.zeros(1, dtype=np.int64)  # of the other body
    shown = (numbers, resting)[:: 1 if on_disk else -1]
    arrays = stage.arrays(stage.listed_modes, *shown)
    attributes = _attributes(stage, float(arrays.contact_radius.max()))
    fixed = stage_dataset(arrays).assign_attrs(attributes)
    frequency = float((arrays.rotor_frequency if on_disk else arrays.casing_frequency)[0])
    time = 2.0 * np.pi / frequency * np.arange(PICTURES) / PICTURES
    # The two fields of a whirling mode are one motion, whose direction does not depend on `wave`.
    (towards,) = in_sense_of_rotation((wave,), stage.speed)
    whirls = modes.REAL_FIELDS == 2
    fields, played = (2, "forward") if whirls else (len(numbers), towards)
    shift, rate = _coordinates(frequency * time, fields, played)
    largest = (
        SHARE_OF_CLEARANCE * stage.case.casing.clearance
        or SHARE_OF_RADIUS * attributes["tip_radius"]
    )
    scale = largest / _largest(fixed, body, shift)
    moving, other = (arrays.rotor_frequency, arrays.casing_frequency)[:: 1 if on_disk else -1]
    assert moving.size == shift.shape[1]
    rest = np.zeros((PICTURES, other.size))
    displaced = (scale * shift, rest)[:: 1 if on_disk else -1]
    rates = (scale * frequency * rate, rest)[:: 1 if on_disk else -1]
    motion = {"time": time, "gap": arrays.tip_recess + _gaps(fixed, *displaced)}
    for name, position, velocity in zip(("rotor", "casing"), displaced, rates, strict=True):
        if position.size:  # a rigid wall has no modes
            motion |= {f"{name}_displacement": position, f"{name}_velocity": velocity}
    return stage_dataset(arrays, motion).assign_attrs(
        attributes, title=title, wave=wave, speed=0.0, normalised=1
    )


def shapes_dataset(stage: ModalModel, body: Body, numbers: IntArray) -> xr.Dataset:
    """Return a Dataset with shapes and purities of some modes of a body, and with the directions of
    travel of whirling modes.

    Args:
        stage: bladed disk and casing in their modes.
        body: body whose modes are returned. Modes of the bladed disk with Coriolis forces are
            whirling modes; the shape of a whirling mode is its real part.
        numbers: numbers of the modes; of each pair only one number.
    """
    if body == "casing":
        modes = stage.casing_modes
        data = described(casing_arrays(stage.casing, modes.take(numbers)))
        purity = ("casing_mode", modes.purity[numbers])
        radius = float(stage.casing.mesh.radius)
        return data.assign(casing_purity=purity).assign_attrs(_attributes(stage, radius))
    listed = stage.listed_modes
    arrays = stage.arrays(listed, numbers, np.zeros(1, dtype=np.int64))
    data = stage_dataset(arrays).assign_attrs(
        _attributes(stage, float(arrays.contact_radius.max()))
    )
    first = slice(None, None, listed.REAL_FIELDS)
    data = data.isel({"rotor_mode": first, "mode": first}, missing_dims="ignore")
    if listed.REAL_FIELDS == 2:  # they travel
        ways = [np.array(way)[numbers] for way in listed.named_directions(stage.speed)]
        data = data.assign(
            rotor_direction=("rotor_mode", ways[0]), rotor_direction_static=("rotor_mode", ways[1])
        )
    motions = stage.disk.tip_motions
    return data.assign(
        rotor_purity=("rotor_mode", listed.purity[numbers]),
        rotor_family=("rotor_mode", [listed.family[i] for i in numbers]),
        rotor_tip_motion=("rotor_mode", [motions[i] for i in numbers]),
    )


def coupled_mode_motion(stage: StageModes, motion: CoupledMotion, kappa: float) -> xr.Dataset:
    """Return the motion of a coupled mode as a Dataset.

    Args:
        stage: the coupled modes.
        motion: motion of one coupled mode, equally spaced in time.
        kappa: stiffness per radian of the springs that couple these modes [N/m].

    Returns:
        Dataset with geometry, modes, time, modal displacements and velocities, gaps of tips,
        energy, and works of modal damping and coupling.
    """
    rotor, rotor_modes = stage.coordinates(on_casing=False)
    wall, wall_modes = stage.coordinates(on_casing=True)
    angle = motion.speed * motion.time
    stiffness = stage.modes.equations.stiffness(angle, kappa, speed=motion.speed)
    strain = np.einsum("ti,tij,tj->t", motion.displacement, stiffness, motion.displacement)
    energy = 0.5 * (np.sum(motion.velocity**2, axis=1) + strain)
    power = motion.velocity**2 @ stage.modes.damping_rate[stage.modes.entry]
    lost = cumulative_trapezoid(power, motion.time, initial=0.0)
    in_time = {
        "time": motion.time,
        "rotor_displacement": motion.displacement[:, rotor],
        "rotor_velocity": motion.velocity[:, rotor],
        "casing_displacement": motion.displacement[:, wall],
        "casing_velocity": motion.velocity[:, wall],
        "gap": _coupled_gaps(stage, motion),
        "energy": energy,
        "damping_work": lost,
        "coupling_work": energy - energy[0] + lost,
    }
    arrays = stage.modal.arrays(stage.modal.disk_modes, rotor_modes, wall_modes)
    return stage_dataset(arrays, in_time).assign_attrs(
        _attributes(stage.modal, float(arrays.contact_radius.max())),
        title="coupled mode",
        speed=motion.speed,
        record_step=float(motion.time[1] - motion.time[0]),
    )


def radial_shapes(stage: StageModes) -> RadialShapes:
    """Return the displacements of shaft, tips and casing for unit coordinates of the coupled modes
    (step 4 of Section 3.3.2 of the paper).

    The displacements are computed from the finite element modes, even if the coupling is computed
    with the paper's simplification that the radial amplitude of every mode is 1.
    """
    disk, casing, size = stage.modal.beams, stage.modal.casing, stage.modes.size
    rotor, rotor_modes = stage.coordinates(on_casing=False)
    wall, wall_modes = stage.coordinates(on_casing=True)
    shapes = stage.modal.disk_modes.fields(rotor_modes)
    tips = np.zeros((len(disk.tip_angles), size))
    tips[:, rotor] = shapes[disk.tip_radial]
    centre = np.zeros((2, size))
    centre[:, rotor] = disk.cartesian(shapes)[disk.mesh.node_sets["centre"][0], :2]
    radial = np.zeros((casing.mesh.elements, size))
    radial[:, wall] = casing.nodal(stage.modal.casing_modes.fields(wall_modes))[:, 0]
    return RadialShapes(
        centre=centre,
        tips=tips,
        tip_angle=disk.tip_angles,
        casing=radial,
        casing_angle=casing.mesh.angles,
    )


def shown_clearance(stage: ModalModel) -> float:
    """Return the clearance [m], or a thousandth of the tip radius if the clearance is zero."""
    return stage.case.casing.clearance or SHARE_OF_RADIUS * stage.case.tip_radius


def _attributes(stage: ModalModel, tip_radius: float) -> dict[str, Any]:
    return {
        "case": stage.case.title,
        "reference_frequency": stage.reference_frequency,
        "casing_radius": stage.casing.mesh.radius,
        "tip_radius": tip_radius,
        "clamped": int(stage.case.shaft.clamped),
        "rotation": "clockwise" if stage.speed < 0.0 else "counter-clockwise",
    }


def _coordinates(phase: FloatArray, modes: int, wave: str) -> tuple[FloatArray, FloatArray]:
    """Return modal coordinates of unit amplitude at each phase, (pictures, modes), and their
    derivatives with respect to the phase."""
    cos, sin = np.cos(phase), np.sin(phase)
    if wave == "standing":
        still = np.zeros((len(phase), modes - 1))
        return np.column_stack([cos, still]), np.column_stack([-sin, still])
    if modes != 2:
        raise ValueError(f"a single mode is a standing wave; it has no {wave} wave")
    sense = 1.0 if wave == "forward" else -1.0
    return np.column_stack([cos, sense * sin]), np.column_stack([-sin, sense * cos])


def _largest(geometry: xr.Dataset, body: Body, coordinates: FloatArray) -> float:
    """Return the largest displacement of a body over all points and times, for coordinates
    (pictures, modes)."""
    if body == "bladed-disk":
        rows = points_of(geometry, BEAM_STATIONS).shape
    else:
        rows = casing_rows(geometry, geometry["casing_angle"].values)
    return float(np.linalg.norm(rows @ coordinates.T, axis=-2).max())


def _gaps(geometry: xr.Dataset, rotor: FloatArray, casing: FloatArray) -> FloatArray:
    """Return clearance plus wall displacement minus tip displacement at each tip, (pictures,
    blades). `tip_recess`, by which each tip lies inside the tip radius, is not included; the caller
    adds it."""
    angle = geometry["tip_angle"].values
    gap = clearance_at(geometry, angle)
    if casing.size:
        gap = gap + casing @ casing_rows(geometry, angle)[:, 0].T
    return np.asarray(gap - rotor @ tip_rows(geometry)[0].T)


def _coupled_gaps(stage: StageModes, motion: CoupledMotion) -> FloatArray:
    """Return the gap at each tip at each record, (records, blades)."""
    angle = stage.modal.beams.tip_angles + motion.speed * motion.time[:, None]
    wall = (motion.casing_wave[:, None] * np.exp(-1j * motion.nodal_diameter * angle)).real
    tips = motion.displacement @ radial_shapes(stage).tips.T
    at_rest = stage.modal.case.casing.clearance + stage.modal.beams.model.tip_recess
    return np.asarray(at_rest + wall - tips)
