"""Stages of cases that differ in some keys only, which use the same models."""

from functools import lru_cache

from bladewhirl.models.case.analysis import Contact, Initial, March
from bladewhirl.models.case.case import Case
from bladewhirl.models.case.excitation import NoExcitation
from bladewhirl.models.stage.build import build_stage
from bladewhirl.models.stage.stage import Stage

KEPT_STAGES = 2
"""Number of stages that a worker caches: neighbouring points of a sweep over speed have the same
stage."""


def stage_at(case: Case) -> Stage:
    """Return the stage of a case; cases that differ only in load and march use the same models.

    With rotation effects the models also depend on the speed; a rotor on a shaft line on the time
    step, too.
    """
    march = {name: getattr(case.march, name) for name in ("speed", "time_step")}
    march = march if case.effects != "none" else {}
    body = case.model_copy(
        update={
            "title": "",
            "march": March().model_copy(update=march),
            "contact": Contact(),
            "excitation": NoExcitation(),
            "initial": Initial(),
        }
    )
    return _body(body).with_case(case)


@lru_cache(maxsize=KEPT_STAGES)
def _body(case: Case) -> Stage:
    return build_stage(case)
