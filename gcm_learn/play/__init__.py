"""A page in the browser on which a planar situation is changed by hand, and answered at once."""

from gcm_learn.play.answers import ANSWERS, example as example, respond as respond
from gcm_learn.play.questions import shown as shown
from gcm_learn.play.server import Newest as Newest, Server as Server

KINDS = tuple(ANSWERS)
"""Kinds of questions that are answered."""
