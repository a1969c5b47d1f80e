"""What the [casing] table refuses: the key is named, in one line."""

import pytest
from faults import fault

from bladewhirl.models.case.check import case_from

LOBES = {"lobes": 2, "amplitude": 1e-4}
TURN = [{"angle": 0, "thickness": 0.01}, {"angle": "1 turn", "thickness": 0.02}]


@pytest.mark.parametrize(
    ("casing", "line"),
    [
        (
            {"clearance": 5e-4, "clearance_lobes": [{"lobes": 2, "amplitude": 6e-4}]},
            "casing.clearance_lobes = ",
        ),
        ({"elements": 7, "clearance_lobes": [LOBES]}, "at most 1 lobes"),
        (
            {"clearance_lobes": [{"lobes": 0, "amplitude": 1e-4}]},
            "casing.clearance_lobes[0].lobes = 0: expected a whole number",
        ),
        (
            {"clearance_lobes": [LOBES | {"phse": 0.1}]},
            "casing.clearance_lobes[0].phse = 0.1: expected a known key; the nearest is"
            " casing.clearance_lobes[0].phase",
        ),
        ({"clearance_lobes": [{"lobes": 2}]}, "casing.clearance_lobes[0].amplitude"),
        ({"clearance_lobes": 3}, "casing.clearance_lobes = 3: expected rows of { lobes = 2"),
        ({"clearance_lobes": [3]}, "casing.clearance_lobes[0] = 3: expected a table"),
        (
            {"clearance_lobes": [LOBES | {"phase": "1 mm"}]},
            'casing.clearance_lobes[0].phase = "1 mm": expected a finite number in rad',
        ),
        ({"thickness_lobes": [{"lobes": 2, "amplitude": 0.011}]}, "casing.thickness_lobes = "),
        ({"thickness_lobes": [{"lobes": 11, "amplitude": 0.001}]}, "at most 10 lobes"),
        ({"thickness_stations": TURN}, "one station at each angle"),
        ({"stiffened_arcs": [{"start": 1.0, "end": 1.0}]}, "casing.stiffened_arcs[0].end = 1.0"),
        ({"stiffened_arcs": [{"start": 1.0, "end": 8.0}]}, "at most a turn further on"),
        (
            {"stiffened_arcs": [{"start": 1.0, "end": 2.0}, {"start": 1.5, "end": 3.0}]},
            "arcs that do not overlap",
        ),
        (
            {"stiffened_arcs": [{"start": 1.0, "end": 2.0}, {"start": 5.0, "end": 8.0}]},
            "arcs that do not overlap",
        ),
        ({"springs": [{"angle": 0.0}]}, "more than 0 here or in tangential, radial_damping"),
        ({"springs": [{"angle": 0.0, "radial": -1.0}]}, "casing.springs[0].radial = -1.0"),
        ({"struts": [{"angle": 0.0}]}, "casing.struts[0].length"),
        ({"struts": [{"angle": 0.0, "length": 0.0}]}, "casing.struts[0].length = 0.0"),
        (
            {"struts": [{"angle": 0.0, "length": 1.0, "inclination": "90 deg"}]},
            "casing.struts[0].inclination",
        ),
        ({"struts": [{"angle": 0.0, "length": 1.0, "ends": "free"}]}, '"pinned" or "built-in"'),
    ],
)
def test_faults_name_the_key(casing: dict[str, object], line: str) -> None:
    assert line in fault(case_from, {"casing": casing})
