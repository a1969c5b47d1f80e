"""Writes pyharm_joint.csv: a mass with a 3D friction joint by pyharm-os 1.2.2, numpy 2.4, jax.

Run in an environment of its own (`pip install pyharm-os==1.2.2`): python pyharm_joint.py. The unit
mass has springs in three coupled directions and a damping ratio of 2 % of each mode. It is pressed
on a wall by the preload along the first direction, through a normal and a tangential spring, and
slides in the other two. Each row of the file is a frequency and the complex amplitudes of the first
harmonic of the three displacements.
"""

from pathlib import Path

import numpy as np
import pyHarm

STIFFNESS = np.array([[2.0, 0.3, 0.1], [0.3, 1.0, 0.2], [0.1, 0.2, 1.5]])
RATIO = 0.02

squares, shapes = np.linalg.eigh(STIFFNESS)
damping = shapes @ np.diag(2.0 * RATIO * np.sqrt(squares)) @ shapes.T
mass = {"mass": [0]}
pushes = [("CosinusForcing", 0.3), ("CosinusForcing", 1.0), ("SinusForcing", 0.6)]
maestro = pyHarm.Maestro(
    {
        "substructures": {
            "mass": {
                "type": "substructure",
                "matrix": {
                    "M": np.eye(3),
                    "C": damping,
                    "K": STIFFNESS,
                    "G": np.zeros((3, 3)),
                },
                "ndofs": 3,
                "nnodes": 1,
            }
        },
        "connectors": {
            **{
                f"push{n}": {"type": kind, "connect": mass, "dirs": [n], "amp": size}
                for n, (kind, size) in enumerate(pushes)
            },
            "joint": {
                "type": "Penalty3D",
                "connect": mass,
                "dirs": [0, 1, 2],
                "k_n": 1.0,
                "k_t": 0.5,
                "g": 0.0,
                "mu": 0.4,
                "N0": 2.5,
                "jac": "jax",
            },
        },
        "system": {
            "type": "Base",
            "nh": 15,
            "nti": 2048,
            "adim": {"status": False, "lc": 1.0, "wc": 1.0},
        },
        "analysis": {
            "response": {
                "study": "frf",
                "puls_inf": 0.9,
                "puls_start": 0.9,
                "puls_sup": 1.4,
                "ds_min": 1e-4,
                "ds_max": 0.5,
                "ds0": 0.05,
                "solver": "scipyroot",
                "verbose": False,
            }
        },
        "export": {"status": False},
    }
)
maestro.operate()
rows = []
for solution in maestro.nls["response"].SolList[::8]:
    *parts, frequency = np.asarray(solution.x)
    real, imaginary = np.array(parts[3:6]), -np.array(parts[6:9])
    rows.append([frequency, *np.column_stack([real, imaginary]).ravel()])
np.savetxt(Path(__file__).with_suffix(".csv"), rows, fmt="%.9g", delimiter=",")
