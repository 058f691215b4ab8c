"""The study two_rounds runs as it stands in its folder, in its quick version."""

import pytest

from drake_blfdmp.evaluation.study import StudyContext
from drake_blfdmp.evaluation.study_runner import FindStudies, LoadStudy
from drake_blfdmp.planning.scenario import LoadScenario


@pytest.fixture(scope="module")
def result(request):
    script = FindStudies(request.config.rootpath / "studies")["two_rounds"]
    told = []
    context = StudyContext(LoadScenario(script.scenario), True, lambda what, share: told.append(share), None)
    study = LoadStudy(script)(context)
    assert told and all(0.0 <= share <= 1.0 for share in told)
    return study


def test_claims(result):
    """All but the last: the cost is a matter of the machine."""
    assert [claim.holds for claim in result.claims[:-1]] == [True, True, True, True, False]


def test_tables_and_figures(result, redrawn):
    laws = result.tables["laws"].columns
    assert list(laws["law"]) == ["default", "published", "published_loop"]
    assert list(laws["samples_outside"]) == [0, 0, 0]
    assert laws["largest_widening_m"][1] > 0.01
    assert all(ratio > 0 for ratio in result.tables["cost"].columns["cpu_time_published_by_default"])
    assert set(redrawn(result)) == {"links", "remark_2"}
