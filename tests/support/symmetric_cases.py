"""Random cases with every feature of a march, and what becomes of them in a mirror or after a turn.

A feature is a function in `BEAMS` or `SOLIDS` that adds its keys to a case. Each key that it adds
has a row in `RULES`, which tells how its values change in a mirror image (y to -y), after a turn of
the wall and of all loads by one sector, and when front and back are exchanged (z to -z). A key
without a row ends in a KeyError, so that no feature is drawn without being compared.
"""

import copy
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import scipy.sparse as sp
from solid_meshes import STEEL, TIE, Array, bladed_sector, grid_mesh

import bladewhirl as bw
from bladewhirl.models.superelements.superelement import FIXED, Superelement
from bladewhirl.studies.runs.prepare import prepare
from bladewhirl.studies.runs.recorded_march import march_in_memory

Rng = np.random.Generator
Change = Callable[[Any, "Image"], Any]


@dataclass(frozen=True)
class Image:
    """What is done to a case: "mirror", "turn" or "flip"."""

    kind: str
    blades: int

    @property
    def blade(self) -> Array:
        """Number of each blade after the change, (blades,)."""
        number = np.arange(self.blades)
        return {"mirror": -number, "turn": number + 1, "flip": number}[self.kind] % self.blades

    @property
    def sector(self) -> float:
        """Angle of a sector [rad]."""
        return 2.0 * np.pi / self.blades


def kept(value: Any, image: Image) -> Any:
    return value


def negative(value: Any, image: Image) -> Any:
    if isinstance(value, str):
        number, unit = value.split()
        return f"{-float(number)!r} {unit}"
    return -value


def turned(value: Any, image: Image) -> Any:
    return value + image.sector


def moved_blades(value: Any, image: Image) -> Any:
    """Numbers of blades."""
    return [int(image.blade[each]) for each in value]


def moved_values(value: Any, image: Image) -> Any:
    """A value for each blade."""
    return [value[int(n)] for n in np.argsort(image.blade)]


def in_table(value: Any, image: Image) -> Any:
    return [[time, negative(speed, image)] for time, speed in value]


def backward(value: Any, image: Image) -> Any:
    return [[-place, radius] for place, radius in reversed(value)]


class Rule(NamedTuple):
    mirror: Change = kept
    turn: Change = kept
    flip: Change = kept


ANGLE = Rule(negative, turned)
SIGNED = Rule(negative)
BLADES = Rule(moved_blades, moved_blades)
ORDER = 2  #: engine order of the loads


def behind(value: Any, image: Image) -> Any:
    """Phase of an engine order after a turn of the stationary field."""
    return value - ORDER * image.sector


RULES = {
    "bladed_disk.mistuning.stiffness": Rule(moved_values, moved_values),
    "blade_loss.blade": BLADES,
    "casing.clearance_lobes.phase": ANGLE,
    "casing.closure.lobes.phase": ANGLE,
    "casing.contour": Rule(flip=backward),
    "casing.slope": Rule(flip=negative),
    "casing.springs.angle": ANGLE,
    "casing.stiffened_arcs.start": ANGLE,
    "casing.struts.angle": ANGLE,
    "casing.struts.inclination": SIGNED,
    "casing.thickness_lobes.phase": ANGLE,
    "engine-order.direction": SIGNED,
    "engine-order.phase": Rule(negative, behind),
    "tangential.phase": Rule(lambda value, image: np.pi - value, behind),
    "imbalance.phase": ANGLE,
    "march.drive.torque": SIGNED,
    "march.run_up.from": SIGNED,
    "march.run_up.to": SIGNED,
    "march.speed": SIGNED,
    "march.speed_table": Rule(in_table),
}
"""How the values of keys change."""

UNCHANGED = {
    *("march.run_up.start", "march.run_up.end", "march.drive.inertia", "march.drive.loss"),
    *("march.time_step", "march.duration", "march.record_step", "blade_loss.time"),
    *("blade_loss.from", "damping.ratio", "contact.friction", "contact.sliding"),
    *("rotation.effects", "reduction.free_interface_modes", "reduction.boundary"),
    *("reduction.fixed_interface_modes", "bladed_disk.blades", "bladed_disk.elements_per_blade"),
    *("bladed_disk.tip_radius", "bladed_disk.disk_radius", "bladed_disk.superelement.copies"),
    *("bladed_disk.superelement.kind", "bladed_disk.superelement.angle"),
}
"""Keys of no direction, outside the tables of the wall, the shaft and the loads."""

UNDIRECTED = {"casing", "shaft", "engine-order", "tangential", "imbalance"}
"""Tables of which only the keys in `DIRECTED` have a direction."""


def changed(case: Any, image: Image, path: str = "") -> Any:
    """Return a case, or a part of it at a path of keys, after a change.

    Raises:
        KeyError: no row of `RULES` says what becomes of a key.
    """
    if path in RULES:
        return getattr(RULES[path], image.kind)(case, image)
    if isinstance(case, dict):
        if path == "excitation":
            tangential = case["type"] == "engine-order" and "direction" not in case
            path = "tangential" if tangential else case["type"]
        return {
            key: changed(value, image, f"{path}.{key}" if path else key)
            for key, value in case.items()
        }
    if isinstance(case, list) and case and isinstance(case[0], dict):
        return [changed(each, image, path) for each in case]
    if path == "bladed_disk.superelement.file":
        return case.replace(".npz", f"-{image.kind}.npz") if image.kind != "turn" else case
    named = path.rsplit(".", 1)[-1]
    if path in UNCHANGED or (path.split(".")[0] in UNDIRECTED and named not in DIRECTED):
        return copy.deepcopy(case)
    raise KeyError(path)


DIRECTED = {"angle", "phase", "direction", "inclination", "slope", "contour", "start", "stop"}
"""Names of keys of the wall and of loads that need a row."""


def speeds(rng: Rng, case: dict[str, Any], *, free: bool) -> None:
    """A constant speed, a table, a run-up or a free speed, forward or backward."""
    sign = rng.choice([-1.0, 1.0])
    low, middle, high = (f"{sign * each} rad/s" for each in (560.0, 610.0, 660.0))
    march = case["march"]
    kind = rng.choice(["speed", "table", "run_up", *(["drive"] if free else [])])
    if kind == "table":
        march["speed_table"] = [[0.0, high], [2e-3, low], [5e-3, middle]]
    elif kind == "run_up":
        march["run_up"] = {"from": low, "to": high, "start": 1e-3, "end": 4e-3}
    else:
        march["speed"] = middle
    if kind == "drive":
        torque = sign * rng.uniform(-2e4, 2e4)
        march["drive"] = {"inertia": 0.5, "torque": float(torque), "loss": 0.3}


def struck_wall(rng: Rng, case: dict[str, Any]) -> None:
    """Springs, struts, lobes of the thickness, and a coating; each with a chance of one half."""
    wall = case["casing"]
    if wall.get("type") != "rigid":
        if rng.integers(2):
            spring = {"radial": 5e6, "tangential": 2e6, "radial_damping": 300.0}
            wall["springs"] = [spring | {"angle": float(rng.uniform(-3.0, 3.0))}]
        if rng.integers(2):
            strut = {"length": 0.3, "width": 0.05, "thickness": 0.01, "ends": "built-in"}
            places = {"angle": float(rng.uniform(-3.0, 3.0)), "inclination": 0.5}
            wall["struts"] = [strut | places]
    if "drive" in case["march"]:  # lobes of a closure and coatings are refused
        return
    if rng.integers(2):
        blades = blades_of(case)
        wall["coating"] = {"thickness": 1e-3, "young_modulus": 3e8, "yield_stress": 2e6}
        wall["coating"] |= {"hardening": 2e7, "elements": blades * wall.get("elements", 6 * blades)}
    if rng.integers(2):
        lobes = [{"lobes": 3, "amplitude": 3e-5, "phase": float(rng.uniform(-3.0, 3.0))}]
        wall["closure"] = {"amount": 1e-4, "time_constant": 2e-3, "lobes": lobes}


def blades_of(case: dict[str, Any]) -> int:
    """Number of blades of a case."""
    disk = case["bladed_disk"]
    return int(disk["superelement"]["copies"] if "superelement" in disk else disk["blades"])


def lost(rng: Rng, case: dict[str, Any]) -> None:
    """One blade or two break off."""
    if rng.integers(2):
        case["blade_loss"] = {"blade": [[1], [0, 2]][rng.integers(2)], "time": 2e-3}


def mistuned(rng: Rng, case: dict[str, Any]) -> None:
    """Blades that differ."""
    if "blade_loss" not in case and blades_of(case) > 1 and rng.integers(2):
        factors = 1.0 + 0.02 * rng.standard_normal(blades_of(case))
        case["bladed_disk"]["mistuning"] = {"stiffness": factors.tolist()}


def ordered(rng: Rng, case: dict[str, Any]) -> None:
    """Forces of an engine order along any direction."""
    table = case["bladed_disk"].get("superelement", {})
    stiff = 20.0 if table.get("kind") == "sector" else 1.0
    load: dict[str, Any] = {"type": "engine-order", "order": [ORDER]}
    load["amplitude"] = stiff * float(rng.uniform(80.0, 200.0))
    load["phase"] = float(rng.uniform(-3.0, 3.0))
    if table:
        load["direction"] = float(rng.uniform(-3.0, 3.0))
    case["excitation"] = [*case.get("excitation", []), load]


def sloped(rng: Rng, case: dict[str, Any]) -> None:
    """A cone; or a contour, where the wall is rigid."""
    wall, kind = case["casing"], rng.integers(3)
    if kind == 1:
        wall["slope"] = float(rng.uniform(-0.3, 0.3))
    if kind == 2 and wall.get("type") == "rigid":
        radius = 0.15 if case["bladed_disk"]["superelement"]["kind"] == "sector" else 0.3
        wall["contour"] = [[-0.02, radius], [0.0, radius + 5e-4], [0.02, radius + 1.5e-3]]


def shaken(rng: Rng, case: dict[str, Any]) -> None:
    """An imbalance, on a shaft whose support may fuse, with dampers."""
    phase = float(rng.uniform(-3.0, 3.0))
    size = 5e-4 if "drive" in case["march"] else 0.06  # no tip may start beyond the wall
    load = {"type": "imbalance", "unbalance": size, "phase": phase, "ramp": 0.0}
    case["excitation"] = [load]
    shaft = case["shaft"] = {"stiffness": 2e7, "damping": float(rng.choice([0.0, 2e3]))}
    if shaft["damping"] and case["rotation"]["effects"] == "full" and rng.integers(2):
        shaft["damping_frame"] = "static"
    if rng.integers(2):
        shaft |= {"fuse_force": 3e5, "fused_stiffness": 5e6}


Feature = Callable[[Rng, dict[str, Any]], None]

BEAMS: tuple[Feature, ...] = (shaken, struck_wall, lost, mistuned)
"""Features of beams."""

SOLIDS: tuple[Feature, ...] = (ordered, struck_wall, sloped, lost, mistuned)
"""Features of 3D blades."""


def beam_case(rng: Rng) -> dict[str, Any]:
    """A bladed disk of beams in a flexible casing."""
    case: dict[str, Any] = {
        "bladed_disk": {
            **{"blades": 7, "elements_per_blade": 3, "tip_radius": 0.5, "disk_radius": 0.1},
        },
        "rotation": {"effects": str(rng.choice(["none", "full"]))},
        "reduction": {"fixed_interface_modes": 30},
        "casing": {
            **{"elements": 42, "clearance": 2.2e-4, "support": 8e6},
            "clearance_lobes": [{"lobes": 3, "amplitude": 1e-4, "phase": 0.3}],
        },
        "contact": {"friction": 0.1, "sliding": str(rng.choice(["permanent", "signed"]))},
        "damping": {"ratio": 0.005},
        "march": {"time_step": 5e-7, "duration": 6e-3, "record_step": 1e-4},
    }
    speeds(rng, case, free=True)
    return with_features(rng, case, BEAMS)


def solid_case(rng: Rng, folder: Path) -> dict[str, Any]:
    """3D blades that lean and are twisted, or a wheel of such sectors, see `write_parts`."""
    sector, ring = rng.integers(3) == 0, bool(rng.integers(2))
    kind, copies = ("sector", 12) if sector else ("blade", 5)
    casing: dict[str, Any] = {"type": "rigid", "clearance": 2.1e-4}
    if ring:
        section = {"width": 0.05, "thickness": 0.006}
        casing = {"clearance": 2.1e-4, "elements": 4 * copies, "support": 2e7, "wall": section}
    lobes = {"lobes": 2, "amplitude": 2e-4, "phase": float(rng.uniform(-3.0, 3.0))}
    case: dict[str, Any] = {
        "bladed_disk": {
            "superelement": {"file": str(folder / f"{kind}.npz"), "kind": kind, "copies": copies}
        },
        "reduction": {"free_interface_modes": 4 if sector else 8},
        "rotation": {"effects": str(rng.choice(["centrifugal", "full", "full"]))},
        "casing": casing | {"clearance_lobes": [lobes]},
        "contact": {"friction": 0.1, "sliding": str(rng.choice(["permanent", "full"]))},
        "damping": {"ratio": 0.01},
        "march": {"time_step": 5e-7, "duration": 5e-3, "record_step": 2e-5},
    }
    speeds(rng, case, free=False)
    if "speed" not in case["march"]:
        case["rotation"]["effects"] = "full"
    case = with_features(rng, case, SOLIDS)
    if sector:  # blades of sectors need blade_stiffness
        case.pop("blade_loss", None)
        case["bladed_disk"].pop("mistuning", None)
    return case


def with_features(rng: Rng, case: dict[str, Any], features: tuple[Feature, ...]) -> dict[str, Any]:
    """Return a case with all features drawn."""
    for feature in features:
        feature(rng, case)
    return case


def leaning_blade(boxes: tuple[int, int, int] = (4, 1, 1)) -> Any:
    """A blade of 100 x 30 x 4 mm that leans and is twisted and staggered."""

    def shape(place: Array) -> Array:
        r, y, z = (place * [0.1, 0.03, 0.004] + [0.2, -0.015, -0.002]).T
        s = (r - 0.2) / 0.1
        stagger = 0.3 + 0.5 * s
        c, sn = np.cos(stagger), np.sin(stagger)
        return np.stack([r, c * z - sn * y + 0.005 * s**2, c * y + sn * z], axis=1)

    return grid_mesh(
        *(boxes, shape, "hexahedron20"),
        root=lambda place: place[:, 0] == 0.0,
        tip=lambda place: place[:, 0] == 1.0,
    )


def write_parts(folder: Path) -> None:
    """Write a blade and a sector without any symmetry, and their images."""
    parts = {
        "blade": bw.mesh3d(leaning_blade(), **STEEL, contacts=3, coriolis=True),
        "sector": bw.mesh3d(
            bladed_sector("hexahedron20"), **STEEL, **TIE, contacts=2, coriolis=True
        ),
    }
    for name, part in parts.items():
        bw.write_superelement(folder / f"{name}.npz", part)
        for kind, axis in (("mirror", 1), ("flip", 2)):
            bw.write_superelement(folder / f"{name}-{kind}.npz", reflected(part, axis))


def reflected(part: Superelement, axis: int) -> Superelement:
    """Return a superelement in which one axis, y or z, is reversed."""
    sign = np.ones(part.size)
    for dofs in _columns(part):
        sign[dofs[axis][dofs[axis] != FIXED]] = -1.0
    turns = -1.0 if axis == 1 else 1.0  # of what is odd in the speed
    matrices: dict[str, Any] = {}
    for key, matrix in part.given(part.FORMS).items():
        scale = turns if key == "gyroscopic" else 1.0
        matrices[key] = scale * (sp.diags_array(sign) @ matrix @ sp.diags_array(sign))
    loads: dict[str, Any] = {
        key: (turns if key == "euler_load" else 1.0) * sign * load
        for key, load in part.given(part.LOADS).items()
    }
    flipped = np.ones(3)
    flipped[axis] = -1.0
    points: dict[str, Any] = {}
    if part.points is not None:
        rows = sp.diags_array(np.tile(flipped, len(part.points)))
        points["points"] = part.points * flipped
        points["recovery"] = sp.csr_array(rows @ sp.csr_array(part.recovery) @ sp.diags_array(sign))
        points["triangles"] = None if part.triangles is None else part.triangles[:, ::-1]
    if part.stress_recovery is not None:
        shears = np.array([1, 1, 1, -1, -1, 1] if axis == 1 else [1, 1, 1, 1, -1, -1])
        rows = sp.diags_array(np.tile(shears, part.stress_recovery.shape[0] // 6).astype(float))
        points["stress_recovery"] = sp.csr_array(
            rows @ sp.csr_array(part.stress_recovery) @ sp.diags_array(sign)
        )
    faces: dict[str, Any] = {}
    if part.left_dofs is not None and axis == 1:
        faces = {"left_dofs": part.right_dofs, "right_dofs": part.left_dofs}
    return replace(
        part,
        **matrices,
        **loads,
        **points,
        **faces,
        contact_position=part.contact_position * flipped,
    )


def _columns(part: Superelement) -> list[Any]:
    """Numbers of the coordinates along x, y and z, three arrays for each node."""
    size = np.arange(part.size)
    assert part.size % 3 == 0
    return [[size[0::3], size[1::3], size[2::3]]]


ODD = {
    "mirror": {"friction_impulse": -1, "contact_displacement": [1, -1, 1]},
    "flip": {"axial_impulse": -1, "contact_displacement": [1, 1, -1]},
    "turn": dict[str, Any](),
}
"""Factors on the values of images. Forces have those of displacements."""

BY_NODE = ("contact_impulse", "friction_impulse", "axial_impulse", "gap", "contact_displacement")
SUMS = ("energy", "external_work", "normal_work", "friction_work", "damping_work", "wear_volume")


def marched(case: dict[str, Any]) -> Any:
    """Return the result of a case."""
    result, _ = march_in_memory(prepare(bw.case_from(case)))
    return result.load()


def difference(result: Any, other: Any, image: Image) -> dict[str, float]:
    """Return the largest differences of a result from that of an image, of the largest value."""
    nodes = next(result[name].shape[1] for name in BY_NODE if name in result) // image.blades
    place = (nodes * image.blade[:, None] + np.arange(nodes)).ravel()
    pairs = {
        name: (
            result[name].values,
            other[name].values[:, place] * np.array(ODD[image.kind].get(name, 1)),
        )
        for name in BY_NODE
        if name in result and result[name].ndim > 1
    }
    pairs |= {name: (result[name].values, other[name].values) for name in SUMS if name in result}
    sign = -1.0 if image.kind == "mirror" else 1.0
    if "rotation_speed" in result:
        pairs["speed"] = result["rotation_speed"].values, sign * other["rotation_speed"].values
    return {
        name: float(np.abs(one - two).max() / max(np.abs(one).max(), 1e-300))
        for name, (one, two) in pairs.items()
    }
