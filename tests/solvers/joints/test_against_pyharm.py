"""A mass on a 3D friction joint against the harmonic balance of pyHarm; tests/data/pyharm_joint.py
made the data."""

import numpy as np
from places import DATA

from bladewhirl.meshes.line_mesh import FloatArray
from bladewhirl.models.joints.wheel import JointedWheel
from bladewhirl.solvers.periodic.joint_search import joint_motion

STIFFNESS = np.array([[2.0, 0.3, 0.1], [0.3, 1.0, 0.2], [0.1, 0.2, 1.5]])
RATIO, PRELOAD, FRICTION = 0.02, 2.5, 0.4
SPRINGS = np.array([1.0, 0.5, 0.5])  #: of the joint, normal and two tangents
PUSH = np.array([0.3, 1.0, -0.6j])


def wheel(speed: float) -> JointedWheel:
    """Blades that touch the next one, which does not move at its left node."""
    squares, shapes = np.linalg.eigh(STIFFNESS)
    contact, compliance = np.zeros((1, 6, 3)), np.zeros((1, 6, 1, 6))
    contact[0, 3:] = np.diag([1.0, -1.0, -1.0]) @ shapes
    compliance[0, range(3, 6), 0, range(3, 6)] = 1.0 / SPRINGS
    flexible = shapes[0] @ (shapes[0] / squares) + 1.0 / SPRINGS[0]
    damping: FloatArray = np.diag(2.0 * RATIO * np.sqrt(squares))
    return JointedWheel(
        names=("wall",),
        joint=np.zeros(1, dtype=np.int64),
        friction=np.array([FRICTION]),
        gap=np.array([-PRELOAD * flexible]),
        speed=speed,
        blades=2,
        stiffness=np.tile(squares, (2, 1)),
        damping=np.tile(damping, (2, 1, 1)),
        contact=contact,
        compliance=compliance,
        loads={1: shapes.T @ PUSH},
        static={1: np.zeros(6, dtype=np.complex128)},
        points=shapes,
        loaded=(0,),
        points_by_force=np.zeros((3, 1, 6)),
    )


def test_a_joint_in_three_directions_is_that_of_pyharm() -> None:
    frequency, *parts = np.loadtxt(DATA / "pyharm_joint.csv", delimiter=",", unpack=True)
    expected = np.array(parts[::2]) + 1j * np.array(parts[1::2])
    for n, speed in enumerate(frequency.tolist()):
        given = wheel(speed)
        found = given.at_points(1, joint_motion(given).of_order(1))[0]
        apart = np.linalg.norm(found - expected[:, n])
        assert apart < 1e-3 * np.linalg.norm(expected[:, n]), speed
