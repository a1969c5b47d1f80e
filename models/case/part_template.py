"""Case file for a superelement, `bladewhirl new --from part.npz`: only keys that matter for it."""

from collections.abc import Sequence
from math import ceil, log2, pi
from pathlib import Path

import numpy as np

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.case.superelement import CLEARANCE, REVOLUTIONS, SPEED, STEPS
from bladewhirl.models.inputs.errors import toml_value
from bladewhirl.models.inputs.units import handy
from bladewhirl.models.superelements.critical_step import Limits
from bladewhirl.models.superelements.frequencies import frequencies_by_diameter
from bladewhirl.models.superelements.superelement import Superelement

CLOSING, OVAL = 0.3, 0.75
"""Share of the clearance that the wall loses, and amplitude of its two lobes: together they exceed
the clearance by little, so that the first rub is light; the lobes alone leave it open."""

LOBES = 2  #: number of lobes, whose multiples are the engine orders of the contact

FASTEST = 500.0  #: largest speed of the tips, about that of large fans [m/s]

GAP = pi / 2.0  #: largest angle between neighbouring contact nodes of a whole wheel [rad]

MODES, FEW = 10, 6
"""Number of free-interface modes of each blade or sector, and of the blades of a wheel whose blades
are not known."""

FRICTION, LOOSE = 0.1, 0.5
"""Coefficient of friction, at most this share of the one that locks a contact node."""

SHARE = 0.6  #: largest time step, divided by the critical one

RECORDS = 200  #: number of records in a revolution

INTERVALS = 10  #: number of intervals between the speeds of a sweep

RANGE = (0.5, 1.5)
"""Ends of the range of speeds, divided by the speed."""


def part_template(
    file: str,
    part: Superelement,
    lowest: Sequence[float],
    limits: Limits,
    speeds: FloatArray | None,
    case: Path,
) -> str:
    """Return a case file with comments for a superelement.

    Args:
        file: path of the superelement, relative to the case file.
        part: the superelement.
        lowest: its lowest frequency at rest; of the wheel of a sector, and of one in one piece with
            known blades, that of each nodal diameter from 0, as far as known [rad/s].
        limits: limits of a march with its reduction to `modes_of` modes.
        speeds: range of speeds [rad/s]; by default about the speed at which a multiple of the lobes
            meets the lowest frequency, of a wheel that of the nodal diameter which this engine
            order excites: about the default of a case, unless the tips are too fast.
        case: path of the case file, for the commands in the comments.
    """
    radius = float(part.contact_radius.max())
    clearance = CLEARANCE * radius
    order = round(1.0 / SPEED)
    while (met := _met(part, order, lowest))[0] * radius / order > FASTEST:
        order += LOBES
    reference, whose = met
    speed = reference / order if speeds is None else float(sum(speeds)) / 2.0
    ends = np.outer(speed, RANGE)[0] if speeds is None else speeds
    low, high = (float(f"{end * 30.0 / pi:.{2 if speeds is None else 6}g}") for end in ends)
    turn, orders = 2.0 * pi / speed, ",".join(map(str, range(LOBES, order + 1, LOBES)))
    profile = f'{{ lobes = {LOBES}, amplitude = "{handy(OVAL * clearance, "m", 3)}" }}'
    amount, time = handy(CLOSING * clearance, "m", 3), handy(turn, "s", 2)
    if speeds is None:
        reason = f"order {order} meets {reference / 2.0 / pi:.5g} Hz, {whose} at rest"
    else:
        reason = "the middle of the given range"
    span = ":".join(f"{one:.10g} rpm" for one in (low, high, (high - low) / INTERVALS))
    effects, about = "none", "the file has no stiffness at speed"
    if part.stiffness_speed is not None:
        effects = "centrifugal" if part.gyroscopic is None else "full"
        about = "stiffness at the speed" + ", Coriolis forces" * (effects == "full")
    steps = STEPS * 2 ** max(0, ceil(log2(turn / (SHARE * limits.time_step * STEPS))))
    of_steps = "twice as many show the error of the time steps"
    if steps > STEPS:  # the march is explicit
        highest = f"{1e-3 / pi / limits.time_step:.3g} kHz"
        of_steps = f"stable: modes with held contact nodes reach {highest}; fewer need fewer steps"
    file_line = f"file = {toml_value(file)}"
    wheel = _is_wheel(part)
    owner = "of the whole wheel" if wheel else "of each blade or sector"
    friction = f"{FRICTION:g}"
    if FRICTION > LOOSE * limits.friction:
        friction = f"{LOOSE * limits.friction:.1g}  # contact nodes lock at {limits.friction:.2g}"
    records = handy(float(f"{turn / RECORDS:.2g}"), "s")
    copies, of = part.sectors or 1, "blades at equal angles, clamped at their roots"
    if part.left_dofs is not None:
        copies, of = part.sectors or 2, "sectors of the wheel, as in the file"
    elif part.sectors:
        of = "blades of the wheel, as in the file"
    elif wheel:
        of = "blades of the wheel; 1 does not distinguish them"
        file_line += '\nkind = "wheel"'
    made = f"# The file was made by: {part.command}\n" if part.command else ""
    return f"""\
# bladewhirl modes {case}
# bladewhirl campbell {case} --speeds "0 rpm:{high:.10g} rpm" --orders {orders}
# bladewhirl run {case}
# bladewhirl sweep {case} --over "march.speed={span}"
{made}title = {toml_value(part.name)}

[bladed_disk.superelement]
{file_line}
copies = {copies}  # {of}

[material]
# The file has no limits of the stress. With those of the material the summary compares stresses:
# yield_strength = "900 MPa"  # the largest von Mises stress
# endurance = "400 MPa"  # both: mean and alternating stress, and the Haigh diagram
# strength = "1000 MPa"

[reduction]
free_interface_modes = {modes_of(part)}  # {owner}

[casing]
type = "rigid"  # "ring" is a flexible casing, with keys of its own
clearance = "{handy(clearance, "m", 3)}"  # {CLEARANCE:g} of the radius of the contact nodes
# The wall is oval and closes in: lobes and closure together exceed the clearance, by little.
profile = {{ harmonics = [{profile}] }}
closure = {{ amount = "{amount}", time_constant = "{time}" }}

[contact]
friction = {friction}
sliding = "full"  # against the slip velocity, tangential and axial

[rotation]
effects = "{effects}"  # {about}

[march]
speed = "{float(f"{speed * 30.0 / pi:.4g}"):.10g} rpm"  # {reason}
revolutions = {REVOLUTIONS}
steps_per_revolution = {steps}  # {of_steps}
record_step = "{records}"  # about {RECORDS} records in a revolution
"""


def modes_of(part: Superelement) -> int:
    """Return the number of free-interface modes: `MODES` of each blade."""
    modes = MODES * (part.sectors or FEW if _is_wheel(part) else 1)
    return min(modes, part.size - 1)


def _met(part: Superelement, order: int, lowest: Sequence[float]) -> tuple[float, str]:
    """Return the lowest frequency that an engine order excites [rad/s], and its name."""
    if part.sectors is not None and (part.left_dofs is not None or len(lowest) > 1):
        diameter = abs((order + part.sectors // 2) % part.sectors - part.sectors // 2)
        if diameter < len(lowest):
            own = lowest[diameter]
        else:
            own = 2.0 * pi * float(*next(frequencies_by_diameter(part, 1, [diameter])))
        return own, f"the lowest frequency of nodal diameter {diameter}"
    return min(lowest), "the lowest frequency"


def _is_wheel(part: Superelement) -> bool:
    """Return whether a part is a wheel in one piece, whose contact nodes are all the way round."""
    if part.left_dofs is not None:
        return False
    angle = np.sort(part.contact_angle)
    around = np.diff(angle, append=angle[0] + 2.0 * pi).max() < GAP
    return bool(part.sectors or part.centre_dofs is not None or around)
