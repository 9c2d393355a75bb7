"""``gcm-learn families``: what can be drawn."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Annotated

from tyro.conf import Positional, arg


@dataclass(frozen=True)
class Families:
    """List random families and presets, one a line; or show the ranges of a family as JSON."""

    family: Annotated[
        Positional[str | None], arg(metavar="FAMILY", help_behavior_hint="(default: list all)")
    ] = None
    """whose ranges to show"""

    def run(self) -> int:
        """Print names and summaries, or one configuration."""
        from gcm_learn.families import PRESETS, family_names, family_to_dict, get_family

        if self.family is not None:
            values = family_to_dict(get_family(self.family)).items()
            lines = (f"  {json.dumps(name)}: {json.dumps(value)}" for name, value in values)
            print("{\n" + ",\n".join(lines) + "\n}")  # a range a line
            return 0
        summaries = {name: get_family(name).summary for name in family_names()}
        summaries |= {name: preset.summary for name, preset in PRESETS.items()}
        width = max(map(len, summaries))
        for name, summary in summaries.items():
            print(f"{name:<{width}}  {summary}")
        return 0
