"""Situations of arms in space."""

from __future__ import annotations

from pathlib import Path

EXAMPLES = Path(__file__).with_name("spatial.jsonl")
"""Fifty situations with two arms, six of them with limits of acceleration."""
