"""``gcm-learn draw``: situations of a random family."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated

from tyro.conf import Positional

from gcm_learn.cli.failures import CommandFailure
from gcm_learn.cli.files import output
from gcm_learn.cli.options import Count, Number, Output, given


@dataclass(frozen=True)
class Draw:
    """Draw situations of a random family; write one a line, in the format that `solve` reads.

    Number k of a seed is the same whatever the count.
    """

    family: Annotated[Positional[str], given("FAMILY", "none, for --list")] = ""
    """its name, a preset's name, or a .json file with its ranges, as `gcm-learn draw NAME --list`
    prints them; an unknown name lists all of them"""

    list: bool = False
    """list families and presets, or the ranges of FAMILY as JSON, and draw nothing"""

    count: Count = 1
    """how many"""

    seed: Number = 0
    """root of all that is random"""

    arm: Annotated[str, given("FILE", "the family's, e.g. a Panda")] = ""
    """arm of families for chains: a file of `gcm-learn arm`, or a name that it lists"""

    out: Output = None
    """where the situations go"""

    def run(self) -> int:
        """Draw or list, and write."""
        if not self.list and not self.family:
            raise CommandFailure("FAMILY is missing; gcm-learn draw --list lists them")
        with output(self.out) as stream:
            for line in _listed(self.family) if self.list else self._drawn():
                stream.write(f"{line}\n")
        return 0

    def _drawn(self) -> Iterator[str]:
        from gcm_learn import families
        from gcm_learn.situation import situation_to_json

        named = not self.family.lower().endswith(".json")
        family = self.family if named else families.read_family(self.family)
        for k in range(self.count):
            yield json.dumps(situation_to_json(families.draw(family, self.seed, k, arm=self.arm)))


def _listed(name: str) -> Iterator[str]:
    """Yield lines with all families, presets and summaries, or the ranges of the named family."""
    from gcm_learn.families import PRESETS, family_names, family_to_dict, get_family

    if name:
        values = family_to_dict(get_family(name)).items()
        ranges = (f"  {json.dumps(key)}: {json.dumps(value)}" for key, value in values)
        yield "{\n" + ",\n".join(ranges) + "\n}"
        return
    summaries = {known: get_family(known).summary for known in family_names()}
    summaries |= {known: preset.summary for known, preset in PRESETS.items()}
    width = max(map(len, summaries))
    yield from (f"{known:<{width}}  {summary}" for known, summary in summaries.items())
