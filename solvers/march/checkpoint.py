"""Checkpoints: exact states of a march, stored on disk, from which a killed march is resumed."""

from dataclasses import dataclass, fields, is_dataclass
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np

from bladewhirl.files import check_regular, replacing

CHECKPOINT_NAME = "checkpoint.npz"
"""Name of the checkpoint file in the folder of a run."""

NOTES = ("case", "records", "wall_time")


@dataclass(frozen=True, kw_only=True)
class Checkpoint:
    """State of a march at the time when records were last written to disk."""

    case: str  #: digest of all data that affect the march, except its duration
    records: int  #: number of records in the result
    wall_time: float  #: elapsed wall-clock time [s]
    state: dict[str, Any]  #: arrays by name, from `state_arrays`


def state_arrays(state: Any, prefix: str = "") -> dict[str, Any]:
    """Return the numbers and arrays in the state of a scheme by name; dotted names lead into nested
    dataclasses and dictionaries."""
    arrays: dict[str, Any] = {}
    for name, value in _parts(state).items():
        whole = prefix + name
        arrays |= state_arrays(value, f"{whole}.") if _parts(value) else {whole: value}
    return arrays


def state_from(begin: Any, arrays: dict[str, Any]) -> Any:
    """Return the state with given arrays; this is the inverse of `state_arrays`.

    Args:
        begin: state of the same scheme at t = 0.
        arrays: arrays by name from `state_arrays`.

    Raises:
        ValueError: the arrays belong to another scheme or stage.
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
    """Write a checkpoint to a temporary file, which then replaces the previous checkpoint."""
    content: dict[str, Any] = {name: np.asarray(getattr(checkpoint, name)) for name in NOTES}
    content |= {f"state.{key}": np.asarray(value) for key, value in checkpoint.state.items()}
    with replacing(path) as draft, draft.open("wb") as stream:
        np.savez(stream, **content, digest=_digest(content))


def read_checkpoint(path: Path) -> Checkpoint:
    """Read a checkpoint.

    Raises:
        OSError: the file cannot be read.
        ValueError: the file is not a checkpoint, or was changed.
    """
    check_regular(path)
    try:
        with path.open("rb") as stream, np.load(stream, allow_pickle=False) as archive:
            content = dict(archive)
        if str(content.pop("digest")) != _digest(content):
            raise ValueError("its contents were changed")
        return Checkpoint(
            case=str(content.pop("case")),
            records=int(content.pop("records")),
            wall_time=float(content.pop("wall_time")),
            state={key.removeprefix("state."): value for key, value in content.items()},
        )
    except OSError:
        raise
    except Exception as error:  # of any type, for damaged bytes
        raise ValueError(f"no checkpoint ({error})") from None


def _digest(content: dict[str, Any]) -> str:
    """Return the SHA-256 digest of arrays by name."""
    digest = sha256()
    for name, array in sorted(content.items()):
        digest.update(f"{name} {array.dtype.str} {array.shape} ".encode() + array.tobytes())
    return digest.hexdigest()
