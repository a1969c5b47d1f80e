"""Compare the eigenvalues of a rotor that `bladewhirl verify shaft` expects with those of ROSS.

    python tests/data/ross_rotor.py

The rotor has several diameters, three bearings with cross terms, and a support. Python must have
ROSS (`pip install ross-rotordynamics==2.3.0 'plotly<6'`), not bladewhirl. The elements are the
same, so that decay rates and frequencies agree within `TOLERANCE` of the absolute value of the
eigenvalue.
"""

import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
import ross

DATA = Path(__file__).parents[2] / "studies" / "verification" / "data" / "shaft.json"
TOLERANCE = 1e-8
YOUNG_MODULUS, DENSITY, POISSON_RATIO = 210e9, 7800.0, 0.3
SAME_PLACE = 1e-9  #: [m]


def matrix(kind: str, given: Any) -> dict[str, float]:
    """Return a 2 x 2 matrix, or a number for equal axes, as arguments of a bearing."""
    (xx, xy), (yx, yy) = given if isinstance(given, list) else ((given, 0.0), (0.0, given))
    return {f"{kind}xx": xx, f"{kind}xy": xy, f"{kind}yx": yx, f"{kind}yy": yy}


def bearing(row: dict[str, Any], **nodes: int) -> Any:
    damping = matrix("c", row.get("damping", 0.0))
    return ross.BearingElement(**nodes, **matrix("k", row["stiffness"]), **damping)


def rotor_of(line: dict[str, Any]) -> Any:
    """Return the rotor of ROSS for a table `shaft_line`."""
    shear = YOUNG_MODULUS / (2.0 + 2.0 * POISSON_RATIO)
    steel = ross.Material("steel", rho=DENSITY, E=YOUNG_MODULUS, G_s=shear)
    elements, places = [], [0.0]
    for segment in line["segments"]:
        length = segment["length"] / segment["elements"]
        for _ in range(segment["elements"]):
            number = len(elements)
            diameters = {"idl": segment["inner_diameter"], "odl": segment["outer_diameter"]}
            elements.append(ross.ShaftElement(length, **diameters, material=steel, n=number))
            places.append(places[-1] + length)

    def node(position: float) -> int:
        nearest = int(np.abs(np.array(places) - position).argmin())
        assert abs(places[nearest] - position) < SAME_PLACE, position
        return nearest

    disks = [
        ross.DiskElement(
            n=node(row["position"]),
            m=row["mass"],
            Id=row["diametral_inertia"],
            Ip=row["polar_inertia"],
        )
        for row in line["disks"]
    ]
    bearings, masses, following = [], [], len(places)
    for row in line["bearings"]:
        at = {"n": node(row["position"])}
        if (support := row.get("support")) is not None:
            at["n_link"] = following
            masses.append(ross.PointMass(n=following, m=support["mass"]))
            bearings.append(bearing(support, n=following))
            following += 1
        bearings.append(bearing(row, **at))
    return ross.Rotor(elements, disks, bearings, masses)


def main() -> None:
    known = json.loads(DATA.read_text())["stepped"]
    rotor, worst = rotor_of(known["shaft_line"]), 0.0
    for speed, rows in known["eigenvalues"].items():
        modes = rotor.run_modal(float(speed), num_modes=4 * rotor.nodes[-1], sparse=False)
        for expected in (complex(*row) for row in rows):
            worst = max(worst, float(np.abs(modes.evalues - expected).min() / abs(expected)))
    print(f"ROSS {ross.__version__}: largest relative difference of eigenvalues {worst:.2g}")
    if not worst < TOLERANCE:
        sys.exit(f"expected less than {TOLERANCE:g}")


if __name__ == "__main__":
    main()
