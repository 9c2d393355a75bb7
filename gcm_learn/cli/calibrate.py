"""``gcm-learn calibrate``: a margin that covers the errors of a predictor on recorded tracks."""

from __future__ import annotations

import dataclasses
import json
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from tyro.conf import Positional, arg

from gcm_learn.cli.files import output, refuse_missing, refuse_same
from gcm_learn.cli.options import TIME, Count, Number, given, ranged

if TYPE_CHECKING:
    from gcm_learn.evaluation import Calibration

SHARE = ranged(float, "SHARE", 0, 0.999, above=True)
ASKED = ("predictor", "cover", "horizon", "looks", "seed")


@dataclass(frozen=True)
class Calibrate:
    """Find a margin for obstacles within which recorded tracks stay, by split conformal prediction.

    Half of the tracks make the margin, the others tell whether it holds.
    """

    tracks: Annotated[Positional[Path], arg(metavar="TRACKS")]
    """CSV with columns track, t, x, y and maybe z, or the table-tennis states of convert"""

    predictor: Annotated[str, arg(metavar="NAME")]
    """rest, velocity or acceleration (each constant), gravity, or ball (of table tennis)"""

    cover: Annotated[float, SHARE] = 0.95
    """share of tracks that are to stay within the margin"""

    horizon: Annotated[float, TIME] = 0.5
    """time over which they are to stay"""

    looks: Count = 10
    """samples that the predictor sees; of measured states only the state"""

    seed: Number = 0
    """of the halves, and of the instants from which tracks are foretold"""

    out: Annotated[Path | None, given("FILE", "lines for people only")] = None
    """where the margin goes as JSON; - is standard output, in place of lines for people"""

    def run(self) -> int:
        """Calibrate a margin on the tracks, write it, and print its size and coverage."""
        refuse_missing(self.tracks)
        refuse_same({"TRACKS": self.tracks, "--out": self.out})
        from gcm_learn.evaluation import calibrate
        from gcm_learn.outside import read_tracks, windows

        tracks = read_tracks(self.tracks, self.horizon)
        found = windows(tracks, self.horizon, self.looks, self.seed)
        done = calibrate(found, self.predictor, self.cover, self.seed)
        short = len(tracks) - len(found)
        if self.out is not None:
            asked = {name: getattr(self, name) for name in ASKED} | {"too_short": short}
            told = asked | dataclasses.asdict(done) | {"covered": done.covered}
            with output(self.out) as stream:
                stream.write(json.dumps(told) + "\n")
        if str(self.out) != "-":
            print(self._told(done, short))
        return 0

    def _told(self, done: Calibration, short: int) -> str:
        """Return a text on the margin, the tracks behind it and its held-out coverage."""
        (now, rate), horizon = dataclasses.astuple(done.margin), self.horizon
        share, low, high = (100.0 * value for value in done.covered)
        return f"""\
margin: now {now:.4g}, rate {rate:.4g}, so {now + rate * horizon:.4g} after {horizon:g} s
from: {done.chosen:,} tracks chose the shape, {done.calibrated:,} made the size
held out: {done.within:,} of {done.held_out:,} tracks stay within, {share:.1f} % ({low:.1f} to \
{high:.1f}) of {100.0 * self.cover:g} % asked
too short: {short:,} tracks"""
