"""Catches as Minari episodes: the arena's own observations, and an environment to recover."""

import warnings

import numpy as np
import pytest

pytest.importorskip("pyarrow")
minari = pytest.importorskip("minari")

from gcm_learn import artifacts, dataset, envs  # noqa: E402
from gcm_learn.errors import DatasetError, UnknownNameError  # noqa: E402
from gcm_learn.policies import export_minari  # noqa: E402

SAMPLES = {"CatchArm": "sample", "CatchArm3D": "sample-space"}


@pytest.fixture(
    scope="module", params=["CatchArm", pytest.param("CatchArm3D", marks=pytest.mark.slow)]
)
def name(request):
    """Return the name of an environment."""
    return request.param


@pytest.fixture(scope="module")
def records(name):
    """Return records for its arms."""
    return dataset.open(artifacts.shipped("data") / SAMPLES[name])[:24]


@pytest.fixture(scope="module")
def exported(records, tmp_path_factory):
    """Return the records as Minari reads them."""
    with pytest.MonkeyPatch.context() as patch, warnings.catch_warnings():
        patch.setenv("MINARI_DATASETS_PATH", str(tmp_path_factory.mktemp("minari")))
        warnings.simplefilter("error")
        export_minari(records, "gcm-learn/try-v0", settings={"slots": 4})
        yield minari.load_dataset("gcm-learn/try-v0")


def test_the_arena_plays_the_episodes_again(name, records, exported):
    caught = {r.index: r for r in records if r.plans[records.spec.persistent].caught}
    episodes = list(exported.iterate_episodes())
    seeds = [exported.storage.get_episode_metadata([e.id]) for e in episodes]
    indices = [int(next(iter(found))["seed"]) for found in seeds]
    assert 5 < len(episodes) <= len(caught) and set(indices) <= set(caught)
    env = getattr(envs, name)([r.situation for r in records][:1], settings={"slots": 4})
    for episode, index in zip(episodes, indices, strict=True):
        seen, _ = env.reset(options={"situation": caught[index].situation})
        np.testing.assert_array_equal(episode.observations[0], seen)
        for k, action in enumerate(episode.actions):
            assert env.action_space.contains(action)
            seen, reward, ended, late, info = env.step(action)
            np.testing.assert_array_equal(episode.observations[k + 1], seen)
            assert episode.rewards[k] == pytest.approx(reward, abs=1e-6)
            assert (episode.terminations[k], episode.truncations[k]) == (ended, late)
        assert info["outcome"] == "caught"


def test_the_environment_is_recovered(name, exported):
    env = exported.recover_environment(pool=2)
    assert type(env.unwrapped) is getattr(envs, name) and env.unwrapped.settings.slots == 4
    assert exported.env_spec.id == f"gcm_learn/{name}-v0"
    assert env.observation_space == exported.observation_space
    assert env.action_space == exported.action_space
    env.reset(seed=0)


def test_what_cannot_be_exported_is_one_line(records):
    with pytest.raises(UnknownNameError, match="planner: 'gmc'"):
        export_minari(records, "gcm-learn/no-v0", planner="gmc")
    lost = records.where(stratum="U")
    if len(lost):
        with pytest.raises(DatasetError, match=f"no catch of {records.spec.persistent}"):
            export_minari(lost, "gcm-learn/no-v0")
