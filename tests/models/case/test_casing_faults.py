"""What the [casing] table refuses: the key is named, in one line."""

import pytest
from faults import fault

from bladewhirl.models.case.case import case_from

LOBES = {"lobes": 2, "amplitude": 1e-4}
SHRINKING = {"amount": 1e-4, "time_constant": 1.0}
TURN = [{"angle": 0, "thickness": 0.01}, {"angle": "1 turn", "thickness": 0.02}]


@pytest.mark.parametrize(
    ("casing", "line"),
    [
        ({"elements": 7, "clearance_lobes": [LOBES]}, "at most 1 lobes"),
        (
            {"clearance_lobes": [{"lobes": 0, "amplitude": 1e-4}]},
            "casing.clearance_lobes[0].lobes = 0: expected a whole number",
        ),
        ({"clearance_lobes": 3}, "casing.clearance_lobes = 3: expected rows of { lobes = 2"),
        (
            {"clearance_lobes": [LOBES | {"phase": "1 mm"}]},
            'casing.clearance_lobes[0].phase = "1 mm": expected a finite number in rad',
        ),
        ({"thickness_lobes": [{"lobes": 2, "amplitude": 0.011}]}, "casing.thickness_lobes = "),
        ({"thickness_stations": TURN}, "one station at each angle"),
        ({"stiffened_arcs": [{"start": 1.0, "end": 1.0}]}, "casing.stiffened_arcs[0].end = 1.0"),
        (
            {"stiffened_arcs": [{"start": 1.0, "end": 2.0}, {"start": 1.5, "end": 3.0}]},
            "arcs that do not overlap",
        ),
        (
            {"springs": [{"angle": 0.0}]},
            "more than 0 for this key or for tangential, radial_damping",
        ),
        ({"struts": [{"angle": 0.0}]}, "casing.struts[0].length"),
        (
            {"struts": [{"angle": 0.0, "length": 1.0, "inclination": "90 deg"}]},
            "casing.struts[0].inclination",
        ),
        ({"closure": {}}, "closure.amount = 0.0: expected a closure other than zero, or a table"),
        ({"closure": {"amount": 1e-4}}, "closure.time_constant: expected a time"),
        ({"closure": SHRINKING | {"table": [[0, 1e-4]]}}, "either a table or an"),
        ({"closure": {"table": [[1.0, 1e-4], [0.5, 1e-4]]}}, ": expected rows in ascending"),
        (
            {"closure": SHRINKING | {"amount": -2e-3}},
            "widens the gap by less than casing.clear",
        ),
        ({"clearance": 0.0, "closure": SHRINKING}, "casing.clearance = 0.0: expected more than 0"),
        (
            {"elements": 12, "closure": SHRINKING | {"lobes": [{"lobes": 9, "amplitude": 1e-5}]}},
            ": expected at most 3 lobes",
        ),
    ],
)
def test_faults_name_the_key(casing: dict[str, object], line: str) -> None:
    assert line in fault(case_from, {"casing": casing})
