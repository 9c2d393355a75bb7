"""``gcm-learn inspect``: contents of a dataset, in numbers."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Annotated, Any

from tyro.conf import Positional, arg

from gcm_learn.cli.failures import dataset_package


@dataclass(frozen=True)
class Inspect:
    """Print what a dataset holds: strata, catches, splits, rates; also of one under way."""

    folder: Annotated[Positional[str], arg(metavar="DIR")]
    """a dataset"""

    verify: bool = False
    """compare the bytes of all shards with the manifest's checksums, too"""

    def run(self) -> int:
        """Print it, then what is wrong with its shards; the exit code is 1 if anything is."""
        dataset = dataset_package()
        print("\n".join(report(dataset.survey(self.folder))))
        faults = list(dataset.faults_of(dataset.Folder(self.folder), hashes=self.verify))
        for fault in faults:
            print(fault, file=sys.stderr)
        if self.verify and not faults:
            print("the bytes of all shards agree with the manifest")
        return 1 if faults else 0


def report(manifest: Mapping[str, Any]) -> Iterator[str]:
    """Yield the lines of a report on a manifest."""
    spec, records = manifest["spec"], max(manifest["records"], 1)
    state = "complete" if manifest["complete"] else f"{manifest['records']} of {spec['count']}"
    if manifest.get("kept"):
        state += f", and {manifest['kept']} kept of shards that are not finished"
    if not manifest.get("planned", True):
        state += " or more (no manifest tells how many are planned)"
    yield f"{manifest['name']}: {manifest['records']} records, {state}"
    yield f"  seed {spec['seed']}, {_maps(manifest)}"
    yield f"  {manifest['bytes'] / 1e6:.1f} MB, {manifest['bytes_per_record']:.0f} bytes a record"
    yield f"  hash {manifest['hash']}"
    if manifest["code"]:
        yield f"  code {', '.join(f'{c} ({n} shards)' for c, n in manifest['code'].items())}"
    for run in manifest["runs"]:
        hands = run.get("cluster") or f"{run['workers']} workers"
        rate = run["records"] / max(run["seconds"], 1e-9)
        yield f"  made {run['records']} in {run['seconds']:.0f} s by {hands}: {per_second(rate)}"
    yield ""
    yield from _families(manifest)
    yield ""
    for name, count in manifest["caught"].items():
        yield f"{name} catches {count / records:.1%}"
    rejected = ", ".join(f"{n} {kind}" for kind, n in manifest["rejected"].items()) or "none"
    yield f"drawn {manifest['drawn']}, rejected: {rejected}"
    yield "splits: " + ", ".join(f"{name} {n}" for name, n in manifest["splits"].items())
    yield from _checks(manifest)


def per_second(rate: float) -> str:
    """Return a rate with at least two digits that mean something."""
    return f"{rate:.0f}/s" if rate >= 10.0 else f"{rate:.2g}/s"


def _maps(manifest: Mapping[str, Any]) -> str:
    """Return the maps of records and the lattices of planners; only planar arms have them."""
    from gcm_learn.dataset import kind_of_version

    spec, kind = manifest["spec"], kind_of_version(manifest["schema"])
    if kind.name != "planar":
        return f"{kind.plural}, no maps"
    kept = "no maps, lattices" if spec["map"] == "none" else f"map {spec['map']}"
    return f"{kept} {spec['n']} x {spec['n']}, rungs {spec['rungs']}"


def _families(manifest: Mapping[str, Any]) -> Iterator[str]:
    width = max(len(name) for name in (*manifest["families"], "family"))
    yield f"{'family':{width}}  records" + "".join(f"{s:>7}" for s in manifest["shares"])
    rows = {**manifest["families"], "all": manifest["strata"]}
    for name, strata in rows.items():
        total = sum(strata.values())
        shares = (strata.get(s, 0) / max(total, 1) for s in manifest["shares"])
        yield f"{name:{width}} {total:8}" + "".join(f"{share:7.1%}" for share in shares)


def _checks(manifest: Mapping[str, Any]) -> Iterator[str]:
    audit = manifest["audit"]
    if audit["records"]:
        yield (
            f"audit: the oracle labels {audit['disagreement']:.1%} of {audit['records']} otherwise"
            f" ({audit['undecided']} undecided)"
        )
    if "distance" in manifest:
        distance = manifest["distance"]
        yield f"twins left out: {len(manifest['twins']['removed'])}"
        if distance["smallest"] is not None:
            yield (
                f"nearest test and training records: {distance['smallest']:.4f} apart, items "
                f"{distance['pair'][0]} and {distance['pair'][1]} ({distance['comparable']} of "
                f"{distance['test_records']} test records measured)"
            )
    for index, error in manifest["errors"].items():
        yield f"failed: item {index}: {error}"
