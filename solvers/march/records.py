"""Records of a march in memory, for marches whose histories are not written to a file."""

from collections.abc import Mapping

import numpy as np

from bladewhirl.models.stage.contact_problem import rod_angles
from bladewhirl.solvers.march import recorder
from bladewhirl.solvers.march.march import CoatingRecords, joined
from bladewhirl.solvers.march.schema import TIME

CASING = ("casing_displacement", "casing_velocity")
"""Histories of the motion of the casing."""


class Records:
    """Store of the records of a march in memory, with the interface of `Recorder`.

    Args:
        stage: arrays that describe the stage.
        attributes: attributes of the result.
        most: largest number of records, for which memory is allocated.
        room: arrays of an earlier march whose records are no longer needed. Large enough arrays are
            reused, because new memory pages cost more time than writing.
        casing: whether the motion of the casing is stored.
    """

    def __init__(
        self,
        stage: recorder.Arrays,
        attributes: Mapping[str, recorder.Attribute],
        most: int,
        room: dict[str, recorder.Values] | None = None,
        casing: bool = True,
    ) -> None:
        self.stage, self.records, self.steps = stage, 0, 0
        self.attributes = dict(attributes)
        sizes = recorder.sizes_of(stage)
        self._coating: list[CoatingRecords] = []
        self._room: dict[str, recorder.Values] = {} if room is None else room
        self._history = recorder.tables_of_stage(stage).history
        self._stored = [name for name in self._history if casing or name not in CASING]
        for name in self._stored:
            variable = self._history[name]
            widths, stored = tuple(recorder.widths_of(variable, sizes)), self._room.get(name)
            if stored is None or len(stored) < most or stored.shape[1:] != widths:
                self._room[name] = np.empty((most, *widths), dtype=variable.kind)

    @property
    def histories(self) -> dict[str, recorder.Values]:
        """All records that are stored, by the names of the schema."""
        histories = {name: self._room[name][: self.records] for name in self._stored}
        if self._coating:
            coating = vars(joined(self._coating))
            for name, variable in recorder.tables_of_stage(self.stage).coating.items():
                if name in coating:
                    most = self.records if variable.dimensions[0] == TIME else None
                    histories[name] = coating[name][:most]
            histories["rod_angle"] = rod_angles(coating["coating_strain"].shape[-1])
        return histories

    def write(self, chunk: recorder.AnyChunk) -> None:
        """Append records.

        Raises:
            NonFiniteError: a record is not finite; this record and all later ones are left out.
        """
        history = {name: np.asarray(getattr(chunk, name)) for name in self._history}
        finite = recorder.finite_records(history)
        last = self.records + finite
        for name in self._stored:
            self._room[name][self.records : last] = history[name][:finite]
        self.records = last
        if chunk.coating is not None:
            self._coating.append(chunk.coating)
        if finite:
            self.steps = int(chunk.step[finite - 1])
        if finite < chunk.records:
            raise recorder.NonFiniteError(f"record {last} is not finite")

    def finish(self, reason: str, message: str, report: Mapping[str, recorder.Attribute]) -> None:
        """Store the reason of the end, a message and the quality measures of the march."""
        self.attributes |= {"end_reason": reason, "end_message": message, **report}
