"""A referee of solutions: it reads the exchange formats alone, and nothing else of the package.

>>> from gcm_learn.referee import judge
>>> judge(situation, solution)  # doctest: +SKIP
[]

Its geometry is its own, in plain numpy.  ``python -m gcm_learn.referee`` judges files.
"""

from gcm_learn.referee.contact import Motion, nearest_obstacle, overlap
from gcm_learn.referee.judging import Verdict, examine, judge, judge_files, models_of
from gcm_learn.referee.kinds import Arm, arm_of
from gcm_learn.referee.motions import Body, bodies_of
from gcm_learn.referee.tolerances import Complaint, Unreadable

__all__ = [
    "Arm",
    "Body",
    "Complaint",
    "Motion",
    "Unreadable",
    "Verdict",
    "arm_of",
    "bodies_of",
    "examine",
    "judge",
    "judge_files",
    "models_of",
    "nearest_obstacle",
    "overlap",
]
