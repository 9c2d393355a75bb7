"""What trains does not judge: splits, seeds, and steps that are held out."""

from pathlib import Path

import numpy as np
import pytest

from gcm_learn import families
from gcm_learn.evaluation import turns
from gcm_learn.execution import SpatialSettings, situations_of
from gcm_learn.policies.plan import Share, plan_of, read_plan
from gcm_learn.policies.situations import gather

CONFIGURATIONS = sorted((Path(__file__).parents[2] / "experiments").glob("*/*.yml"))


@pytest.mark.parametrize("split", ["train", "validation"])
def test_a_share_of_a_dataset_is_of_one_split(marked_folder, split):
    from gcm_learn import dataset

    wanted = [record.situation for record in dataset.open(marked_folder).where(split=split)]
    lot = gather([Share(marked_folder, 1000, split=split)], plans=True)
    assert lot.situations == wanted and len(wanted) > 5
    if split == "train":  # also what is taken if nobody says which
        assert gather([Share(marked_folder, 1000)], plans=False).situations == wanted
        assert situations_of(marked_folder, 1000, 0) == wanted


@pytest.mark.parametrize(
    "choice",
    [{"split": "validation"}, {"strata": ("W",)}, {"families": ("door-space", "crate-space")}],
    ids=lambda choice: next(iter(choice)),
)
def test_a_share_of_a_dataset_in_space_holds_the_wanted_records_only(choice):
    from gcm_learn import dataset

    folder = str(Path(__file__).parents[2] / "data" / "sample-space")
    lot = gather([Share(folder, 1000, **choice)], plans=False, settings=SpatialSettings())
    split = choice.get("split", "train")
    strata, names = choice.get("strata", "LWQU"), choice.get("families", families.family_names())
    assert lot.situations == [
        record.situation
        for record in dataset.open(folder).where(split=split)
        if record.stratum in strata and record.family in names
    ]
    assert 0 < len(lot.situations) < 200


def drawn(seed):
    """The bodies of a family's situations under a seed."""
    lot = gather([Share("moving-point", 30, seed=seed)], plans=False)
    return {situation.bodies for situation in lot.situations}


def test_other_seeds_give_other_situations():
    assert drawn(0) == drawn(0) and len(drawn(0)) == 30
    assert not drawn(0) & drawn(1)


def test_no_seed_of_training_gives_the_draws_of_suites():
    """Not even that of the suites: what trains has draws of its own under each seed."""
    from gcm_learn.situation.canonical import canonical

    suite = [canonical(families.draw("moving-point", turns.SEED, k))[0] for k in range(30)]
    assert not drawn(turns.SEED) & {situation.bodies for situation in suite}


@pytest.mark.parametrize("path", CONFIGURATIONS, ids=lambda path: path.stem)
def test_no_configuration_validates_on_what_it_trains_on(path):
    pytest.importorskip("yaml")
    plan = read_plan(path)
    for judged in plan.validation:
        is_family = judged.source in families.family_names()
        is_file = judged.source.endswith(".jsonl")  # which has no splits
        assert is_family or is_file or judged.split == "validation"
        for shown in plan.situations:
            assert not is_file or shown.source != judged.source
            assert is_family or shown.split == "train"
            assert (judged.source, judged.split, judged.seed) != (
                shown.source, shown.split, shown.seed,
            )  # fmt: skip


def test_checkpoints_are_judged_on_the_situations_for_validation(tmp_path):
    pytest.importorskip("torch")
    from gcm_learn.policies.training import train

    plan = plan_of({
        "algo": "clone", "situations": [{"source": "moving-point", "count": 20}], "epochs": 1,
        "validation": [{"source": "static-clutter", "count": 5}], "net_arch": "8",
    })  # fmt: skip
    scores = train(plan, tmp_path, lambda sentence: None)
    groups = {name.partition(" ")[2] for name in scores} - {""}
    assert groups == {"static-clutter"}


def test_a_clone_does_not_learn_the_steps_that_measure_it(rng):
    """Where there is nothing to learn it can only learn by heart, and that does not help there."""
    pytest.importorskip("torch")
    from gcm_learn.execution import Settings
    from gcm_learn.policies.cloning import Cloning, Demonstrations, clone

    settings, n = Settings(fan=True), 200
    angles = rng.uniform(0.0, 2.0 * np.pi, n)
    noise = Demonstrations(
        rng.normal(size=(n, settings.width)).astype(np.float32),
        np.stack([np.cos(angles), np.sin(angles)], axis=1).astype(np.float32),
        np.ones(1, bool),
    )
    rows = []
    clone(noise, settings, Cloning((64,), 40, 40, 1e-2, held_out=0.2), 0, rows.append)
    assert rows[-1]["loss"] < 0.3 and rows[-1]["held_out_loss"] > 3.0
