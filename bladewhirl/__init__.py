"""Whirl of bladed disks in contact with flexible casings.

A case in, a result out::

    import bladewhirl as bw

    case = bw.Case(excitation={"type": "imbalance"}, march={"speed": 1.2, "duration": "20 ms"})
    run = bw.run(case, "runs/first", frames=0)
    print(run)  # regime with its reasons, end, orbit, energies, contacts, ledger, files
    with run.open() as result:  # an xarray.Dataset in SI units, loaded when used
        bw.save_figure(bw.plot.orbit(result), "runs/first/my_orbit.png")

The public names, in the order of a study:

Describe a stage and its load
    `read_case` reads a case file, `Case` takes its tables as arguments, `case_from` takes nested
    dicts, `with_values` changes keys ("march.speed") and `dumps_case` gives the text of a file.
    `Sketch`, with `Section` and `Material`, draws a bladed disk of your own design. Numbers are in
    SI units, or text with a unit, such as "0.5 mm".
Build the model
    `build_stage` makes finite elements of bladed disk and casing, and the reduced model. `mesh3d`
    makes a superelement of a blade or a sector from a mesh of tetrahedra or hexahedra,
    `import_superelement` from the matrices of another finite element code; `write_superelement`
    and `read_superelement` store it.
Analyse modes, before a march
    `modes` returns frequencies by family and nodal diameter, `contact_modes` what modes do in
    contact, `campbell` coincidence speeds, `veering` frequencies and `critical_speeds` critical
    speeds against the stiffness of the shaft, `stability` growth rates, `response` amplitudes under
    engine-order forces, `amplification` that by mistuning, as Datasets. Of a shaft line:
    `line_modes`, `line_critical_speeds`, `line_campbell`, `line_stability`, `line_response` to
    unbalances and `line_order_response` to forces on the blades of its wheel.
Compute periodic rubs
    `periodic` returns periodic motions of a 3D blade in a wall, and their stability, without time
    integration; `branch` follows one over a key of the case through folds, `resume_branch`
    continues after an interruption. `record_motion` writes a turn of a motion as a run.
March in time
    `run` marches one case, `run_sweep` a case over ranges of its keys (`resume_sweep` finishes an
    interrupted sweep, `drawn_case` repeats one of its random draws), `convergence` varies time step
    and modes. Each writes a folder.
Read and draw results
    `open_result`, `open_sweep` and `open_branch` return Datasets, `probability` the shares of
    regimes in a sweep with draws. Functions of a result, or of a time window of a result in
    seconds: the shaft
    (`shaft_orbit`, `whirl_history`, `shaft_spectrum`, `shaft_spectrogram`, `poincare_map`), blades
    and casing (`gap`, `contact_force`, `tip_displacement`, `casing_displacement`,
    `stress_history`, `contact_classes`, `contact_phase`, `tip_timing`), the coating (`wear`),
    gauges and probes of a rig (`sensors`), points of a superelement (`displacement`), energies and
    growth (`strain_energies`, `family_energies`, `amplitude_growth`).
    `plot` has a function for each figure, `save_figure` writes one; `render` makes stills, films
    and pages, `export_vtk` a series for ParaView, `report` one HTML page of a run or a sweep.
Verify the program
    `verify` compares computed results with known solutions.
Handle errors
    Every error that a user can correct is a `UserError`, whose `lines` name file, key, value and
    the expected value: `CaseError`, `ResultError`, `ViewError` (a time, window or file that makes
    no sense) and `OffScreenError` (the system cannot draw pictures without a display).

Names are loaded when first used. The shell command ``bladewhirl`` offers the same functions.
Importing bladewhirl limits linear algebra to one thread, unless OMP_NUM_THREADS or the variable of
a library, such as OPENBLAS_NUM_THREADS, is set.
"""

import lazy_loader as _lazy_loader

from .threads import use_one_thread as _use_one_thread

_use_one_thread()

_load, _, __all__ = _lazy_loader.attach_stub(__name__, __file__)
__all__ += ["__version__"]


def __getattr__(name: str) -> object:
    """Import and return a public name, or the version of the installed package."""
    if name == "__version__":
        from importlib import metadata

        return metadata.version(__name__)
    return _load(name)


def __dir__() -> list[str]:
    """Return the public names, for tab completion."""
    return sorted(__all__)
