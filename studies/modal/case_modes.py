"""What commands on modes begin with: the case file, checked, and its stage's modes."""

from __future__ import annotations

from pathlib import Path

from bladewhirl.models.case.file import faults_from, read_case
from bladewhirl.models.modal.full_stage import ModalStage, modal_stage


def modes_of_case(file: Path, overrides: list[str] | None) -> ModalStage:
    """Modes of the stage of a case file.

    Args:
        file: the case.
        overrides: "KEY=VALUE" as given to --set.

    Raises:
        CaseError: all faults of the case, naming the file or --set.
    """
    values = overrides or []
    case = read_case(file, values)
    with faults_from(file, values):
        return modal_stage(case)
