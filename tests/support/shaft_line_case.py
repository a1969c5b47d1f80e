"""A shaft line that is marched in tests."""

from bladewhirl.models.case.case import Case, case_from


def line_case(*, gravity: bool = True, **march: object) -> Case:
    """A line on a support, with an unbalance, under gravity."""
    line = {
        "segments": [{"length": 0.6, "outer_diameter": 0.04, "elements": 4}],
        "disks": [{"position": 0.3, "mass": 8.0, "polar_inertia": 0.06, "diametral_inertia": 0.03}],
        "bearings": [
            {
                "name": "front",
                "position": 0.0,
                "stiffness": 2e6,
                "damping": 400.0,
                "support": {"mass": 3.0, "stiffness": 8e6, "damping": 100.0},
            },
            {"position": 0.6, "stiffness": [[3e6, 0.0], [0.0, 2e6]], "damping": 500.0},
        ],
        "unbalance": [{"position": 0.3, "unbalance": 2e-3}],
        "modes": 6,
    }
    given = {"speed": "1800 rpm", "time_step": 1e-5, "duration": 0.05, "record_step": 1e-4}
    tables = {"shaft_line": line, "march": given | march}
    return case_from(tables | ({} if "drive" in march and not gravity else {"gravity": {}}))
