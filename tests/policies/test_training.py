"""Training: files of hyperparameters, clones, learners that go on."""

import json
import re

import numpy as np
import pytest

from gcm_learn.cli import main
from gcm_learn.errors import FileFormatError, PolicyError
from tests.refusals import refusal

yaml = pytest.importorskip("yaml")
from gcm_learn.policies.plan import plan_of, read_plan  # noqa: E402

SOME = [{"source": "random-planar", "count": 30}]
ENTRY = {"algo": "ppo", "n_timesteps": 256, "n_envs": 8, "situations": SOME, "validation": SOME,
         "n_steps": 16, "batch_size": 64, "n_epochs": 1, "evaluate_every": 128,
         "settings": {"fan": True}, "net_arch": "16,16"}  # fmt: skip


def written(path, **changes):
    """Write a file of hyperparameters."""
    path.write_text(yaml.safe_dump({"CatchArm-v0": {**ENTRY, **changes}}))
    return path


KNOWN = "'guess' is not one of covered, "
GUIDED = {"weights": {"guide": 1.0}}
BAD = [
    ({"n_timesteps": "sixty"}, "n_timesteps: must be a whole number (got 'sixty')"),
    ({"n_steps": "many"}, "n_steps: must be a whole number (got 'many')"),
    ({"n_envz": 3}, "n_envz: is not a known field (did you mean 'n_envs'?) of ppo"),
    ({"algo": "sac", "actions": "velocity", "clip_range": 1}, "clip_range: is not a known"),
    ({"situations": [{"source": "gate", "cuont": 1}]}, "situations.cuont: is not a known"),
    ({"algo": "dream"}, "algo: 'dream' is not one of clone, ppo, sac, tqc"),
    ({"n_timesteps": 0}, "n_timesteps: must be at least 1"),
    ({"situations": []}, "situations: there is none"),
    ({"until_settled": True}, "until_settled: must be 0, or at least 10 evaluations"),
    ({"situations": [{"count": 3}]}, "situations: each must have source"),
    ({"situations": [{"source": "gate", "shown_by": "guess"}]}, f"situations.shown_by: {KNOWN}"),
    ({"validation": [{"source": "gate", "caught_by": "guess"}]}, f"validation.caught_by: {KNOWN}"),
    ({"algo": "sac"}, "actions: sac needs velocity"),
    ({"settings": {"dt": 9}}, "dt: must be from 0.0001 to 1 s"),
    ({"demonstrations": True}, "demonstrations: ppo has no replay buffer"),
    ({"gamma": 0.9, "settings": GUIDED}, "settings.discount: must be the learner's gamma (0.9)"),
]


@pytest.mark.parametrize(("changes", "message"), BAD)
def test_bad_files_are_refused_in_one_line(tmp_path, changes, message):
    path = written(tmp_path / "bad.yml", **changes)
    text = refusal(FileFormatError, read_plan, path)
    assert re.match(rf"{re.escape(str(path))}:\d+: CatchArm-v0\.", text), text
    assert message in text
    key = message.partition(":")[0].rpartition(".")[2]
    line = int(text.removeprefix(f"{path}:").partition(":")[0])
    assert key in path.read_text().splitlines()[line - 1] or line == 1


def test_the_namespace_of_gymnasium_may_stand_before_an_environment(tmp_path):
    path = tmp_path / "plan.yml"
    for name in ("CatchArm-v0", "gcm_learn/CatchArm-v0"):
        path.write_text(yaml.safe_dump({name: ENTRY}))
        assert read_plan(path).n_envs == 8
    path.write_text(yaml.safe_dump({"CatchAmr-v0": ENTRY}))
    with pytest.raises(FileFormatError, match=r"'CatchAmr-v0' is not one of .* 'CatchArm-v0'"):
        read_plan(path)
    for text in ("", "CatchArm-v0:", "- 3"):
        path.write_text(text)
        with pytest.raises(FileFormatError, match="must hold"):
            read_plan(path)


def test_an_unknown_key_is_found_before_situations_are_drawn(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("gcm_learn.policies.training.gather", None)
    path = written(tmp_path / "bad.yml", n_envz=3)
    assert main(["train", "policy", str(path), "--out", str(tmp_path / "out")]) == 2
    said = capsys.readouterr().err
    assert "CatchArm-v0.n_envz: is not a known field (did you mean 'n_envs'?) of ppo" in said
    assert said.startswith(str(path)) and not (tmp_path / "out").exists()


def test_numbers_may_be_written_as_people_do(tmp_path):
    path = tmp_path / "plan.yml"
    path.write_text(yaml.safe_dump({"CatchArm-v0": ENTRY}) + "  learning_rate: 3e-4\n")
    plan = read_plan(path)
    assert plan.hyperparameters["learning_rate"] == 3e-4
    assert plan_of({**ENTRY, "n_timesteps": "1e6"}).n_timesteps == 1_000_000
    for layer in ("16", 16):  # one is a list too, and no number
        assert plan_of({**ENTRY, "net_arch": layer}).hyperparameters["net_arch"] == layer


def test_a_clone_learns_what_it_is_shown(tmp_path):
    pytest.importorskip("torch")
    from gcm_learn.policies.training import train

    plan = plan_of({
        "algo": "clone", "situations": [{"source": "random-planar", "count": 120}],
        "validation": [{"source": "random-planar", "count": 60, "reachable": True, "seed": 1}],
        "epochs": 30, "batch": 128, "net_arch": "64,64", "rate": 3e-3,
    })  # fmt: skip
    told = []
    scores = train(plan, tmp_path, told.append)
    assert scores["caught"] > 0.6, "a network that knows nothing catches a fifth"
    rows = [json.loads(line) for line in (tmp_path / "log.jsonl").read_text().splitlines()]
    losses = [row["loss"] for row in rows if "loss" in row]
    assert losses[-1] < 0.7 * losses[0]
    assert "random-planar" in (tmp_path / "card.md").read_text()


def test_a_learner_goes_on_where_it_stopped(tmp_path):
    pytest.importorskip("stable_baselines3")
    from tensorboard.backend.event_processing.event_accumulator import EventAccumulator

    from gcm_learn.policies.actor import Actor
    from gcm_learn.policies.training import train

    told = []
    path = written(tmp_path / "ppo.yml", n_timesteps=128)
    train(read_plan(path), tmp_path / "run", told.append)
    before = (tmp_path / "run" / "model.zip").read_bytes()
    (events,) = (tmp_path / "run" / "tensorboard").glob("*/events*")
    tags = EventAccumulator(str(events)).Reload().Tags()["scalars"]
    assert {"eval/caught", "eval/touched", "train/loss"} <= set(tags)
    assert main(["train", "policy", str(written(path)), "--out", str(tmp_path / "run")]) == 0
    assert (tmp_path / "run" / "model.zip").read_bytes() != before
    rows = [json.loads(r) for r in (tmp_path / "run" / "log.jsonl").read_text().splitlines()]
    assert [row["steps"] for row in rows] == [0, 128, 256]
    assert Actor.load(tmp_path / "run").head == "choice"
    with pytest.raises(PolicyError, match="another run, whose n_envs differ"):
        train(read_plan(written(path, n_envs=4)), tmp_path / "run", told.append)


def test_a_run_ends_once_it_has_stopped_gaining(tmp_path, monkeypatch):
    """Quarters of one check whose gain is always too small: learning ends after the fourth."""
    pytest.importorskip("stable_baselines3")
    from gcm_learn.policies import curves
    from gcm_learn.policies.training import train

    monkeypatch.setattr(curves, "CHECKS", 1)
    monkeypatch.setattr(curves, "GAIN", 2.0)
    short = {"until_settled": 1, "bfloat16": True, "value_arch": "8", "n_timesteps": 10_000}
    plan = plan_of({**ENTRY, **short})
    for _ in range(2):  # again: nothing is left to learn
        train(plan, tmp_path, lambda text: None)
        rows = [json.loads(r) for r in (tmp_path / "log.jsonl").read_text().splitlines()]
        assert [row["steps"] for row in rows] == [0, 128, 256, 384]
    assert rows[1]["processor"] < rows[3]["processor"]
    assert "which stopped gaining" in (tmp_path / "card.md").read_text()


def test_a_run_that_never_began_does_not_claim_its_folder(tmp_path, monkeypatch):
    pytest.importorskip("stable_baselines3")
    from gcm_learn.policies import training

    def fail(*args, **options):
        raise PolicyError("no such dataset")

    run = tmp_path / "run"
    with monkeypatch.context() as patch:
        patch.setattr(training, "gather", fail)
        with pytest.raises(PolicyError, match="no such dataset"):
            training.train(read_plan(written(tmp_path / "ppo.yml", n_envs=4)), run)
    training.train(read_plan(written(tmp_path / "ppo.yml", n_timesteps=128)), run)
    assert (run / "actor.npz").exists()


def test_a_replay_buffer_begins_with_the_catches_it_is_shown(tmp_path):
    """A clone of velocities is SAC's start; what is shown are the arena's own steps."""
    pytest.importorskip("stable_baselines3")
    from gcm_learn.policies import reinforcement as rl
    from gcm_learn.policies.actor import Actor
    from gcm_learn.policies.cloning import transitions
    from gcm_learn.policies.situations import gather
    from gcm_learn.policies.training import train

    small = {"situations": [{"source": "random-planar", "count": 40}], "validation": SOME,
             "net_arch": "16,16", "actions": "velocity",
             "settings": {"fan": True, "embedding": True}}  # fmt: skip
    train(plan_of({"algo": "clone", "epochs": 3, **small}), tmp_path / "clone", lambda text: None)
    start = Actor.load(tmp_path / "clone")
    assert start.head == "velocity" and start.squash and start.settings.embedding
    plan = plan_of({**small, "algo": "sac", "n_timesteps": 8, "n_envs": 4, "start":
                    str(tmp_path / "clone"), "demonstrations": True})  # fmt: skip
    shown = gather(plan.situations, plans=True).shown()
    model = rl.make(plan, plan.settings.prepared(shown.pool), tmp_path)
    actor = rl.actor_of(model, plan)
    for mine, its in zip(actor.layers, start.layers, strict=True):
        np.testing.assert_array_equal(mine[0], its[0])
    moves = transitions(shown.pool, shown.paths, plan.settings)
    rl.show(model, moves, plan.settings)
    buffer, whole = model.replay_buffer, 4 * (len(moves.arms) // 4)
    assert buffer.size() * 4 == whole
    np.testing.assert_array_equal(buffer.observations[: buffer.size()].reshape(whole, -1),
                                  moves.told[:whole])  # fmt: skip
    # An arm is told after a step what it is told before its next one.
    for arm in (0, 3):
        rows = np.flatnonzero(moves.arms == arm)
        np.testing.assert_array_equal(moves.following[rows[:-1]], moves.told[rows[1:]])
    caught = moves.rewards[moves.outcomes == 1]
    assert len(caught) > 0.9 * len(shown.situations) and np.all(caught > 0.8)
    model.learn(8)
    assert buffer.size() * 4 > whole


def test_learners_act_as_their_arrays_do(tmp_path):
    """The actor that is kept chooses as the network of the learner does; a clone is its start."""
    pytest.importorskip("stable_baselines3")
    from gcm_learn.policies import reinforcement as rl
    from gcm_learn.policies.directions import turned
    from gcm_learn.policies.situations import gather

    pool = gather(plan_of(ENTRY).situations, plans=False).pool
    for changes in ({}, {"actions": "velocity"}, {"algo": "sac", "actions": "velocity"}):
        values = {k: v for k, v in ENTRY.items() if k not in ("n_steps", "n_epochs")}
        plan = plan_of({**(values if "algo" in changes else ENTRY), **changes})
        model = rl.make(plan, pool, tmp_path)
        env = model.get_env()
        observations = env.reset()
        for _ in range(20):
            observations, *_ = env.step(np.array([env.action_space.sample() for _ in range(8)]))
        raw = env.venv.plant.observations
        wanted, _ = model.predict(observations, deterministic=True)
        actor = rl.actor_of(model, plan)
        got = actor.scores(raw).argmax(axis=1) if plan.actions == "choice" else actor.act(raw)
        if plan.actions == "velocity":
            wanted = turned(raw, wanted)
        # The statistics have seen these observations after they were scaled.
        if plan.actions == "choice":
            assert np.mean(got == wanted) >= 0.75
        else:
            np.testing.assert_allclose(got, wanted, atol=0.1)
    actor.save(tmp_path)
    with pytest.raises(PolicyError, match="start: its layers are"):
        rl.make(plan_of({**ENTRY, "start": str(tmp_path)}), pool, tmp_path)
