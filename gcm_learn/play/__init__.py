"""A page in the browser on which a planar situation is changed by hand, and answered at once."""

from gcm_learn.play.answers import ANSWERS, example, respond
from gcm_learn.play.questions import shown
from gcm_learn.play.server import Newest, Server

KINDS = tuple(ANSWERS)
"""Kinds of questions that are answered."""

__all__ = ["KINDS", "Newest", "Server", "example", "respond", "shown"]
