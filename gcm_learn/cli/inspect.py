"""``gcm-learn inspect``: contents of a dataset, a model or an arm file, in numbers or pictures."""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from tyro.conf import Positional, arg

from gcm_learn.cli.failures import CommandFailure, dataset_package
from gcm_learn.cli.files import made_folder, refuse_missing
from gcm_learn.cli.options import Count, given


@dataclass(frozen=True)
class Inspect:
    """Print what a dataset, memory, encoder, policy, cover or arm file holds.

    Of a dataset: strata, catches, splits and rates, also while it is made.
    """

    path: Annotated[Positional[str], arg(metavar="PATH")]
    """a folder, or a .json file of an arm"""

    verify: bool = False
    """compare the bytes of all shards of a dataset with the manifest's checksums, too"""

    pictures: Annotated[Path | None, given("DIR", "no pictures")] = None
    """folder for a page: a dataset's situations with their maps, or a planar memory's catches as
    points"""

    each: Count = 8
    """of --pictures: situations of every stratum; of a memory a hundred times as many catches"""

    def run(self) -> int:
        """Print the contents of the path, then any faults of shards; return 1 if there are any."""
        refuse_missing(self.path)
        place = Path(self.path)
        told = next((told for there, told in _MODELS if there(place)), None)
        if told is not None and self.verify:
            raise CommandFailure(f"--verify: {self.path} is no dataset")
        code = self._survey() if told is None else 0
        if told is not None:
            print("\n".join(told(place)))
        if self.pictures is not None:
            page = self._show(place, self.pictures)
            print(f"Open {page.resolve().as_uri()} in a browser.")
        return code

    def _survey(self) -> int:
        """Print a dataset's contents, then its faults; return 1 if there are faults, else 0."""
        dataset = dataset_package()
        print("\n".join(report(dataset.survey(self.path))))
        faults = list(dataset.faults_of(dataset.Folder(self.path), hashes=self.verify))
        for fault in faults:
            print(fault, file=sys.stderr)
        if self.verify and not faults:
            print("the bytes of all shards agree with the manifest")
        return 1 if faults else 0

    def _show(self, place: Path, out: Path) -> Path:
        """Write the page of a dataset or a memory."""
        if _is_memory(place):
            from gcm_learn.arms import PLANAR
            from gcm_learn.recall import Memory

            memory = Memory.load(place)
            if memory.kind != PLANAR:
                raise CommandFailure(f"{place}: pages show memories of planar arms only")
            from gcm_learn.plots import write_memory_page

            folder = made_folder(out, option="--pictures")
            return write_memory_page(memory, folder, count=100 * self.each)
        records = dataset_package().open(self.path)
        if len(records) == 0:
            raise CommandFailure(f"{self.path}: has no records")
        from gcm_learn.plots import write_dataset_page

        return write_dataset_page(records, made_folder(out, option="--pictures"), self.each)


def _is_memory(place: Path) -> bool:
    from gcm_learn.recall import is_memory

    return is_memory(place)


def _memory(place: Path) -> Iterator[str]:
    from gcm_learn.recall import Memory

    memory = Memory.load(place)
    index = memory.index
    yield f"{place}: a memory of {len(memory)} catches of {memory.kind.plural}"
    yield f"  index {index.name}, {index.dim} numbers, key {index.key}"
    for name, words in (("families", memory.families), ("strata", memory.strata)):
        counts = Counter(words).most_common()
        yield f"  {name}: " + ", ".join(f"{word or 'unknown'} {count}" for word, count in counts)


def _encoder(place: Path) -> Iterator[str]:
    from gcm_learn.recall import load_encoder

    encoder = load_encoder(place)
    yield f"{place}: an encoder for {encoder.kind.plural}, key {encoder.key}"
    yield f"  {encoder.dim} numbers an embedding, memories by their {encoder.config.memory}"


def _policy(place: Path) -> Iterator[str]:
    from gcm_learn.policies import Actor

    actor = Actor.load(place)
    widths = [actor.layers[0][0].shape[1], *(len(bias) for _, bias in actor.layers)]
    yield f"{place}: a policy for {actor.settings.kind.plural}, which commands a {actor.head}"
    yield f"  layers of {', '.join(map(str, widths))} numbers, {actor.activation}"
    yield f"  steps of {actor.settings.dt:g} s, {actor.settings.slots} obstacles observed"


def _cover(place: Path) -> Iterator[str]:
    from gcm_learn.cli.cover import summary
    from gcm_learn.cover import load_cover

    yield summary(place, load_cover(place))


def _arm(place: Path) -> Iterator[str]:
    from gcm_learn.cli.arm import counts
    from gcm_learn.situation import read_arm

    model = read_arm(place)
    yield f"{place}: {model.name}, {counts(model)}; {model.source or 'no source'}"
    for k, joint in enumerate(model.joints, 1):
        low, high = joint.range
        told = f"{joint.type}, {low:g} to {high:g}, at most {joint.max_speed:g}/s"
        yield f"  joint {k} {joint.name or ''}: {told}"


_MODELS: tuple[tuple[Callable[[Path], bool], Callable[[Path], Iterator[str]]], ...] = (
    (lambda place: place.suffix == ".json", _arm),
    (lambda place: (place / "cover.json").is_file(), _cover),
    (lambda place: (place / "encoder.safetensors").is_file(), _encoder),
    (lambda place: any(place.glob("actor*.npz")), _policy),
    (_is_memory, _memory),
)
"""Kinds of files and folders besides datasets: how each is known, and what is told of it."""


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
    """Return the maps of records and the lattices of planners."""
    from gcm_learn.dataset import kind_of_version

    spec, kind = manifest["spec"], kind_of_version(manifest["schema"])
    if kind.name != "planar":
        size = f"maps by {spec['map']}, {spec['n']} cells along a side"
        return f"{kind.plural}, {'no maps' if spec['map'] == 'none' else size}"
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
