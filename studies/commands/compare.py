"""`bladewhirl compare`: march one case with every contact scheme."""

from pathlib import Path
from typing import Annotated

from bladewhirl.studies.commands import options
from bladewhirl.studies.commands.output import emit, table
from bladewhirl.studies.commands.progress import progress_bar
from bladewhirl.studies.modal.columns import Column

QUANTITIES = (
    Column("end_time", "end [ms]", ".4g", 1e3),
    Column("tip_displacement", "largest tip displacement [mm]", ".4g", 1e3),
    Column("distance", "difference of tip displacements [%]", ".4g", 1e2),
    Column("impulse", "normal impulse [N s]", ".4g"),
    Column("friction_impulse", "friction impulse [N s]", ".4g"),
    Column("friction_work", "work of friction [J]", ".4g"),
    Column("energy", "energy at the end [J]", ".4g"),
    Column("ledger", "mismatch of energy and work / largest term", ".4g"),
    Column("penetration", "deepest penetration [µm]", ".4g", 1e6),
    Column("step_cost", "cost of a step [µs]", ".4g", 1e6),
)
"""Rows of the table, which has a column for each scheme."""


def compare(
    case: options.CaseFile,
    output: Annotated[Path | None, options.output("Folder to make, for a figure.")] = None,
    overwrite: options.Overwrite = False,
    json: options.AsJson = False,
    overrides: options.Changes = None,
) -> None:
    """March a case with every contact scheme, side by side.

    The schemes are central differences with multipliers, Moreau and Jean's impacts with sticking
    friction, and a penalty, see march.scheme. The table lists displacements, impulses, energy and
    cost, and the difference of the tip displacements from those of the first scheme. A step of the
    other two schemes costs fifty to a hundred times that of the first, so choose a short march:
    --set march.duration=0.05.
    """
    from bladewhirl.models.case.file import faults_from, read_case
    from bladewhirl.studies.convergence.schemes import compare_schemes, schemes_document

    values = overrides or []
    read = read_case(case, values)
    with faults_from(case, values), progress_bar("marching") as update:
        data = compare_schemes(read, output, overwrite=overwrite, progress=update)
    document = schemes_document(data)
    schemes = document["schemes"]
    rows = [
        {"quantity": quantity.heading}
        | {scheme["scheme"]: quantity.text(scheme) for scheme in schemes}
        for quantity in QUANTITIES
    ]
    columns = [
        Column("quantity", "quantity"),
        *(Column(scheme["scheme"], scheme["scheme"], ">") for scheme in schemes),
    ]
    emit(document, table(rows, columns, document["title"]), json=json, written=[output])
