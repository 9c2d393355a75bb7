"""``gcm-learn generate``: a dataset from its specification."""

from __future__ import annotations

import re
import sys
from dataclasses import dataclass
from datetime import timedelta
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from tyro.conf import Positional, arg

from gcm_learn.cli.failures import CommandFailure, dataset_package, why
from gcm_learn.cli.files import refuse_missing
from gcm_learn.cli.options import AllCores, Cluster, given
from gcm_learn.cli.progress import Progress

if TYPE_CHECKING:
    from gcm_learn.dataset import Estimate, Manifest


WORTH_AN_ESTIMATE = 200  # missing records from which on it begins with an estimate
FEW_KEPT = 0.3
"""Share of drawn situations that are kept, below which a hint is due."""


@dataclass(frozen=True)
class Generate:
    """Make the shards of a dataset that are not there yet.

    Stopped by Ctrl-C or otherwise, it goes on from there when it is called again; the last seconds
    are lost. It begins with an estimate of its time and of the dataset's size.
    """

    spec: Annotated[Positional[Path], arg(metavar="SPEC")]
    """a .toml or .json file; `gcm-learn demo --copy train.toml` copies one, and `gcm-learn
    demo --copy README.md --out fields.md` what explains its fields"""

    out: Annotated[str, arg(metavar="DIR")]
    """folder for the dataset, or a URL that fsspec understands, such as s3://BUCKET/FOLDER"""

    workers: AllCores = None
    """processes on this machine"""

    verify: bool = False
    """then check everything: hashes, and every plan anew"""

    cluster: Cluster = None
    """a Dask scheduler whose workers are used, tcp://HOST:PORT"""

    shards: Annotated[str | None, given("I/N", "all")] = None
    """make only part I of N, counted from 0, for job arrays"""

    dry_run: bool = False
    """only estimate the time and the size, and make nothing"""

    def run(self) -> int:
        """Make the missing records and print a summary; with --dry-run print only an estimate."""
        refuse_missing(self.spec)
        part = _part(self.shards)
        dataset = dataset_package()
        spec = dataset.read_spec(self.spec)
        total = sum(len(spec.indices(k)) for k in range(part[0], spec.shards, part[1]))
        least = 1 if self.dry_run else WORTH_AN_ESTIMATE
        told = None
        if self.dry_run or self.cluster is None:  # other machines take another time
            told = dataset.estimate(spec, self.out, self.workers, part=part, least=least)
        if self.dry_run:
            print(_foreseen(self.out, told))
            return 0
        if told is not None:
            print(f"gcm-learn: {_foreseen(self.out, told)}", file=sys.stderr)
        try:
            with Progress(total, "records") as progress:
                manifest = dataset.generate(
                    spec, self.out, self.workers, part=part, cluster=self.cluster,
                    progress=progress.advance,
                )  # fmt: skip
        except OSError as error:
            raise CommandFailure(f"--out {self.out}: {why(error)}") from None
        print(_sentence(self.out, manifest))
        hint = _hint(manifest)
        if hint:
            print(hint, file=sys.stderr)
        return self._check(manifest["records"]) if self.verify else 0

    def _check(self, total: int) -> int:
        """Verify the dataset and print its faults; return 1 if there are faults, else 0."""
        from gcm_learn.dataset import verify_dataset

        with Progress(total, "records verified") as progress:
            report = verify_dataset(self.out, self.workers, progress=progress.advance)
        for fault in report.quoted:
            print(fault, file=sys.stderr)
        print(
            f"{self.out}: verified {report.records} records, {report.plans} catches, "
            f"{report.remade} items made again, {report.faults} faults"
        )
        return 1 if report.faults else 0


def _foreseen(out: str, told: Estimate | None) -> str:
    """Return an estimate in one line."""
    if told is None:
        return f"{out}: nothing to make"
    time, size = timedelta(seconds=max(round(told.seconds), 1)), f"{told.bytes / 1e6:.3g} MB"
    text = f"{out}: {told.records} records to make, about {time} (h:m:s) and {size}"
    return f"{text}, estimated from {told.asked} of them"


def _part(text: str | None) -> tuple[int, int]:
    """The part "i/n" that is to be made."""
    if text is None:
        return 0, 1
    match = re.fullmatch(r"(\d+)/(\d+)", text)
    if match is None or not int(match[1]) < int(match[2]):
        raise CommandFailure(f"--shards {text}: must be I/N with 0 <= I < N, e.g. 0/4")
    return int(match[1]), int(match[2])


def _hint(manifest: Manifest) -> str | None:
    """Return a sentence about a low share of drawn situations that were kept, or None."""
    kept = manifest["records"] / max(manifest["drawn"], 1)
    if kept >= FEW_KEPT or not manifest["records"]:
        return None
    why_not = max(manifest["rejected"], key=manifest["rejected"].__getitem__, default="none")
    return (
        f"gcm-learn: {kept:.1%} of {manifest['drawn']:,} drawn situations were kept, which is what "
        f"takes the time (most were rejected as {why_not!r}; without `strata` in the "
        "specification fewer are)"
    )


def _sentence(out: str, manifest: Manifest) -> str:
    """Return a summary of a dataset in one line."""
    strata = ", ".join(f"{share:.0%} {name}" for name, share in manifest["shares"].items())
    size = manifest["bytes"] / 1e6
    state = "" if manifest["complete"] else f" so far ({len(manifest['shards'])} shards)"
    failed = f", {manifest['failed']} failed" if manifest["failed"] else ""
    text = f"{out}: {manifest['records']} records{state}, {size:.1f} MB, {strata}{failed}"
    return f"{text}, hash {manifest['hash'][:16]}"
