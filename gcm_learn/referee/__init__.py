"""Referee of solutions, which reads the exchange formats alone and no other code of the package.

>>> from gcm_learn.referee import judge
>>> judge(situation, solution)  # doctest: +SKIP
[]

Its geometry is its own, in plain numpy.  ``python -m gcm_learn.referee`` judges files.
"""

from gcm_learn.referee.contact import (
    Motion as Motion,
    nearest_obstacle as nearest_obstacle,
    overlap as overlap,
)
from gcm_learn.referee.judging import (
    Verdict as Verdict,
    examine as examine,
    judge as judge,
    judge_files as judge_files,
    models_of as models_of,
)
from gcm_learn.referee.kinds import Arm as Arm, arm_of as arm_of
from gcm_learn.referee.motions import Body as Body, bodies_of as bodies_of
from gcm_learn.referee.surface_files import (
    MESHES as MESHES,
    inlined as inlined,
    read_mesh as read_mesh,
    read_points as read_points,
    read_surface as read_surface,
)
from gcm_learn.referee.tolerances import Complaint as Complaint, Unreadable as Unreadable
