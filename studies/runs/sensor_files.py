"""Signals of sensors in the folder of a run: sensors.nc, and a CSV file for each sensor."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from bladewhirl.files import replacing
from bladewhirl.models.inputs.errors import UserError
from bladewhirl.studies.runs import folder
from bladewhirl.studies.runs.prepare import Prepared

if TYPE_CHECKING:
    import xarray as xr


def check_gauges(prepared: Prepared) -> None:
    """Check before a march that the sensors of its case fit the stage.

    Raises:
        CaseError: a sensor cannot record; the error lists all faults.
    """
    stage = prepared.stage
    if not stage.case.sensor:
        return
    from bladewhirl.postprocess.fields.result import stage_dataset
    from bladewhirl.postprocess.run.sensors import check_sensors

    step = prepared.timing.record_every * prepared.timing.time_step
    check_sensors(stage_dataset(stage.arrays), stage.case.sensor, stage.speed, step)


def write_sensors(result: xr.Dataset, directory: Path) -> Iterator[str]:
    """Write the signals of the sensors of a run into its folder; yield hints. Nothing is written
    for a case without sensors."""
    if "[[sensor]]" not in str(result.attrs["case"]):
        return
    from bladewhirl.postprocess.fields.netcdf import write_netcdf
    from bladewhirl.postprocess.run.sensors import sampling_hints, sensors_of, signals

    try:
        chosen = sensors_of(result)
        recorded = signals(result, chosen)
    except UserError as error:  # the run ended at once, or a tip turned backward
        yield f"no signals of sensors: {error}"
        return
    with replacing(directory / folder.SENSORS_NAME) as draft:
        write_netcdf(recorded, draft)
    for sensor in chosen:
        with replacing(directory / f"{sensor.label}.csv") as draft:
            _write_csv(recorded, sensor.label, draft)
    yield from sampling_hints(chosen, float(result.attrs["record_step"]))


def _write_csv(signals: xr.Dataset, name: str, path: Path) -> None:
    """Write a signal as a table whose first line names the columns and their units."""
    from bladewhirl.postprocess.run.sensors import shown_unit

    signal = signals[name]
    unit, scale = shown_unit(signal)
    unit = unit.replace("µ", "u")
    values = scale * signal.values
    columns: dict[str, Any]
    if f"{name}_arrival" in signals:
        arrival = signals[f"{name}_arrival"].values
        probe, blade, revolution = np.nonzero(np.isfinite(arrival))
        order = np.argsort(arrival[probe, blade, revolution], kind="stable")
        chosen = probe[order], blade[order], revolution[order]
        columns = {
            "arrival [s]": arrival[chosen],
            "probe [deg]": np.degrees(signals[f"{name}_probe"].values)[chosen[0]],
            "blade": chosen[1],
            "revolution": chosen[2],
            f"deflection [{unit}]": values[chosen],
        }
    else:
        columns = {"time [s]": signals[signal.dims[0]].values}
        table = values.reshape(len(values), -1).T
        labels = [f" blade {n}" for n in range(len(table))] if signal.ndim > 1 else [""]
        columns |= {
            f"{name}{label} [{unit}]": row for label, row in zip(labels, table, strict=True)
        }
    form = ["%.12g", *["%.8g"] * (len(columns) - 1)]
    rows = np.column_stack([*columns.values()])
    np.savetxt(path, rows, form, ",", header=",".join(columns), comments="", encoding="utf-8")
