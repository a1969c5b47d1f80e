"""States of a march on disk, bit for bit, from which a killed march continues."""

from __future__ import annotations

from dataclasses import dataclass, fields, is_dataclass
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np

from bladewhirl.files import replacing

CHECKPOINT_NAME = "checkpoint.npz"
"""In the folder of a run."""

NOTES = ("case", "records", "wall_time")


@dataclass(frozen=True, kw_only=True)
class Checkpoint:
    """State of a march when its records were last flushed."""

    case: str  #: digest of all that the march depends on but its duration
    records: int  #: in the result
    wall_time: float  #: elapsed [s]
    state: dict[str, Any]  #: arrays by name, from `state_arrays`


def state_arrays(state: Any, prefix: str = "") -> dict[str, Any]:
    """Numbers and arrays of a scheme's state by name; dataclasses and dictionaries are opened."""
    arrays: dict[str, Any] = {}
    for name, value in _parts(state).items():
        whole = prefix + name
        arrays |= state_arrays(value, f"{whole}.") if _parts(value) else {whole: value}
    return arrays


def state_from(begin: Any, arrays: dict[str, Any]) -> Any:
    """The state with these arrays.

    Args:
        begin: the scheme's first state.
        arrays: of `state_arrays`.

    Raises:
        ValueError: they are not those of the scheme.
    """
    shapes = {name: np.shape(value) for name, value in state_arrays(begin).items()}
    if shapes != {name: np.shape(value) for name, value in arrays.items()}:
        raise ValueError("its arrays belong to another scheme or stage")
    return _filled(begin, arrays, "")


def _filled(like: Any, arrays: dict[str, Any], prefix: str) -> Any:
    made = {}
    for name, value in _parts(like).items():
        whole = prefix + name
        if _parts(value):
            made[name] = _filled(value, arrays, f"{whole}.")
        else:
            array = np.asarray(arrays[whole])
            made[name] = array if isinstance(value, np.ndarray) else type(value)(array)
    return type(like)(**made)


def _parts(value: Any) -> dict[str, Any]:
    if isinstance(value, dict):
        return value
    if is_dataclass(value):
        return {field.name: getattr(value, field.name) for field in fields(value)}
    return {}


def write_checkpoint(path: Path, checkpoint: Checkpoint) -> None:
    """Write it whole, in place of the one before."""
    notes = {name: getattr(checkpoint, name) for name in NOTES}
    with replacing(path) as draft, draft.open("wb") as stream:
        np.savez(stream, **notes, **{f"state.{k}": v for k, v in checkpoint.state.items()})


def read_checkpoint(path: Path) -> Checkpoint:
    """Read it back.

    Raises:
        OSError: it can't be read.
        ValueError: it is none.
    """
    try:
        with path.open("rb") as stream, np.load(stream, allow_pickle=False) as content:
            state = {
                name.removeprefix("state."): content[name]
                for name in content.files
                if name.startswith("state.")
            }
            return Checkpoint(
                case=str(content["case"]),
                records=int(content["records"]),
                wall_time=float(content["wall_time"]),
                state=state,
            )
    except (KeyError, BadZipFile, EOFError, TypeError) as error:
        raise ValueError(f"no checkpoint ({error})") from None
