"""The manifest of a dataset: made anew from the shards at each write.

The first one is written before the first shard, with the specification of what is to come.
"""

from __future__ import annotations

import json
import os
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping
from typing import Any

from gcm_learn.dataset.folder import MANIFEST, SHARDS, Folder
from gcm_learn.dataset.record import version_of
from gcm_learn.dataset.shards import (
    MOST_ERRORS,
    DamagedShardError,
    ShardInfo,
    header_of,
    info_of,
    kept,
    shard_name,
)
from gcm_learn.dataset.spec import STRATA, DatasetSpec, spec_from_json, spec_to_json
from gcm_learn.errors import DatasetError
from gcm_learn.storage import content_hash

FORMAT = "gcm-learn/dataset@1"
Manifest = dict[str, Any]


def present(folder: Folder, spec: DatasetSpec, shards: Iterable[int]) -> dict[int, ShardInfo]:
    """The shards that are there and whole.

    One that cannot be read, or that ends early because the dataset was smaller, is left out.

    Raises
    ------
    DatasetError
        If one is of another specification.
    """
    names = {f"shards/{name}" for name in folder.names("shards")}
    found = {}
    for shard in shards:
        name = shard_name(shard)
        if name not in names:
            continue
        try:
            info = info_of(folder, name)
        except DamagedShardError:
            continue
        if info.spec != spec.digest:
            raise DatasetError(f"{folder.where(name)}: {_difference(folder, name, spec)}")
        if info.rows == len(spec.indices(shard)):
            found[shard] = info
    return found


def _difference(folder: Folder, name: str, spec: DatasetSpec) -> str:
    """Return the message on how the specification of a shard differs from `spec`."""
    there, wanted = header_of(folder, name)["spec"], spec_to_json(spec)
    fields = sorted(f for f in wanted if f != "count" and there.get(f) != wanted[f])
    differ = f" (they differ in {', '.join(fields)})" if fields else ""
    return f"is of specification {there.get('name')!r}, not of this {spec.name!r}{differ}"


def read_manifest(folder: Folder) -> Manifest | None:
    """Return the manifest, or None."""
    if not folder.exists(MANIFEST):
        return None
    try:
        manifest = json.loads(folder.read(MANIFEST))
        if manifest["format"] != FORMAT:
            raise ValueError(f"format is {manifest['format']!r}, expected {FORMAT!r}")
    except (ValueError, KeyError, TypeError) as error:
        raise DatasetError(f"{folder.where(MANIFEST)}: not a manifest ({error})") from None
    return dict(manifest)


def write_manifest(folder: Folder, manifest: Manifest) -> None:
    """Write the manifest, with its long members at the end: specification and shards."""
    last = {name: manifest[name] for name in ("spec", "shards")}
    manifest = {name: value for name, value in manifest.items() if name not in last} | last
    folder.write(MANIFEST, (json.dumps(manifest, indent=1) + "\n").encode())


def manifest_of(
    folder: Folder,
    spec: DatasetSpec,
    infos: Mapping[int, ShardInfo],
    runs: list[dict[str, Any]],
    fresh: Collection[int] = (),
) -> Manifest:
    """Return the sums over the shards that exist.

    Parameters
    ----------
    folder : Folder
    spec : DatasetSpec
    infos : mapping of int to ShardInfo
        The shards that are there.
    runs : list of dict
        How long each run took, and with how many workers.
    fresh : collection of int
        Shards that were made since the last manifest. Of the others it holds what they should be,
        which is not renewed.
    """
    known = {s["name"]: s for s in (read_manifest(folder) or {}).get("shards", ())}
    known = {name: s for name, s in known.items() if name not in set(map(shard_name, fresh))}
    shards = [_entry(folder, infos[k], known) for k in sorted(infos)]
    together = content_hash(*(s["sha256"] for s in shards))
    records = sum(info.rows - info.failures for info in infos.values())
    size = sum(s["bytes"] for s in shards)
    return {
        "format": FORMAT,
        "name": spec.name,
        "complete": len(infos) == spec.shards,
        "records": records,
        "failed": sum(info.failures for info in infos.values()),
        "hash": together,
        "schema": version_of(spec),
        "code": dict(Counter(info.code for info in infos.values())),
        "spec_digest": spec.digest,
        "bytes": size,
        "bytes_per_record": round(size / max(records, 1), 1),
        **_totals(list(infos.values())),
        "runs": runs,
        "spec": spec_to_json(spec),
        "shards": shards,
    }


def _entry(folder: Folder, info: ShardInfo, known: Mapping[str, Manifest]) -> Manifest:
    """Name, size and hash of a shard."""
    name = shard_name(info.shard)
    if name in known and known[name]["rows"] == info.rows:
        return known[name]
    size, digest = folder.size(name), folder.sha256(name)
    return {"name": name, "rows": info.rows, "bytes": size, "sha256": digest}


def _totals(infos: list[ShardInfo]) -> Manifest:
    families: dict[str, Counter[str]] = {}
    for info in infos:
        for family, strata in info.strata.items():
            families.setdefault(family, Counter()).update(strata)
    strata = _sum(families.values())
    total = max(sum(strata.values()), 1)
    audited = _sum(info.audited for info in infos)
    wrong = sum(n for pair, n in audited.items() if len(set(pair.split("/"))) > 1)
    failed = [item for info in infos for item in info.failed.items()]
    return {
        "strata": {s: strata[s] for s in STRATA},
        "shares": {s: round(strata[s] / total, 4) for s in STRATA},
        "families": {f: dict(sorted(families[f].items())) for f in sorted(families)},
        "splits": dict(sorted(_sum(info.splits for info in infos).items())),
        "drawn": sum(info.attempts for info in infos),
        "rejected": dict(sorted(_sum(info.rejected for info in infos).items())),
        "caught": dict(_sum(info.caught for info in infos)),
        "audit": {
            "records": sum(audited.values()),
            "undecided": sum(info.undecided for info in infos),
            "disagreement": round(wrong / sum(audited.values()), 5) if audited else None,
            "label/oracle": dict(sorted(audited.items())),
        },
        "errors": dict(failed[:MOST_ERRORS]),
    }


def _sum(counts: Iterable[Mapping[str, int]]) -> Counter[str]:
    total: Counter[str] = Counter()
    for count in counts:
        total.update(count)
    return total


def survey(path: str | os.PathLike[str]) -> Manifest:
    """Return the manifest of a finished dataset, or a current one of an unfinished dataset.

    ``planned`` is true if the final number of records is known. A folder without a manifest only
    has its shards, and is never complete.
    """
    folder = Folder(path)
    manifest = read_manifest(folder)
    if manifest is not None and manifest["complete"]:
        return manifest | {"planned": True}
    spec = spec_of(folder)
    runs = [] if manifest is None else manifest["runs"]
    now = manifest_of(folder, spec, present(folder, spec, range(spec.shards)), runs)
    known = manifest is not None
    complete = known and now["complete"]
    return now | {"complete": complete, "planned": known, "kept": kept(spec, folder)}


def faults_of(folder: Folder, *, hashes: bool = False) -> Iterator[str]:
    """Yield a line for each shard that is missing, cut, or different from the manifest's.

    Without `hashes` only sizes are compared, which is quick.
    """
    manifest = read_manifest(folder)
    if manifest is None and hashes:
        raise DatasetError(f"{folder.url}: has no manifest to check it against")
    known = {entry["name"]: entry for entry in (manifest or {"shards": ()})["shards"]}
    there = {f"{SHARDS}/{name}" for name in folder.names(SHARDS) if name.endswith(".parquet")}
    for name in sorted(there.union(known)):
        if name not in there:
            yield f"{folder.where(name)}: is missing"
        elif name not in known:
            try:
                info_of(folder, name)
            except DamagedShardError as error:
                yield str(error)
        elif (size := folder.size(name)) != known[name]["bytes"]:
            wanted = known[name]["bytes"]
            yield f"{folder.where(name)}: {size} bytes, the manifest says {wanted}"
        elif hashes and folder.sha256(name) != known[name]["sha256"]:
            yield f"{folder.where(name)}: its bytes differ from the manifest"


def spec_of(folder: Folder) -> DatasetSpec:
    """Return the specification of a dataset, from the manifest or else from the last shard.

    Raises
    ------
    DatasetError
        If the folder holds no dataset.

    Notes
    -----
    Versions before this one wrote no manifest in the first minute. Of what they left unfinished,
    the last shard that is there decides the count.
    """
    manifest = read_manifest(folder)
    if manifest is not None:
        return spec_from_json(manifest["spec"])
    names = [name for name in folder.names("shards") if name.endswith(".parquet")]
    if not names:
        raise DatasetError(f"{folder.url}: holds no dataset (neither manifest.json nor shards)")
    content = header_of(folder, f"shards/{names[-1]}")["spec"]
    last = int(names[-1].split("-")[1].split(".")[0])
    rows = info_of(folder, f"shards/{names[-1]}").rows
    return spec_from_json(content | {"count": last * content["shard_size"] + rows})
