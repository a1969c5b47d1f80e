"""Ratios of computing times of the contact march: `python benchmarks/march.py`.

Four programs are timed alternately in one process: the C kernel (with contact, energy ledger and a
record every 100 steps), the C kernel with `rotation.effects = "full"`, the C kernel with
`contact.foreshortening`, and the march without either in NumPy (`Reference`). The timings start
from five states of the paper's stage. Each program starts from a state that was reached by a march
with its options, so with Coriolis forces the number of contacts can differ. The quadratic forms of
foreshortening are multiplied by a small factor: their computing time stays the same, but the motion
hardly changes, so the numbers of contacts are equal. The ratios are medians of the ratios of
successive timings.

* no contact: the imbalance case after 0.1 ms;
* few contacts: the imbalance case at 0.3 s, when five blades rub;
* half of the blades: the distortion case at 0.2 s, with a load of 150 ms. The motion diverges, and
  with the usual displacement limit the march would end earlier;
* all blades: the casing has closed by 1.3 mm on all blades, which are strongly damped;
* all blades, coating: the same with a coating of 4,000 rods, which the blades compress.

A second table has the times of a step with more and more blades, and the ratio to half as many; a
third one those of 22 blades with 7 contact nodes each in the ring, with true slip and without, for
several numbers of nodes in contact; a fourth one those of a wheel of sectors of solids
with its stiffness at speed, and with Coriolis forces as well, without contact and with contact of
all blades; a fifth one those of beams with rotation effects at a constant, a prescribed and a free
speed.
"""

import argparse
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Literal

import numpy as np
from rich.console import Console
from rich.table import Table

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.case.case import case_from
from bladewhirl.models.case.file import read_case
from bladewhirl.models.solids.blade import mesh3d
from bladewhirl.models.stage.build import contact_problem
from bladewhirl.models.stage.build_beams import build_beams
from bladewhirl.models.stage.contact_problem import ContactProblem
from bladewhirl.models.stage.modal_loads import Load, Start
from bladewhirl.models.superelements.file import write_superelement
from bladewhirl.solvers.march.central_difference import CentralDifference
from bladewhirl.solvers.march.march import KernelState
from bladewhirl.studies.runs.prepare import prepare

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests" / "support"))
from boundary_cases import bladed, casing
from reference_march import Reference, ReferenceState
from solid_meshes import STEEL, TIE, bladed_sector

EXAMPLES = Path(__file__).resolve().parent.parent / "examples"
TIME_STEP, SHORT = 1e-6, 2e-7  # s
RECORD_EVERY = 100
COMPARED_STEPS = 500
KERNEL_STEPS, NUMPY_STEPS = 2000, 25
SMALL_ROWS = 1e-7  # factor of the rows of the quadratic forms
OUT_OF_REACH = 10.0  # displacement limit [m], which no march reaches


@dataclass(frozen=True, kw_only=True)
class Setting:
    """A problem, its scheme, and the state from which timings start."""

    name: str
    problem: ContactProblem
    scheme: CentralDifference
    state: KernelState

    def kernel(self, steps: int) -> float:
        """March with the C kernel; return the mean number of contacts per step."""
        _, chunk, end = self.scheme.advance(self.state, steps)
        if end is not None:
            raise RuntimeError(f"{self.name}: the march ended")
        whole = chunk.step[-1] - chunk.step[0]
        return float(chunk.contact_steps[1:].sum() / whole)

    def numpy(self) -> tuple[Reference, ReferenceState]:
        """Return the march in NumPy and its initial state, one step after `state`."""
        every = CentralDifference(self.problem, TIME_STEP, 1)
        _, chunk, _ = every.advance(self.state, 2)
        before, now = np.hstack([chunk.rotor_displacement, chunk.casing_displacement])
        plain = Reference(self.problem, TIME_STEP, RECORD_EVERY)
        begin = replace(plain.init(), step=int(chunk.step[1]), before=before, now=now)
        if chunk.coating is not None:
            begin = replace(begin, strain=chunk.coating.coating_strain[-1])
        return plain, begin

    def difference(self) -> float:
        """Return the largest difference of C and NumPy displacements, divided by the largest
        displacement."""
        every = CentralDifference(self.problem, TIME_STEP, 1)
        plain, begin = self.numpy()
        _, expected, _ = plain.advance(begin, COMPARED_STEPS, 1)
        _, chunk, _ = every.advance(self.state, COMPARED_STEPS + 1)
        ours = np.hstack([chunk.rotor_displacement, chunk.casing_displacement])[1:]
        theirs = np.hstack([expected.rotor_displacement, expected.casing_displacement])
        return float(np.abs(ours - theirs).max() / np.abs(theirs).max())


CLOSING = [
    *("excitation.type=none", "damping.ratio=0.3"),
    "casing.closure={table=[[0,0],['20 ms','1.3 mm']]}",
]
"""Changes of a case that press all blades to the wall."""

CLOSED = 25_000
"""Number of steps after which the casing has closed."""

OPTIONS = ("rotation.effects=none", "rotation.effects=full", "contact.foreshortening=true")


def settings() -> list[list[Setting]]:
    """Return the settings for the states in the module docstring: for each state one with each of
    `OPTIONS`."""

    def reached(name: str, example: str, changes: list[str], steps: int) -> list[Setting]:
        made = []
        for option in OPTIONS:
            case = read_case(EXAMPLES / f"{example}.toml", [*changes, option])
            problem = contact_problem(build_beams(case))
            problem = replace(problem, displacement_limit=OUT_OF_REACH)
            if (bending := problem.foreshortening) is not None:
                scaled = replace(bending, rows=SMALL_ROWS * bending.rows)
                problem = replace(problem, foreshortening=scaled)
            scheme = CentralDifference(problem, TIME_STEP, RECORD_EVERY)
            state, _, _ = scheme.advance(scheme.init(), steps)
            made.append(Setting(name=name, problem=problem, scheme=scheme, state=state))
        return made

    coating = (
        "casing.coating={thickness='5 mm',young_modulus='1 GPa',yield_stress='10 kPa',"
        "hardening='50 MPa',elements=4000}"
    )
    push = ["excitation.duration=150 ms", "damping.ratio=0.005"]
    return [
        reached("no contact", "imbalance", [], 100),
        reached("few contacts", "imbalance", [], 300_000),
        reached("half of the blades", "casing_distortion", push, 200_000),
        reached("all blades", "casing_distortion", CLOSING, CLOSED),
        reached("all blades, coating", "casing_distortion", [*CLOSING, coating], CLOSED),
    ]


BLADES, NODES = 22, 7
PUSHED = (0, 1, 2, 3, 6)  # numbers of blades that are pressed to the wall


def pressed(blades: int, sliding: Literal["permanent", "full"]) -> Setting:
    """Return strongly damped blades in a ring, some of which are pressed to the wall."""
    ring = casing(88, support=1e8, damping=0.05)
    problem = bladed(BLADES, NODES, ring=ring, sliding=sliding)
    rotor = replace(problem.rotor, damping_ratio=np.full_like(problem.rotor.frequency, 0.3))
    force = np.zeros((BLADES, len(rotor.frequency) // BLADES))
    force[:blades, 0] = 2500.0
    still = np.zeros(len(ring.frequency))
    problem = replace(
        problem,
        rotor=rotor,
        loads=(Load(rotor=force.ravel(), casing=still, ramp=1e-3),),
        start=Start.of_rotor(*np.zeros((2, force.size)), len(still)),
    )
    scheme = CentralDifference(problem, 2.0 * TIME_STEP, RECORD_EVERY)
    state, _, _ = scheme.advance(scheme.init(), 10_000)
    return Setting(name=f"{blades} blades", problem=problem, scheme=scheme, state=state)


STAGES = (22, 44, 88, 176)  # numbers of blades


def blade_table(repeat: int) -> Table:
    """Return the times of a step of stages with more and more blades, without contact."""
    table = columns(
        f"Blades, no contact, best of {repeat} interleaved timings",
        *("blades", "kernel [µs]", "ratio to half as many"),
    )
    schemes = []
    for blades in STAGES:
        kept = f"reduction.fixed_interface_modes={5 * blades}"
        schemes.append(begun("imbalance", [f"bladed_disk.blades={blades}", kept]))
    times = interleaved(schemes, repeat)
    ratios = np.median(times[:, 1:] / times[:, :-1], axis=0)
    for blades, best, ratio in zip(STAGES, times.min(axis=0), [np.nan, *ratios], strict=True):
        table.add_row(str(blades), f"{best:.2f}", "" if np.isnan(ratio) else f"{ratio:.2f}")
    return table


SPEEDS = {
    "constant": "speed=1.5",
    "prescribed": 'speed_table=[["0 s",1.2],["0.3 s",1.6]]',
    "free": "speed=1.5,drive={inertia=0.5}",
}


def speed_table(repeat: int) -> Table:
    """Return the times of a step with rotation effects at speeds that vary, without contact."""
    table = columns(
        f"Speed, rotation effects, no contact, best of {repeat}",
        *("speed", "kernel [µs]", "ratio to constant"),
        text="speed",
    )
    imbalance = 'excitation={type="imbalance",unbalance=0.02,ramp=0}'
    march = "march={{time_step=1e-6,duration=0.3,record_step=1e-4,{}}}"
    times = interleaved(
        [begun("spinning_fan", [imbalance, march.format(keys)]) for keys in SPEEDS.values()], repeat
    )
    ratios = np.median(times / times[:, :1], axis=0)
    for name, best, ratio in zip(SPEEDS, times.min(axis=0), ratios, strict=True):
        table.add_row(name, f"{best:.2f}", f"{ratio:.2f}")
    return table


def begun(example: str, changes: list[str]) -> Callable[[int], object]:
    """Return a function that marches an example with changes from its state after 100 steps."""
    problem = contact_problem(build_beams(read_case(EXAMPLES / f"{example}.toml", changes)))
    scheme = CentralDifference(problem, TIME_STEP, RECORD_EVERY)
    return partial(scheme.advance, scheme.advance(scheme.init(), 100)[0])


def node_table(repeat: int) -> Table:
    """Return the times of a step of many contact nodes."""
    table = columns(
        f"{BLADES} blades x {NODES} contact nodes in a ring, best of {repeat}",
        *("pressed", "contacts per step", "kernel [µs]", "true slip [µs]"),
        text="pressed",
    )
    for blades in PUSHED:
        both = pressed(blades, "permanent"), pressed(blades, "full")
        plain, full = interleaved([each.kernel for each in both], repeat).min(axis=0)
        contacts = both[0].kernel(KERNEL_STEPS)
        table.add_row(both[0].name, f"{contacts:.2f}", f"{plain:.2f}", f"{full:.2f}")
    return table


def wheels(closing: float) -> list[Setting]:
    """Return twelve sectors of solids with massless contact nodes, without and with Coriolis
    forces, after the rigid wall has closed by a distance [m]."""
    part = mesh3d(
        bladed_sector("hexahedron20"), **STEEL, **TIE, contacts=3, coriolis=True, stress=False
    )
    made = []
    with TemporaryDirectory() as folder:
        file = Path(folder) / "sector.npz"
        write_superelement(file, part)
        table = {"file": str(file), "kind": "sector", "copies": TIE["copies"]}
        for effects in ("centrifugal", "full"):
            case = case_from(
                {
                    "bladed_disk": {"superelement": table},
                    "reduction": {"free_interface_modes": 6},
                    "casing": {
                        "type": "rigid",
                        "clearance": 1e-4,
                        "closure": {"table": [[0, 0], [1e-3, closing]]},
                    },
                    "damping": {"ratio": 0.1},
                    "rotation": {"effects": effects},
                    "march": {"speed": "3000 rpm", "duration": 1.0, "time_step": SHORT},
                }
            )
            problem = prepare(case).problem
            scheme = CentralDifference(problem, SHORT, RECORD_EVERY)
            state, _, _ = scheme.advance(scheme.init(), 8000)
            made.append(Setting(name=effects, problem=problem, scheme=scheme, state=state))
    return made


def turning_table(repeat: int) -> Table:
    """Return the times of a step of a wheel with rotation effects."""
    table = columns(
        f"Wheel of sectors of solids, best of {repeat}",
        *("contacts per step", "effects", "kernel [µs]", "ratio"),
        text="effects",
    )
    for closing in (0.9e-4, 1.02e-4):
        every = wheels(closing)
        times = interleaved([one.kernel for one in every], repeat)
        ratios = np.median(times / times[:, :1], axis=0)
        for one, best, ratio in zip(every, times.min(axis=0), ratios, strict=True):
            contacts = f"{one.kernel(KERNEL_STEPS):.2f}"
            table.add_row(contacts, one.name, f"{best:.2f}", f"{ratio:.2f}")
    return table


def columns(title: str, *names: str, text: str = "") -> Table:
    """Return an empty table of numbers, with one column of `text`."""
    table = Table(title=title)
    for name in names:
        table.add_column(name, justify="left" if name == text else "right")
    return table


def interleaved(
    marches: Sequence[Callable[[int], object]], repeat: int, steps: Sequence[int] | None = None
) -> FloatArray:
    """Return the processor times per step [µs] of functions that march a number of steps, which
    are called in turn, (repeat, marches); `steps` are their numbers of steps."""
    both = list(zip(marches, steps or [KERNEL_STEPS] * len(marches), strict=True))
    return np.array([[microseconds(*each) for each in both] for _ in range(repeat)])


def microseconds(work: Callable[[int], object], steps: int) -> float:
    """Return the processor time per step [µs] of a function that marches a number of steps."""
    start = time.thread_time()
    work(steps)
    return (time.thread_time() - start) / steps * 1e6


def main() -> None:
    """Time the four programs alternately, many times; print the shortest times and the ratios."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--repeat", type=int, default=100, help="number of timings of each program")
    repeat = parser.parse_args().repeat
    table = columns(
        f"Contact march, best of {repeat} interleaved timings",
        "state", "contacts per step", "contacts, full", "contacts, bent", "kernel [µs]",
        "full [µs]", "bent [µs]", "NumPy [µs]", "full / kernel", "bent / kernel", "NumPy / kernel",
        "kernel and NumPy differ by",
        text="state",
    )  # fmt: skip
    for alike in settings():
        setting = alike[0]
        difference = setting.difference()
        contacts = [each.kernel(KERNEL_STEPS) for each in alike]
        plain, begin = setting.numpy()
        marches = [*(each.kernel for each in alike), partial(plain.advance, begin)]
        times = interleaved(marches, repeat, [KERNEL_STEPS] * len(alike) + [NUMPY_STEPS])
        kernel, full, drawn, numpy = times.min(axis=0)
        table.add_row(
            setting.name, *(f"{number:.2f}" for number in contacts), f"{kernel:.2f}",
            f"{full:.2f}", f"{drawn:.2f}", f"{numpy:.1f}",
            *(f"{ratio:.2f}" for ratio in np.median(times[:, 1:3] / times[:, :1], axis=0)),
            f"{numpy / kernel:.1f}",
            f"{difference:.0e}",
        )  # fmt: skip
    Console(width=180).print(table)
    for further in (blade_table, node_table, turning_table, speed_table):
        Console(width=180).print(further(repeat))


if __name__ == "__main__":
    main()
