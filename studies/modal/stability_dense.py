"""Growth rates of a stage whose bladed disk has no cyclic symmetry, by dense matrices."""

from __future__ import annotations

import json
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import typer

from bladewhirl.meshes.line_mesh import BoolArray, FloatArray
from bladewhirl.models.coupling.springs import CouplingModes
from bladewhirl.models.coupling.without_sectors import DenseModes, dense_modes
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.models.inputs.mode_names import ALL, CASING, SIX, family_and_diameter
from bladewhirl.models.modal.full_stage import ModalStage
from bladewhirl.solvers.stability.growth import StabilityChart
from bladewhirl.solvers.stability.zones import UnstableZones
from bladewhirl.studies.modal.stability_point import point_facts

if TYPE_CHECKING:
    import xarray as xr

SIX_FAMILIES = "1F,suspension,casing:1"
"""What stands for the paper's six modes where every mode of 1F has one nodal diameter in it."""


@dataclass(frozen=True, kw_only=True)
class DenseSystem:
    """Coupled modes of a stage without cyclic symmetry."""

    modes: DenseModes  #: the modes chosen, with the amplitudes chosen
    with_pi: bool  #: whether the factor pi of Eq. (8) is kept
    damped: bool
    reference: float  #: frequency that speeds are multiples of [rad/s]

    def options(self) -> dict[str, object]:
        """What was chosen, for reports."""
        return {
            "modes": list(self.modes.name),
            "damped": self.damped,
            "pi": self.with_pi,
            "amplitude": "physical",
            "reference_frequency": self.reference,
        }

    def spectrum(
        self, omega: float, kappa: float
    ) -> np.ndarray[tuple[int], np.dtype[np.complex128]]:
        """Eigenvalues at a speed [rad/s] and a stiffness [N/m], (2 size,) [1/s]."""
        state = self.modes.state_matrix(omega, kappa, with_pi=self.with_pi)
        return np.asarray(np.linalg.eigvals(state), dtype=np.complex128)


def has_symmetry(modal: ModalStage) -> bool:
    """Whether the modes of the bladed disk have one nodal diameter each."""
    return not np.any(modal.disk.blade_columns(modal.disk_modes.column) < 0)


def couple_densely(
    modal: ModalStage, *, chosen: str, damped: bool, with_pi: bool, physical: bool
) -> DenseSystem:
    """Couple modes of a stage without use of its bladed disk's symmetry.

    Args:
        modal: finite element models with all their modes.
        chosen: families with or without ":k" as in `coupled_system.choose`; k is the nodal
            diameter that holds most of a mode. "six" is all of
            `SIX_FAMILIES`.
        damped: with the damping of the case, or none.
        with_pi: keep the factor pi of Eq. (8).
        physical: with the modes' own amplitudes, which there must be.

    Raises:
        UserError: one amplitude for all asked for, a casing without cyclic symmetry too, or modes
            that the stage does not have.
    """
    if not physical:
        raise UserError(
            "stability: expected --physical where blades differ: one amplitude for every mode has"
            " a meaning only if each mode has one nodal diameter"
        )
    damping_ratio = modal.case.damping.ratio if damped else 0.0
    try:
        whole = dense_modes(modal, damping_ratio=damping_ratio)
    except ValueError as error:
        raise UserError(f"stability: {error}") from None
    return DenseSystem(
        modes=_choose(whole, SIX_FAMILIES if chosen == SIX else chosen),
        with_pi=with_pi,
        damped=damped,
        reference=modal.reference_frequency,
    )


def _choose(whole: DenseModes, text: str) -> DenseModes:
    if text == ALL:
        return whole
    names = np.array(whole.family)
    rotor, casing = np.zeros(len(names), np.bool_), np.zeros(len(whole.casing_diameter), np.bool_)
    for word in text.split(","):
        family, k = family_and_diameter(word.strip())
        if family == CASING:
            found: BoolArray = np.full(len(casing), k is None) | (whole.casing_diameter == k)
            casing |= found
        else:
            found = names == family
            if k is not None:
                found &= whole.nodal_diameter == k
            rotor |= found
        if not found.any() and family != "suspension":  # a clamped centre has none
            known = ", ".join(["six", "all", "casing", *dict.fromkeys(whole.family)])
            raise UserError(f"--modes {word}: expected one of {known}, and nodal diameters it has")
    return whole.take(rotor, casing)


def report_point(system: DenseSystem, *, omega: float, kappa: float, as_json: bool) -> None:
    """Print growth rate, verdict and, as JSON, the spectrum at a point."""
    spectrum = system.spectrum(omega, kappa)
    growth = float(spectrum.real.max())
    point = point_facts(spectrum, growth, omega=omega, kappa=kappa, reference=system.reference)
    if as_json:
        typer.echo(json.dumps(point | system.options(), indent=2))
        return
    typer.echo(f"speed {point['speed']:.6g} ω₁ = {omega:.6g} rad/s, κ {kappa:.6g} N/m")
    typer.echo(f"growth rate {growth:.6g} 1/s ({'unstable' if point['unstable'] else 'stable'})")


def growth_chart(
    system: DenseSystem,
    omegas: FloatArray,
    kappas: FloatArray,
    progress: Callable[[int], None] = lambda done: None,
) -> StabilityChart:
    """Growth rate on a grid of speeds [rad/s] and stiffnesses [N/m]."""

    def row(kappa: float) -> list[float]:
        return [float(system.spectrum(omega, kappa).real.max()) for omega in omegas.tolist()]

    growth = []
    with ThreadPoolExecutor() as pool:
        for values in pool.map(row, kappas.tolist()):
            growth.append(values)
            progress(len(growth) * len(omegas))
    return StabilityChart(speed=omegas, kappa=kappas, growth=np.array(growth))


def make_dense_chart(
    system: DenseSystem,
    *,
    speeds: FloatArray,
    kappas: FloatArray,
    folder: Path | None,
    as_json: bool,
) -> None:
    """Chart the growth rate and report where it is largest.

    Args:
        system: the coupled modes.
        speeds: in multiples of the reference frequency, ascending.
        kappas: spring stiffnesses [N/m], ascending.
        folder: where figure and data go; none are made when None.
        as_json: print one JSON document.
    """
    from bladewhirl.postprocess.modal.stability import chart_dataset, plot_chart
    from bladewhirl.postprocess.plotting.style import save_figure
    from bladewhirl.studies.modal.stability_chart import progress_bar

    omegas = speeds * system.reference
    with progress_bar(quiet=as_json) as bar:
        task = bar.add_task("growth rates", total=omegas.size * kappas.size)
        chart = growth_chart(system, omegas, kappas, lambda done: bar.update(task, completed=done))
    data = chart_dataset(chart, _no_zones(omegas, kappas, system.reference))
    if folder is not None:
        folder.mkdir(parents=True, exist_ok=True)
        save_figure(plot_chart(data), folder / "stability", data)
    row, column = np.unravel_index(int(chart.growth.argmax()), chart.growth.shape)
    largest = {
        "largest_growth_rate": float(chart.growth[row, column]),
        "at_speed": float(speeds[column]),
        "at_kappa": float(kappas[row]),
        "unstable_share": float(chart.unstable.mean()),
    }
    if as_json:
        typer.echo(json.dumps(largest | system.options(), indent=2))
        return
    typer.echo(
        f"Largest growth rate {largest['largest_growth_rate']:.4g} 1/s at"
        f" {largest['at_speed']:.4g} ω₁ and {largest['at_kappa']:.4g} N/m;"
        f" {100.0 * largest['unstable_share']:.3g} % of the chart is unstable."
    )
    if folder is not None:
        typer.echo(f"Wrote {folder}.")


def _no_zones(omegas: FloatArray, kappas: FloatArray, reference: float) -> xr.Dataset:
    """Modes that mix all nodal diameters: no pair of them begins a zone."""
    from bladewhirl.postprocess.modal.stability import zones_dataset

    none, numbers, flags = np.zeros(0), np.zeros(0, np.int64), np.zeros(0, np.bool_)
    zones = UnstableZones(
        kappa=none, lower=none, upper=none, growth=none, casing=numbers, rotor=numbers
    )
    modes = CouplingModes(
        name=(),
        on_casing=flags,
        nodal_diameter=numbers,
        frequency=none,
        amplitude=none,
        damping_ratio=none,
        paired=flags,
    )
    return zones_dataset(zones, modes, speed=omegas, kappa=kappas, reference=reference)
