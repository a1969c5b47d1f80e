"""What each mode does in contact: clearance that it consumes, friction that locks it, and its
frequency with held tips."""

import numpy as np
import xarray as xr

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.models.modal.labels import names_of
from bladewhirl.models.modal.modal_model import ModalModel
from bladewhirl.models.modal.touching import Tips, held
from bladewhirl.models.stage.modal import Modelled, modal_model
from bladewhirl.studies.modal.study import Study
from bladewhirl.studies.runs.columns import Column, quantity, rows_of, table

PHASES = 720  #: number of instants of a period at which the motion of the tips is computed

SMALL = 1e-9  #: displacement that is a rounding error, as a fraction of the largest of the tips

COLUMNS = (
    Column("family", "family"),
    Column("nodal_diameter", "k", "d"),
    Column("frequency_hz", "free tips [Hz]", ".2f", variable="frequency"),
    Column("held_frequency_hz", "held tips [Hz]", ".2f", variable="held_frequency"),
    Column("clearance_consumption", "clearance consumption", ".4f"),
    Column("locking_friction", "locking friction", ".3g"),
)
"""Columns of modes in contact."""


def contact_modes(case_or_stage: Modelled, *, families: int = 3) -> xr.Dataset:
    """Compute what the modes of the bladed disk do in contact, at the speed of the case, without
    Coriolis forces.

    Over `mode`, family by family:

    - frequency and held_frequency [Hz], with free tips and with tips held in the direction normal
      to the wall: while tips touch for a part of the time, the frequency lies in between;
    - clearance_consumption: growth of the radius of a tip in a period, divided by the largest
      displacement of the tips, with the clearance as this displacement. It includes what is of
      second order in the displacement: a tip that moves along a tangent comes nearer to the wall.
      On a cone the motion along the axis counts too;
    - locking_friction: friction coefficient above which friction pushes the tip outward more than
      the normal force pushes it inward, in this mode alone; infinite for a mode that does not lock.

    Args:
        case_or_stage: a case with equal blades, or its stage.
        families: number of families.

    Raises:
        CaseError: the modes cannot be computed.
        UserError: blades differ.
    """
    model = modal_model(case_or_stage, families=families)
    model = model.covering(abs(model.speed))
    waves, tips, names = model.waves, model.disk.tips, names_of(model.disk_modes)
    speed = model.speed if model.turns else 0.0
    ranks = {f"{rank}F": rank for rank in range(1, families + 1)}
    rows = []
    for k, wave in waves.items():
        free, shapes = _modes(wave.mass, wave.stiffness_at(speed))
        touching = held(wave, tips[k])
        stiff, _ = _modes(touching.mass, touching.stiffness_at(speed))
        for place, family in enumerate(names[k]):
            if family not in ranks and family != "suspension":
                continue
            contact = tips[k].contact @ shapes[:, place]
            consumed = _consumption(model, tips[k], contact)
            locks = _locking(contact, np.sign(model.speed))
            order = ranks.get(family, 0), k
            rows.append((order, family, k, free[place], stiff[place], consumed, locks))
    rows.sort(key=lambda row: row[0])
    _, named, diameter, frequency, held_at, consumption, locking = zip(*rows, strict=True)
    hertz, along = 2.0 * np.pi, "mode"
    return xr.Dataset(
        {
            "frequency": quantity(along, np.array(frequency) / hertz, "Hz", "free tips"),
            "held_frequency": quantity(along, np.array(held_at) / hertz, "Hz", "held tips"),
            "clearance_consumption": quantity(along, np.array(consumption), "1"),
            "locking_friction": quantity(along, np.array(locking), "1"),
        },
        coords={
            "family": (along, np.array(named, dtype=object)),
            "nodal_diameter": (along, np.array(diameter)),
        },
        attrs={
            "title": "modes in contact",
            "case": model.case.title,
            "reference_frequency_hz": model.reference_frequency / hertz,
            "hints": "; ".join(model.disk.hints),
        },
    )


def _modes(mass: ComplexArray, stiffness: ComplexArray) -> tuple[FloatArray, ComplexArray]:
    from scipy.linalg import eigh

    squares, shapes = eigh(stiffness, mass)
    return np.sign(squares) * np.sqrt(np.abs(squares)), shapes


def _consumption(model: ModalModel, tips: Tips, contact: ComplexArray) -> float:
    """Return the clearance consumption of displacements of the contact nodes, (3 * nodes,)."""
    clearance = model.case.casing.clearance
    if clearance <= 0.0:
        raise UserError("modes: contact: expected a casing.clearance above 0")
    phase = np.exp(2j * np.pi * np.arange(PHASES) / PHASES)
    moved = (phase[:, None] * contact).real.reshape(PHASES, -1, 3)
    size = float(np.linalg.norm(moved, axis=2).max())
    if not size > 0.0:
        return float("nan")
    normal, tangential, _ = np.moveaxis(clearance / size * moved, 2, 0)
    nearer = np.hypot(tips.radius + normal, tangential) - tips.radius
    return float(nearer.max() / clearance)


def _locking(contact: ComplexArray, sense: float) -> float:
    """Return the least friction coefficient at which a node locks, for displacements of the contact
    nodes in a mode, (3 * nodes,); infinite without one."""
    normal, tangential = contact[0::3], contact[1::3]
    inward = np.abs(normal) ** 2
    outward = -sense * (normal * tangential.conj()).real
    locks = (outward > SMALL * np.abs(contact).max() ** 2) & (inward > 0.0)
    return float((inward[locks] / outward[locks]).min(initial=np.inf))


def report(data: xr.Dataset) -> Study:
    """Return the document and the table of `contact_modes`; a mode that no friction locks has a
    dash, and null in the document."""
    locks = data["locking_friction"].where(np.isfinite(data["locking_friction"]))
    rows = rows_of(data.assign(locking_friction=locks), COLUMNS)
    return Study(
        name="modes",
        document={"modes_in_contact": rows},
        tables=[table(rows, COLUMNS, "Modes in contact")],
        hints=data.attrs["hints"],
    )
