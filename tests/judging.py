"""The referee's verdict on records of the package, by way of the exchange formats."""

from gcm_learn.planners import plan_to_json
from gcm_learn.referee import examine
from gcm_learn.situation import situation_to_json


def judge(situation, plan):
    """Complaints of the referee about a plan, as lines; none means that every promise is kept."""
    return judged(situation, plan)[0]


def judged(situation, plan):
    """Complaints, as lines, and the clearance that the referee finds."""
    verdict = examine(situation_to_json(situation), plan_to_json(plan, situation))
    return [str(complaint) for complaint in verdict.complaints], verdict.clearance
