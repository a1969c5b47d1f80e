"""Contact by angle of the casing and revolution of the rotor."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from bladewhirl.postprocess.fields import rotation
from bladewhirl.postprocess.fields.by_blade import blade_count
from bladewhirl.postprocess.fields.kinematics import Array, IntArray
from bladewhirl.postprocess.fields.labelled import labelled
from bladewhirl.postprocess.fields.wheels import of_wheel, wheel_numbers
from bladewhirl.postprocess.fields.windows import select_window
from bladewhirl.postprocess.plotting.style import new_figure, styled, time_axis
from bladewhirl.postprocess.plotting.titles import head
from bladewhirl.postprocess.run.blade_contact import (
    COLUMNS,
    contact_span,
    draw_share,
    share_label,
    share_limit,
)

SECTORS = 4  #: largest number of sectors of the casing per blade pitch
FEW_SECTORS = 72  #: largest number of sectors in any case
LAST_TURNS = 8.0
"""A second panel shows this number of revolutions at the end of a run: contact that travels around
the casing cannot be recognised in a drawing of many revolutions."""


def casing_contact(
    result: xr.Dataset, *, wheel: int = 0, start: float | None = None, end: float | None = None
) -> xr.Dataset:
    """Compute the share of time steps with contact in each sector of the casing, over time.

    Only the time steps at which a blade is in the sector count. The spans of time are long enough
    that a blade passes every sector in each of them; at standstill there are 600 spans.

    Args:
        result: result of a run.
        wheel: number of the wheel inside the wall, if several wheels of a shaft line have one.
        start, end: limits of the time window [s]; start and end of the run when None.

    Returns:
        Dataset over (time, sector): `share` [1], nan where no blade was in the sector. `time` [s]
        is the end of each span, `time_edge` [s] are the limits of the spans, and `angle_edge` [rad]
        are the limits of the sectors in the static frame.

    Raises:
        ViewError: there are fewer than two records.
    """
    dataset = of_wheel(select_window(result, start, end), wheel)
    time, tips = dataset["time"].values, dataset["tip_angle"].values
    speed, blades = abs(float(dataset.attrs["speed"])), blade_count(dataset)
    steps = np.diff(time)
    spans, sectors = COLUMNS, blades
    if speed:  # a sector is at least as wide as the movement of a tip between two records
        finest = 2 * np.pi / (speed * float(np.median(steps)))
        spans = int(np.clip(np.ptp(time) * blades * speed / (2 * np.pi), 1, COLUMNS))
        sectors = int(np.clip(finest, blades, max(FEW_SECTORS, SECTORS * blades)))
    origin = 0.0 if speed else -np.pi / sectors  # tips at rest are in the middle of their sectors
    edges = np.linspace(time[0], time[-1], spans + 1)
    middle = time[1:] - steps / 2
    turned = rotation.angle_at(dataset, middle)[:, None]
    angle = np.mod(tips + turned - origin, 2 * np.pi)
    sector = np.minimum((angle * sectors / (2 * np.pi)).astype(np.int64), sectors - 1)
    span = np.minimum(np.searchsorted(edges, middle, side="right") - 1, spans - 1)
    cell: IntArray = span[:, None] * sectors + sector
    size = spans * sectors

    def total(weight: Array) -> Array:
        sums = np.bincount(cell.ravel(), np.broadcast_to(weight, cell.shape).ravel(), size)
        return np.asarray(sums.reshape(spans, sectors))

    passed = total(steps[:, None] / dataset.attrs["time_step"])
    touching = total(dataset["contact_steps"].values[1:].astype(np.float64))
    share = np.divide(touching, passed, out=np.full_like(passed, np.nan), where=passed > 0)
    return labelled(
        dataset,
        "contact by angle of the casing",
        {"share": (("time", "sector"), np.minimum(share, 1.0), "1")},
        {
            "time": edges[1:],
            "time_edge": edges,
            "angle_edge": origin + np.linspace(0.0, 2 * np.pi, sectors + 1),
        },
    )


def all_and_last_turns(result: xr.Dataset) -> xr.Dataset:
    """Return the contact from `casing_contact` with the contact in the last revolutions added:
    `last_share` (last_time, last_sector), with the limits `last_time_edge` and `last_angle_edge`.
    Nothing is added for a short run. If several wheels of a shaft line have walls, the contact of
    each further one is added instead, with the number in the names: `wheel_2_share` ..."""
    contact, *further = (casing_contact(result, wheel=each) for each in wheel_numbers(result))
    if further:
        for number, own in zip(wheel_numbers(result)[1:], further, strict=True):
            names = [*own.dims, *own.variables]
            contact = contact.merge(own.rename({name: f"wheel_{number}_{name}" for name in names}))
        return contact
    end = float(contact["time_edge"][-1])
    speed = abs(float(contact.attrs["speed"]))
    begin, last_drawn = _limits(contact)
    if (last_drawn - begin) * speed <= 2 * 2 * np.pi * LAST_TURNS:
        return contact
    last = casing_contact(result, start=end - LAST_TURNS * 2 * np.pi / speed, end=end)
    names = [*last.dims, *last.variables]
    return contact.merge(last.rename({name: f"last_{name}" for name in names}))


@styled
def plot_casing_contact(contact: xr.Dataset) -> Figure:
    """Draw the share of the time in contact by casing angle and revolution, from
    `all_and_last_turns`.

    The figure of a long run has a second panel with the last revolutions. If contact is brief, the
    upper panel only shows the time of contact. Several wheels with walls have a panel each.
    """
    parts = [str(name).removesuffix("share") for name in contact if str(name).endswith("share")]
    figure = new_figure(height=0.015 + 0.045 * len(parts))
    panels = figure.subplots(len(parts), squeeze=False)[:, 0]
    limit = share_limit(*(contact[f"{which}share"] for which in parts))
    turns = abs(float(contact.attrs["speed"])) / (2 * np.pi)  # revolutions per second
    for axes, which in zip(panels, parts, strict=True):
        across = (turns or 1.0) * contact[f"{which}time_edge"]
        angle = np.degrees(contact[f"{which}angle_edge"].values)
        picture = draw_share(axes, across, angle, contact[f"{which}share"], limit)
        axes.set(yticks=(0, 90, 180, 270, 360), ylabel="casing angle [°]", ylim=angle[[0, -1]])
        axes.set_xlabel("revolutions of the rotor")
        if "wheel" in parts[-1]:
            axes.set_title(f"wheel {which.split('_')[1] if which else 0}", loc="left")
    words = "passes in contact [%]" if turns else "time in contact [%]"
    figure.colorbar(picture, ax=[*panels], label=share_label(words, limit))
    panels[0].set_xlim(*((turns or 1.0) * limit for limit in _limits(contact)))
    if not turns:
        time_axis(panels[0])
    head(figure, contact)
    return figure


def _limits(contact: xr.Dataset) -> tuple[float, float]:
    """Return the limits of the time axis of the upper panel [s], see `contact_span`."""
    return contact_span(contact["time_edge"].values, (contact["share"] > 0).any("sector").values)
