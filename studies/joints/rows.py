"""Rows, document and hints of periodic motions of a tuned wheel with friction joints or a rub."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.joints.tips import WALL
from bladewhirl.postprocess.joints.motions import plot_joints
from bladewhirl.studies.joints.dataset import OF_JOINTS, OF_WALL
from bladewhirl.studies.modal.study import Study
from bladewhirl.studies.runs.columns import Column, table

VAGUE = 0.05  #: change with the harmonics from which on a hint names a motion
COLUMNS = (
    Column("speed", "Ω / ω₁ [–]", ".4f"),
    Column("speed_rad_s"),
    Column("speed_rpm", "[rpm]", ".1f"),
    Column("amplitude", "amplitude of a point [mm]", ".4g", 1e3),
    Column("point_amplitude"),
    Column("largest_normal_force", "largest normal force [N]", ".4g"),
    Column("share_open", "open [–]", ".2f"),
    Column("share_slipping", "slipping [–]", ".2f"),
    Column("work", "work in a period [J]", ".4g"),
    Column("joints"),
    Column("wall"),
    Column("largest_multiplier", "largest multiplier [–]", ".4f"),
    Column("stable", "stable"),
    Column("linear_limits"),
    Column("harmonics", "harmonics", "d"),
    Column("change", "change with harmonics [–]", ".1e"),
    Column("residual", "residual", ".1e"),
)
"""Columns of the solutions; of several joints the largest force and share, and all work."""

WALL_COLUMNS = (
    Column("wall.largest_normal_force", "largest force on a tip [N]", ".4g"),
    Column("wall.share_open", "tips open [–]", ".3f"),
    Column("wall.impulse_per_revolution", "impulse per revolution [N s]", ".4g"),
    Column("wall.friction_heat", "friction heat in a period [J]", ".4g"),
    Column("wall.drive_work", "work of the drive in a period [J]", ".4g"),
)
"""Columns of the solutions with a wall."""


def report(data: xr.Dataset, failures: Sequence[str]) -> Study:
    """Return the document, table and figure of `periodic`."""
    rows = rows_of(data)
    columns = shown_columns(data)
    document = {
        "reference_frequency_hz": data.attrs["reference_frequency_hz"],
        "engine_order": data.attrs["engine_order"],
        "solutions": rows,
        "failures": list(failures),
    }
    return Study(
        name="periodic",
        document=document,
        tables=[table(rows, columns, "Periodic motions of all blades")],
        figures=lambda: {"periodic": (plot_joints(data), data)},
        hints=hints(rows),
    )


def shown_columns(data: xr.Dataset) -> tuple[Column, ...]:
    """Return the columns of motions: those of joints only if there are some besides a wall."""
    contacts = data["joint"].values.tolist()
    own = COLUMNS if contacts != [WALL] else [each for each in COLUMNS if each.key not in OF_JOINTS]
    return (*own, *(WALL_COLUMNS if WALL in contacts else ()))


def hints(rows: Sequence[dict[str, Any]]) -> str:
    """Return hints about motions that are not stable or depend on the number of harmonics."""
    lost = sum(not row["stable"] for row in rows)
    alone = sum(row["change"] is None for row in rows)
    vague = sum((row["change"] or 0.0) > VAGUE for row in rows)
    found = []
    if lost:
        found.append(
            f"{lost} of {len(rows)} motions are not stable: a march does not settle on them"
        )
    if vague:
        found.append(
            f"{vague} of {len(rows)} motions change by more than {VAGUE:.0%} with the number of"
            " harmonics: compare them with a march"
        )
    if alone:
        found.append(
            f"{alone} of {len(rows)} motions were found with one number of harmonics alone, and"
            " their error is unknown (no change in the table): compare them with a march"
        )
    return "; ".join(found)


def rows_of(data: xr.Dataset, over: str = "speed") -> list[dict[str, Any]]:
    """Return the rows of the motions over a dimension."""
    rows, limits = [], data["limit"].values.tolist()
    own = [*OF_JOINTS, *(["walk"] if "walk" in data else [])]
    for n in range(data.sizes[over]):
        one = data.isel({over: n})
        contacts = {
            name: {key: float(each[key]) for key in own if not np.isnan(each[key])}
            for name in one["joint"].values.tolist()
            for each in [one[own].sel(joint=name)]
        }
        wall = contacts.pop(WALL, None)
        points = one["point_amplitude"].values
        rows.append(
            {
                "speed": float(one["speed"]),
                "speed_rad_s": float(one["rpm"]) * np.pi / 30.0,
                "speed_rpm": float(one["rpm"]),
                "amplitude": _largest(points),
                "point_amplitude": points.tolist(),
                **{
                    key: (sum if key == "work" else max)(each[key] for each in contacts.values())
                    for key in (OF_JOINTS if contacts else ())
                },
                "joints": contacts,
                "wall": wall and wall | {key: float(one[key]) for key in OF_WALL},
                "largest_multiplier": float(one["largest_multiplier"]),
                "stable": bool(one["stable"]),
                "linear_limits": dict(
                    zip(limits, one["linear_limit"].values.tolist(), strict=True)
                ),
                "harmonics": int(one["harmonics"]),
                "change": _finite(float(one["change"])),
                "residual": float(one["residual"]),
            }
        )
    return rows


def _finite(value: float) -> float | None:
    """Return a value, or None for infinity."""
    return value if np.isfinite(value) else None


def _largest(amplitudes: FloatArray) -> float | None:
    """Return the largest length of some vectors, (vectors, 3); None without any."""
    return float(np.linalg.norm(amplitudes, axis=-1).max()) if len(amplitudes) else None
