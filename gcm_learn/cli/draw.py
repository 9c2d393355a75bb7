"""``gcm-learn draw``: situations of a random family."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tyro.conf import Positional, arg

from gcm_learn.cli.failures import CommandFailure
from gcm_learn.cli.files import output


@dataclass(frozen=True)
class Draw:
    """Draw situations of a random family; write one a line, in the format that `solve` reads.

    Number k of a seed is the same whatever the count.
    """

    family: Annotated[Positional[str], arg(metavar="FAMILY")]
    """its name, a preset's name, or a .json file with its ranges, as `gcm-learn families NAME`
    prints them; an unknown name lists all of them"""

    count: int = 1
    """how many"""

    seed: int = 0
    """root of all that is random"""

    arm: Annotated[
        str, arg(metavar="FILE", help_behavior_hint="(default: the family's, e.g. a Panda)")
    ] = ""
    """arm of families for chains: a file of `gcm-learn arm`, or a name of `gcm-learn arms`"""

    out: Annotated[
        Path | None, arg(metavar="FILE", help_behavior_hint="(default: standard output)")
    ] = None
    """where the situations go; the file appears whole or not at all"""

    def run(self) -> int:
        """Draw and write."""
        from gcm_learn import families
        from gcm_learn.situation import situation_to_json

        for name, value, least in (("--count", self.count, 1), ("--seed", self.seed, 0)):
            if value < least:
                raise CommandFailure(f"{name} {value}: must be at least {least}")
        named = not self.family.lower().endswith(".json")
        family = self.family if named else families.read_family(self.family)
        with output(self.out) as stream:
            for k in range(self.count):
                drawn = families.draw(family, self.seed, k, arm=self.arm)
                stream.write(json.dumps(situation_to_json(drawn)) + "\n")
        return 0
