"""Training runs: from a plan to a folder with a trained policy and its card."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import torch

from gcm_learn.errors import PolicyError
from gcm_learn.execution import CAUGHT, COLLIDED, Pool
from gcm_learn.policies import curves
from gcm_learn.policies.actor import LEARNER, Actor, file_of
from gcm_learn.policies.cloning import Cloning, Demonstrations, act_out, clone, transitions
from gcm_learn.policies.plan import Share, TrainingPlan
from gcm_learn.policies.situations import Lot, gather
from gcm_learn.storage import content_hash, write_whole

CARD = "card.md"


def score(actor: Actor, pool: Pool, groups: Sequence[str]) -> dict[str, float]:
    """Shares of catches and touches, over all situations and by group."""
    episodes = actor.play(pool, np.arange(len(pool)))
    caught, touched = episodes.outcomes == CAUGHT, episodes.outcomes == COLLIDED
    out = {"caught": float(caught.mean()), "touched": float(touched.mean())}
    out |= {f"caught {g}": v for g, v in _by_group(groups, caught).items()}
    out |= {f"touched {g}": v for g, v in _by_group(groups, touched).items()}
    return out


def write_card(
    folder: Path,
    plan: TrainingPlan,
    steps: int,
    scores: Mapping[str, float],
    sizes: Mapping[str, int],
    rows: Sequence[Mapping[str, Any]] = (),
) -> Path:
    """Write a policy's card, with the learning curve if there is one; return the card's path."""
    file = file_of(plan.settings)
    digest = content_hash((folder / file).read_bytes())[:16]
    sources = "; ".join(_told(share) for share in plan.situations)
    judged = "; ".join(_told(share) for share in plan.validation)
    lines = [
        f"# {folder.name}",
        "",
        f"- made by: `gcm-learn train policy CONFIG --out {folder.name}`, configuration in "
        "`config.json`",
        f"- algorithm: {plan.algo}, actions: {plan.actions}, seed {plan.seed}",
        f"- steps: {steps} (of {plan.n_timesteps}; the best on the validation situations is kept)",
        f"- trained on: {sources}",
        f"- begun with: {plan.start or 'nothing'}",
        f"- `{file}`: sha256 {digest}...",
        "",
        f"Validation situations ({judged}), most likely actions, 95 % intervals (Wilson):",
        "",
        "| group | situations | caught | touched |",
        "|---|---|---|---|",
    ]
    total = sum(sizes.values())
    for group, n in [("all", total), *sizes.items()]:
        tail = "" if group == "all" else f" {group}"
        caught, touched = scores[f"caught{tail}"], scores[f"touched{tail}"]
        lines.append(f"| {group} | {n} | {_interval(caught, n)} | {_interval(touched, n)} |")
    if rows:
        hours = rows[-1]["processor"] / 3600.0
        lines += ["", f"Curve over {rows[-1]['steps']:,} steps and {hours:.2f} processor hours, "
                  f"which {curves.in_words(rows)}:", "", *curves.table_of(rows)]  # fmt: skip
    lines += [
        "",
        "The validation situations chose the checkpoint, so these figures flatter a little. Known",
        "limits: exact observations of bodies, of at most four obstacles; steps of 0.02 s.",
    ]
    path = folder / CARD
    write_whole(path, "\n".join(lines) + "\n")
    return path


def _told(share: Share) -> str:
    text = [f"{share.count} of {share.source}"]
    if Path(share.source).is_dir():
        manifest = json.loads((Path(share.source) / "manifest.json").read_text("utf-8"))
        text.append(f"hash {manifest['hash'][:16]}, split {share.split}")
    if share.strata:
        text.append(f"strata {', '.join(share.strata)}")
    if share.families:
        text.append(f"families {', '.join(share.families)}")
    if share.reachable or share.caught_by:
        text.append(f"only what `{share.caught_by or 'search'}` catches")
    if share.shown_by != "search":
        text.append(f"catches of `{share.shown_by}` are shown")
    return ", ".join(text)


def _interval(share: float, n: int) -> str:
    """Share with Wilson's interval, in per cent."""
    from scipy.stats import binomtest  # takes a second to load

    low, high = binomtest(round(share * n), n).proportion_ci(method="wilson")
    return f"{share:.1%} ({low:.1%} to {high:.1%})"


def _by_group(groups: Sequence[str], values: np.ndarray) -> dict[str, float]:
    """Means of values (n,) by group."""
    names = np.array(groups)
    return {str(g): float(np.mean(values[names == g])) for g in sorted(set(groups))}


CONFIG, LOG, STATE = "config.json", "log.jsonl", "state.json"
_PART = 1000  # situations that are acted out at once
Told = Callable[[str], object]


@dataclass
class TrainingRun:
    """A training run in its folder."""

    plan: TrainingPlan
    folder: Path
    tell: Told
    started: float = 0.0

    def log(self, row: dict[str, Any]) -> None:
        """Append a row to the run's log."""
        with open(self.folder / LOG, "a", encoding="utf-8") as stream:
            stream.write(json.dumps(row) + "\n")

    @property
    def seconds(self) -> float:
        """Time since this process took the run up [s]."""
        return time.perf_counter() - self.started

    @property
    def processor(self) -> float:
        """Processor time of the run, in this process and in earlier ones [s]."""
        return self.before + time.process_time()

    @cached_property
    def before(self) -> float:
        """Processor time until this process took the run up [s]."""
        return float(self.rows[-1].get("processor", 0.0)) if self.rows else 0.0

    @property
    def rows(self) -> list[dict[str, Any]]:
        """Checks so far, out of the log."""
        path = self.folder / LOG
        text = path.read_text("utf-8") if path.exists() else ""
        return [row for row in map(json.loads, text.splitlines()) if "steps" in row]

    @property
    def settled(self) -> bool:
        """True once learning is over because the shares of catches have stopped gaining."""
        least, shares = self.plan.until_settled, [row["caught"] for row in self.rows]
        return least > 0 and curves.stopped_gaining(shares, least)


def train(plan: TrainingPlan, folder: Path, tell: Told = print) -> dict[str, float]:
    """Train a policy as a plan says, or resume its training.

    Parameters
    ----------
    plan : TrainingPlan
    folder : Path
        Where the policy, its checkpoints, log and card are kept. A run that was interrupted goes
        on from its last checkpoint.
    tell : callable
        Called with sentences about the progress.

    Returns
    -------
    dict
        Scores of the policy that is kept, the best on the validation situations.
    """
    folder.mkdir(parents=True, exist_ok=True)
    run = TrainingRun(plan, folder, tell, time.perf_counter())
    _claim(run)
    torch.set_num_threads(1)
    asked = plan.algo == "clone" or plan.demonstrations
    judged = gather(
        plan.validation, plan.settings, plans=False, tell=lambda s: tell(f"validation: {s}")
    )
    shown = gather(plan.situations, plan.settings, plans=asked, tell=lambda s: tell(s))
    judge = _Judge(run, judged.pool, judged.groups)
    if plan.algo == "clone":
        _clone(run, shown.shown(), judge)
    else:
        _reinforce(run, shown, judge)
    rows = [] if plan.algo == "clone" else run.rows
    write_card(folder, plan, judge.best, judge.scores, judge.sizes, rows)
    return judge.scores


def _claim(run: TrainingRun) -> None:
    """Write the plan into the run's folder; refuse a folder with a run of another plan.

    A run without a log has learned nothing yet, and is overwritten.
    """
    text = json.dumps(plan_to_json(run.plan), indent=1) + "\n"
    path = run.folder / CONFIG
    if path.exists() and (run.folder / LOG).exists():
        old = json.loads(path.read_text("utf-8"))
        new = json.loads(text)
        for both in (old, new):
            for name in ("n_timesteps", "until_settled"):  # more steps continue a run
                both.pop(name, None)
        if old != new:
            fields = sorted(f for f in new if old.get(f) != new[f])
            raise PolicyError(f"{path}: another run, whose {', '.join(fields)} differ")
    write_whole(path, text)


def plan_to_json(plan: TrainingPlan) -> dict[str, Any]:
    """A plan as JSON values."""
    values = {name: getattr(plan, name) for name in plan.__dataclass_fields__}
    values["settings"] = asdict(plan.settings)
    values["hyperparameters"] = dict(plan.hyperparameters)
    for name in ("situations", "validation"):
        values[name] = [
            dict(vars(share), strata=list(share.strata), families=list(share.families))
            for share in values[name]
        ]
    return values


class _Judge:
    """Scores actors on the validation situations and keeps the best."""

    def __init__(self, run: TrainingRun, pool: Pool, groups: list[str]) -> None:
        # Maps are for learning only: without them an actor is judged, kept and used.
        weights = replace(run.plan.settings.weights, guide=0.0)
        self.plain = replace(run.plan.settings, weights=weights)
        self.run, self.pool, self.groups = run, self.plain.prepared(pool), groups
        self.best, self.scores = 0, dict[str, float]()
        self.sizes = {g: groups.count(g) for g in sorted(set(groups))}
        path = run.folder / STATE
        if path.exists():
            state = json.loads(path.read_text("utf-8"))
            self.best, self.scores = state["best"], state["scores"]

    def see(self, actor: Actor, steps: int, more: dict[str, float]) -> dict[str, float]:
        """Score an actor, save it if it is the best so far, and return its scores."""
        actor = replace(actor, settings=self.plain)
        scores = score(actor, self.pool, self.groups)
        spent = {"seconds": round(self.run.seconds, 1), "processor": round(self.run.processor, 1)}
        self.run.log({"steps": steps, **spent, **scores, **more})
        self.run.tell(
            f"{steps} steps, {self.run.seconds:.0f} s: {scores['caught']:.1%} caught, "
            f"{scores['touched']:.1%} touched"
        )
        if scores["caught"] >= self.scores.get("caught", -1.0):
            self.best, self.scores = steps, scores
            actor.save(self.run.folder)
        state = {"best": self.best, "scores": self.scores}
        write_whole(self.run.folder / STATE, json.dumps(state) + "\n")
        return scores


def _clone(run: TrainingRun, shown: Lot, judge: _Judge) -> None:
    """Act catches out and clone them."""
    plan = run.plan
    demonstrations = Demonstrations.joined(
        act_out(pool, paths, plan.settings) for pool, paths in _parts(shown)
    )
    run.tell(
        f"{len(demonstrations.actions)} steps of {demonstrations.caught.sum()} catches; "
        f"{len(shown.situations)} were planned"
    )
    values = dict(plan.hyperparameters)
    layers = tuple(int(n) for n in str(values.pop("net_arch", "256,256")).split(","))
    counts = {name: int(values.pop(name)) for name in ("epochs", "batch") if name in values}
    try:
        how = Cloning(layers=layers, **counts, **values)
    except TypeError as error:
        raise PolicyError(str(error)) from None

    def report(row: dict[str, float]) -> None:
        run.log({"seconds": round(run.seconds, 1), **row})
        run.tell(f"epoch {row['epoch']:.0f}: loss {row['held_out_loss']:.3f} on what is held out")

    choices = plan.actions == "choice"
    made = clone(demonstrations, plan.settings, how, plan.seed, report, choices=choices)
    judge.see(made, 0, {})


def _parts(shown: Lot) -> Iterator[tuple[Pool, list[Any]]]:
    """Situations and their catches, some at a time."""
    for first in range(0, len(shown.situations), _PART):
        rows = slice(first, first + _PART)
        part = Lot(shown.situations[rows], shown.groups[rows], shown.paths[rows], shown.settings)
        yield part.pool, [path for path in part.paths if path is not None]


def _reinforce(run: TrainingRun, lot: Lot, judge: _Judge) -> None:
    """Let a learner act and learn, judged and kept every so often."""
    from gcm_learn.policies import reinforcement as rl

    rl.keep_memory()
    plan, folder = run.plan, run.folder
    settings = plan.settings
    if settings.weights.guide != 0.0:
        run.tell(f"preparing the guide of {len(lot.situations)} situations")
    pool = settings.prepared(lot.pool)
    if (folder / LEARNER).exists():
        model = rl.go_on(plan, pool, folder)
        run.tell(f"going on after {model.num_timesteps} steps")
    else:
        model = rl.make(plan, pool, folder / "tensorboard")
        if plan.demonstrations:
            for part, paths in _parts(lot.shown()):
                rl.show(model, transitions(part, paths, settings), settings)
            run.tell(f"{model.replay_buffer.size() * plan.n_envs} steps of catches are shown")
        judge.see(rl.actor_of(model, plan), 0, {})

    def check() -> bool:
        episodes = list(model.ep_info_buffer or [])
        mean = float(np.mean([e["r"] for e in episodes])) if episodes else 0.0
        rl.keep(model, folder)
        scores = judge.see(rl.actor_of(model, plan), model.num_timesteps, {"return": mean})
        for name in ("caught", "touched"):
            model.logger.record(f"eval/{name}", scores[name])
        model.logger.dump(model.num_timesteps)
        return run.settled

    if model.num_timesteps < plan.n_timesteps and not run.settled:
        left = plan.n_timesteps - model.num_timesteps
        checks = rl.Checks(plan.evaluate_every, check)
        model.learn(left, checks, reset_num_timesteps=False, tb_log_name=plan.algo)
        if not checks.over:
            check()
    run.tell(f"the learner {curves.in_words(run.rows)}")
