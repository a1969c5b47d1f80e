"""Contact that is constant in rotating axes, without time integration: Dataset, rows, figure."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from bladewhirl.meshes.line_mesh import ComplexArray, FloatArray
from bladewhirl.models.case.case import Case
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.models.shaft_line.line import parts
from bladewhirl.models.stage.cone import in_wall_axes
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.models.stage.stage import Stage
from bladewhirl.postprocess.plotting.style import COLOURS, new_figure, styled
from bladewhirl.postprocess.plotting.titles import set_title
from bladewhirl.solvers.periodic.contact import NotConverged
from bladewhirl.solvers.periodic.corotating import CorotatingContact, contact_states, obstacles
from bladewhirl.studies.modal.study import Study
from bladewhirl.studies.runs.columns import Column, quantity, rows_of, table

INSTANT = 1e-15  #: time step in which a rotor does not turn [s]

COLUMNS = (
    Column("speed", "Ω / ω₁ [–]", ".4f"),
    Column("speed_rad_s"),
    Column("speed_rpm", "[rpm]", ".1f", variable="rpm"),
    Column("impulse_per_revolution", "impulse per revolution [N s]", ".5g"),
    Column("largest_force", "largest normal force [N]", ".5g"),
    Column("tips", "tips in contact", "d"),
    Column("blades", "blades in contact"),
    Column("normal_force"),
    Column("tip_displacement"),
    Column("radius", "radius of the shaft [mm]", ".5f", 1e3),
    Column("growth_rate", "growth rate [1/s]", ".4g"),
    Column("growth_frequency"),
    Column("largest_multiplier", "largest multiplier [–]", ".4f"),
    Column("multipliers", variable="pairs"),
    Column("stable", "stable"),
    Column("residual"),
)
"""Columns of the solutions."""
OF_LINE = (
    Column("bearing_amplitude", "amplitude at bearings [mm]", ".4g", 1e3),
    Column("bearing_force", "bearing forces [N]", ".5g"),
    Column("shaft_displacement"),
)
"""Columns of solutions on a shaft line."""


def without_steps(case: Case) -> Case:
    """Return a case whose rotor on a shaft line is not that of central differences in time, which a
    march has."""
    if case.shaft_line is None:
        return case
    return case.model_copy(update={"march": case.march.model_copy(update={"time_step": INSTANT})})


def is_corotating(problem: ContactProblem) -> bool:
    """Return whether loads press the bladed disk into the wall constantly in rotating axes."""
    return bool(problem.loads) and not any(obstacles(problem))


@dataclass(frozen=True)
class State:
    """A constant contact of a stage."""

    problem: ContactProblem
    contact: CorotatingContact

    @property
    def tip_displacement(self) -> FloatArray:
        """Radial, tangential and axial displacement of each tip [m], (tips, 3)."""
        slope = self.problem.slope
        if np.ndim(slope):
            slope = np.tile(slope, self.problem.rotor.copies)
        return in_wall_axes(self.contact.tip.ravel(), -slope).reshape(-1, 3)

    def of_line(self) -> tuple[FloatArray, ComplexArray, ComplexArray]:
        """Return the six displacements of each node of the shaft line, (nodes, 6), and x + i y of
        its displacement in each bearing [m] and of the force of each bearing [N], (bearings,), in
        rotating axes."""
        problem, contact, bearings = self.problem, self.contact, self.problem.bearings
        assert bearings is not None
        assert bearings.shaft is not None
        still, moves = np.zeros_like(contact.rotor), contact.supports_velocity(problem.speed)
        wall = np.zeros(problem.casing.wall_modes)
        place, velocity = (np.append(wall, each) for each in (contact.supports, moves))
        force = bearings.force(0.0, problem.speed, (contact.rotor, still), (place, velocity))
        nodes = bearings.shaft.displacement(np.zeros(1), contact.rotor[None])[0]
        of_case = slice(bearings.shaft.bearings)
        return nodes, (bearings.rotor @ contact.rotor)[of_case], force[of_case]


def reasons(case: Case, problem: ContactProblem) -> Iterator[str]:
    """Yield reasons why the contact of a case is not constant in rotating axes, with the keys of a
    shaft line."""
    if case.gravity is not None and any(case.gravity.acceleration):
        yield "the weight turns in rotating axes (gravity.acceleration: expected [0, 0])"
    if case.shaft_line is not None:
        line = case.shaft_line
        for name, one in zip(line.named(), line.bearings, strict=True):
            own = {"stiffness": one.stiffness, "damping": one.damping}
            own["tilt_stiffness"] = one.tilt_stiffness
            if one.support is not None:
                own["support.stiffness"] = one.support.stiffness
                own["support.damping"] = one.support.damping
            for key, matrix in own.items():
                if parts(matrix)[1]:
                    yield f"shaft_line.bearings.{key} of {name!r} is not the same along x and y"
    yield from obstacles(problem)


def states(problem: ContactProblem, speed: str) -> list[State]:
    """Return the constant contacts at a speed, whose text is in messages; at last the motion
    without contact, if it exists beside others.

    Raises:
        UserError: there is no contact, or no solution was found.
    """
    try:
        found = contact_states(problem)
    except NotConverged as reason:
        raise UserError(f"periodic: no constant contact was found at {speed}: {reason}") from None
    if not found[0].normal.any():
        smallest = 1e3 * found[0].gap.min()
        raise UserError(f"periodic: no contact at {speed}: the smallest gap is {smallest:.4g} mm")
    return [State(problem, each) for each in found]


def dataset(stage: Stage, found: Sequence[State]) -> xr.Dataset:
    """Return the Dataset of constant contacts of a stage, also at other speeds; there can be
    several at a speed."""
    case, reference = stage.case, stage.reference_frequency
    contacts = [each.contact for each in found]
    speeds = np.array([each.problem.speed for each in found])
    normal = np.stack([each.normal for each in contacts])
    gap = np.stack([each.gap for each in contacts])
    centre = np.stack([each.centre for each in contacts])
    period = 2.0 * np.pi / np.abs(speeds)
    common = min(len(each.rates) for each in contacts)
    rates = np.stack([each.rates[:common] for each in contacts])
    moved = np.stack([each.tip_displacement for each in found])
    data = xr.Dataset(
        {
            "impulse_per_revolution": quantity(
                "speed", normal.sum(axis=1) * period, "N s", "normal impulse per revolution"
            ),
            "normal_force": quantity(("speed", "tip"), normal, "N", "normal force"),
            "gap": quantity(("speed", "tip"), gap, "m", "gap"),
            "tip_displacement": quantity(("speed", "tip", "direction"), moved, "m"),
            "centre": quantity(("speed", "axis"), centre, "m", "displacement of the centre"),
            "growth_rate": quantity("speed", rates[:, 0].real, "1/s", "growth rate of deviations"),
            "growth_frequency": quantity("speed", np.abs(rates[:, 0].imag), "rad/s"),
            "period": quantity("speed", period, "s"),
            "multipliers": (("speed", "multiplier"), np.exp(rates * period[:, None])),
            "stable": ("speed", [each.stable for each in contacts]),
        },
        coords={
            "speed": quantity("speed", speeds / reference, "1", "normalised speed"),
            "rpm": quantity("speed", speeds * 30.0 / np.pi, "rpm", "speed"),
            "axis": ["x", "y"],
            "direction": ["radial", "tangential", "axial"],
            "blade": ("tip", stage.shown_arrays.blade),
        },
        attrs={
            "title": "contact constant in rotating axes",
            "case": case.title,
            "reference_frequency_hz": reference / (2.0 * np.pi),
        },
    )
    if case.shaft_line is None:
        return data
    nodes, places, forces = (
        np.stack(each) for each in zip(*map(State.of_line, found), strict=True)
    )
    return data.assign(
        shaft_displacement=quantity(("speed", "shaft_node", "shaft_component"), nodes, "m, rad"),
        bearing_amplitude=quantity(("speed", "bearing"), np.abs(places), "m"),
        bearing_force=quantity(("speed", "bearing"), np.abs(forces), "N"),
    ).assign_coords(bearing=list(case.shaft_line.named()))


@styled
def plot_corotating(data: xr.Dataset) -> Figure:
    """Draw the normal force on each tip at each speed; unstable states are dashed."""
    figure = new_figure(height=0.06)
    axes = figure.subplots()
    for n in range(data.sizes["speed"]):
        one = data.isel(speed=n)
        stable = bool(one["stable"])
        label = f"{float(one['rpm']):.6g} rpm" + ("" if stable else ", unstable")
        axes.plot(one["normal_force"].values, ".-" if stable else ".--", label=label)
    axes.axhline(0.0, color=COLOURS["rest"], linewidth=0.5)
    axes.set(xlabel="tip", ylabel="normal force [N]")
    axes.legend(loc="best")
    set_title(figure, data.attrs["case"], "contact constant in rotating axes")
    return figure


def shown(data: xr.Dataset) -> xr.Dataset:
    """Return a Dataset of constant contacts, over its first dimension, with the variables of
    `COLUMNS`."""
    over, *_ = data["growth_rate"].dims
    values, tips = data["multipliers"].values, data["blade"].values
    normal, gap = data["normal_force"], abs(data["gap"])
    touching = (normal > 0.0).values
    which = np.empty(len(touching), dtype=object)
    which[:] = [np.unique(tips[row]).tolist() for row in touching]
    return data.assign(
        speed_rad_s=data["rpm"] * np.pi / 30.0,
        largest_force=normal.max("tip"),
        tips=(normal != 0.0).sum("tip"),
        blades=(over, which),
        radius=np.hypot(data["centre"].sel(axis="x"), data["centre"].sel(axis="y")),
        largest_multiplier=np.abs(data["multipliers"][:, 0]),
        pairs=((over, "multiplier", "part"), np.stack([values.real, values.imag], axis=-1)),
        residual=gap.where(normal > 0.0, 0.0).max("tip") / gap.max("tip"),
    )


def columns_of(data: xr.Dataset) -> tuple[Column, ...]:
    """Return the columns of a Dataset of constant contacts."""
    return COLUMNS + (OF_LINE if "bearing" in data.dims else ())


def report(data: xr.Dataset, failures: Sequence[str]) -> Study:
    """Return the document, table and figure of constant contact; a multiplier is the factor by
    which a small deviation grows in a turn."""
    columns = columns_of(data)
    rows = rows_of(shown(data), columns)
    document = {
        "reference_frequency_hz": data.attrs["reference_frequency_hz"],
        "solutions": rows,
        "failures": list(failures),
    }
    if "bearing" in data.dims:
        document["bearings"] = data["bearing"].values.tolist()
    return Study(
        name="periodic",
        document=document,
        tables=[table(rows, columns, "Contact constant in rotating axes")],
        figures=lambda: {"periodic": (plot_corotating(data), data)},
    )
