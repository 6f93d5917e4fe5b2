"""Cross-checks of small arms: of one joint, of random numbers, on any number of processes."""

import pytest

import crosscheck as package
from tests.arms import arm_of, random_arm

pytestmark = pytest.mark.system


@pytest.mark.usefixtures("brief_plan")
def test_an_arm_of_one_joint_passes_every_check_on_any_number_of_processes():
    one, two = (package.check(arm_of(1), quick=True, jobs=jobs) for jobs in (1, 2))
    assert [f"{f.id}: {f.measured} {f.note}" for f in one.disagreeing] == []
    assert one.to_dict()["findings"] == two.to_dict()["findings"]


@pytest.mark.usefixtures("brief_plan")
def test_arm_called_like_the_probe_is_distinguished_from_it(labelled):
    arm = labelled.model_copy(update={"name": "probe"})
    agreement = package.check(arm, quick=True, jobs=2)
    assert [f.id for f in agreement.disagreeing] == []
    assert len({f.id for f in agreement.findings}) == len(agreement.findings)


@pytest.mark.usefixtures("brief_plan")
@pytest.mark.parametrize("seed", [1, 8])
def test_an_arm_of_random_numbers_raises_no_false_alarm(seed):
    agreement = package.check(random_arm(seed, most_joints=2), quick=True, jobs=2, seed=seed)
    assert [f"{f.id}: {f.measured} {f.note}" for f in agreement.disagreeing] == []
