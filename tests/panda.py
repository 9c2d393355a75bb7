"""A situation with a Panda arm."""

from pathlib import Path

PANDA = Path(__file__).with_name("panda.jsonl")
"""A Panda arm, a ball that bounces and has an approach, a tray that moves, and a floor."""
