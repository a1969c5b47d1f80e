"""Quantities of all points of a sweep, arranged along one swept key; histories are not read.

In all functions `dataset` is a sweep from `open_sweep`, and `key` is the swept key on the
horizontal axis of a figure, as a dimension of the sweep. The first dimensions of all quantities are
(line, key), with ascending values of the key. Each element of `line` is one combination of values
of the other swept keys, which are coordinates along `line`.
"""

from collections.abc import Sequence

import numpy as np
import xarray as xr

from bladewhirl.postprocess.fields.kinematics import ViewError
from bladewhirl.postprocess.fields.netcdf import has
from bladewhirl.postprocess.sweep.dataset import swept, swept_keys
from bladewhirl.solvers.march.schema import DRAW, POINT, SWEEP_FORMAT

LINE = "line"  #: name of the dimension `line`, see the module docstring
MOTION = 1e-3
"""Whirl and contact side are evaluated if the displacement of the shaft (root mean square over the
last third of the time) is at least this fraction of the smallest clearance. Smaller displacements
are the end of a decay, or rounding errors."""


def main_key(dataset: xr.Dataset) -> str:
    """Return the key for the horizontal axis: the speed if it is swept, otherwise the first key."""
    names = swept(dataset)
    return "march_speed" if "march_speed" in names else names[0]


def other_keys(data: xr.Dataset) -> list[xr.DataArray]:
    """Return the values (line,) of each swept key that is not on the horizontal axis, from a
    Dataset over (line, key)."""
    return [
        values
        for values in data.coords.values()
        if values.dims == (LINE,) and "long_name" in values.attrs
    ]


def table_keys(data: xr.Dataset) -> list[xr.DataArray]:
    """Return the values of each key of a table of points, along the dimension of the points."""
    return [
        values
        for name, values in data.coords.items()
        if values.dims == (POINT,) and name != POINT and "long_name" in values.attrs
    ]


def largest_motion(dataset: xr.Dataset) -> tuple[str, str]:
    """Return the name of the variable with the largest displacement of each march, and the name of
    the moving part: the shaft or, without a moving shaft, a contact node."""
    if has(dataset, "centre"):
        return "shaft_radius_max", "shaft"
    return "displacement_max", "contact node"


def need_a_grid(dataset: xr.Dataset) -> None:
    """Refuse a sweep over a table of points.

    Raises:
        ViewError: the sweep has a table.
    """
    if POINT in dataset.dims:
        raise ViewError("expected a sweep over a grid of values (--over), not over a table")


def along(dataset: xr.Dataset, key: str, names: Sequence[str]) -> xr.Dataset:
    """Load variables of a sweep along a key; numbers are NaN at points that are not finished.

    Args:
        dataset: from `open_sweep`.
        key: swept key, as a dimension of the sweep.
        names: names of variables.

    Returns:
        Dataset of the variables and `state` over (line, key, ...). Attributes: `along`, the key;
        `case`, the title of the swept case; `reference_hz`, the reference frequency if it is the
        same at all points.

    Raises:
        ViewError: no point is finished, or the format of the sweep lacks one of the variables.
    """
    others = [name for name in swept(dataset) if name != key]
    data = as_lines(in_order(dataset, names), others)
    return data.transpose(LINE, key, ...).assign_attrs(along=key)


def in_order(dataset: xr.Dataset, names: Sequence[str]) -> xr.Dataset:
    """Load variables and `state` over all swept keys, with each key in ascending order.

    Raises:
        ViewError: no point is finished, or the format of the sweep lacks one of the variables.
    """
    missing = [name for name in names if name not in dataset]
    if missing:
        raise ViewError(
            f"{', '.join(missing)}: not in this sweep, which was written in format"
            f" {dataset.attrs.get('format', 1)}; the current format is {SWEEP_FORMAT}. Run the"
            " sweep again to get the missing variables"
        )
    if not (dataset["state"] == "done").any():
        raise ViewError("no point of the sweep is finished, so there is nothing to draw")
    keys = [*swept(dataset), *swept_keys(dataset)]
    chosen = dataset[[*names, "state"]]
    dropped = [name for name in chosen.coords if name not in (*chosen.dims, *keys)]
    chosen = chosen.drop_vars(dropped).compute().sortby(swept(dataset))
    done = chosen["state"] == "done"
    for name in names:
        if chosen[name].dtype.kind == "f":
            chosen[name] = chosen[name].where(done).assign_attrs(dataset[name].attrs)
    about: dict[str, str | float] = {"case": str(dataset.attrs.get("title", ""))}
    reference = dataset["reference_frequency"].values[dataset["state"].values == "done"]
    reference = reference / (2 * np.pi)
    if np.ptp(reference) <= 1e-9 * reference[0]:
        about["reference_hz"] = float(reference[0])
    return chosen.drop_attrs(deep=False).assign_attrs(about)


def as_lines(data: xr.Dataset, keys: Sequence[str]) -> xr.Dataset:
    """Combine swept keys of data from `in_order` into the dimension `line`, with an element for
    each combination of values of the keys. The keys become coordinates along `line`. If no keys are
    given, `line` has one element."""
    if not keys:
        return data.expand_dims(LINE)
    lines = data.stack({LINE: keys}).reset_index(LINE)
    for name in keys:
        lines[name].attrs.update(data[name].attrs)
    return lines


def shaft_radius(dataset: xr.Dataset, key: str) -> xr.Dataset:
    """Return largest and final displacement of the shaft against a swept key (the paper's Fig. 24),
    as Dataset over (line, key): `shaft_radius_max` and `shaft_radius_final` [m], `regime`."""
    names = ["shaft_radius_max", "shaft_radius_final", "regime"]
    return along(dataset, key, names).assign_attrs(title="displacement of the shaft's centre")


def regimes(dataset: xr.Dataset, key: str) -> xr.Dataset:
    """Return the regime, the growth rate of the amplitude, and the standard error of the rate,
    against a swept key.

    Returns:
        Dataset over (line, key): `regime`; `growth_rate` and `growth_error` [1/s], nan where growth
        cannot be judged.
    """
    data = along(dataset, key, ["regime", "growth_rate", "growth_error"])
    return data.assign_attrs(
        title="regime, and growth of the amplitude", criterion=dataset.attrs["criterion"]
    )


def whirls(dataset: xr.Dataset, key: str) -> xr.Dataset:
    """Return the whirl of the shaft over the last third of each march, in both frames, against a
    swept key.

    Returns:
        Dataset over (line, key): `frequency` (line, key, frame) of the whirl [Hz], positive for
        forward whirl; `scatter` of the frequency [Hz]; `direction` (line, key, frame), "forward",
        "backward" or "none"; `mode_frequency` (line, key, mode) [Hz]; `rotation_frequency`, the
        speed [Hz]. Where the displacement of the shaft is less than `MOTION` times the clearance,
        frequency and scatter are nan, and the direction is "at rest".
    """
    names = ["whirl_frequency", "whirl_scatter", "whirl_rotating", "whirl_static"]
    names += ["rotation_speed", "mode_frequency", *_MOVING]
    data = along(dataset, key, names)
    moves = _moves(data)
    speed = np.abs(data["rotation_speed"]) / (2 * np.pi)
    frame = xr.DataArray(["rotating", "static"], dims="frame")
    rotating = data["whirl_frequency"].where(moves)
    direction = xr.concat([data["whirl_rotating"], data["whirl_static"]], dim=frame)
    known = direction.where(moves | (data["state"] != "done"), "at rest")
    places = (LINE, key, "frame")
    return xr.Dataset(
        {
            "frequency": xr.concat([rotating, rotating + speed], dim=frame).transpose(*places),
            "scatter": data["whirl_scatter"].where(moves),
            "direction": known.transpose(*places),
            "mode_frequency": data["mode_frequency"],
            "rotation_frequency": speed,
            "state": data["state"],
        },
        attrs={**data.attrs, "title": "whirl of the shaft over the last third of each march"},
    )


def contact_sides(dataset: xr.Dataset, key: str) -> xr.Dataset:
    """Return the mean angle by which the shaft leads the contact over the last third of each march,
    and the contact scenario, against a swept key.

    Returns:
        Dataset over (line, key): `shaft_lead` [rad], its `lead_steadiness`, and `scenario`. The
        scenario is "no-contact" if no blade touches in the last third, and "at-rest" if the
        displacement of the shaft is less than `MOTION` times the clearance; `shaft_lead` and
        `lead_steadiness` are then nan.
    """
    names = ["shaft_lead", "lead_steadiness", "scenario", "late_contact_share", *_MOVING]
    data = along(dataset, key, names)
    known = data["state"] == "done"
    moves = _moves(data)
    touches = (data["late_contact_share"] > 0).any("blade")
    for name in ("shaft_lead", "lead_steadiness"):
        data[name] = data[name].where(moves & touches).assign_attrs(data[name].attrs)
    scenario = data["scenario"].where(touches | ~known, "no-contact")
    data["scenario"] = scenario.where(moves | ~known, "at-rest")
    return data.drop_vars(["late_contact_share", *_MOVING]).assign_attrs(
        title="side of the contact over the last third of each march"
    )


def bifurcation(dataset: xr.Dataset, key: str) -> xr.Dataset:
    """Return Poincaré sections (positions of the shaft once a revolution) and local maxima of the
    displacement of the shaft, in the last third of each march.

    A motion that repeats with every revolution has one section, a motion that repeats with every
    second revolution has two sections. The sections of a whirl that is not synchronous with the
    rotor fill a band. A circular orbit about the origin has a single radius, even if it is not
    synchronous.

    Returns:
        Dataset over (line, key, section) [m]: `section_x` and `section_y`, the position whenever
        blade 0 lies on +x, which is therefore the same in both frames; `section_radius`, the
        distance of this position from the origin; `radius_peak`, the local maxima. Elements without
        a value are NaN. The sections of all random draws of a point follow one another.
    """
    data = along(dataset, key, ["section_x", "section_y", "radius_peak"])
    if DRAW in dataset.dims:
        data = _draws_together(data.drop_vars("state"), dataset.sizes[DRAW])
    radius = ((data["section_x"] ** 2 + data["section_y"] ** 2) ** 0.5).assign_attrs(units="m")
    return data.assign(section_radius=radius).assign_attrs(
        title="bifurcation diagram: the shaft in the last third of each march"
    )


_MOVING = ["late_radius", "smallest_clearance"]


def _moves(data: xr.Dataset) -> xr.DataArray:
    """Return true where the shaft moves enough to evaluate whirl and contact side, see `MOTION`."""
    return data["late_radius"] >= MOTION * data["smallest_clearance"]


def _draws_together(data: xr.Dataset, count: int) -> xr.Dataset:
    """Return data over (line, key, section) in which each line has the sections of all `count`
    draws, one draw after another. In the given data each draw is a line; the draws of a point are
    neighbours."""
    joined = data.isel({LINE: slice(None, None, count)}).drop_vars([DRAW, *data.data_vars])
    for name, values in data.items():
        lines, places, sections = values.shape
        apart = values.values.reshape(lines // count, count, places, sections)
        together = apart.transpose(0, 2, 1, 3).reshape(-1, places, count * sections)
        joined[name] = (values.dims, together, values.attrs)
    return joined
