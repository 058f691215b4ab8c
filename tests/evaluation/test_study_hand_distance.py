"""The study hand_distance runs as it stands in its folder, in its quick version."""

import pytest

from drake_blfdmp.evaluation.study import StudyContext
from drake_blfdmp.evaluation.study_runner import FindStudies, LoadStudy
from drake_blfdmp.planning.scenario import LoadScenario


@pytest.fixture(scope="module")
def result(request):
    script = FindStudies(request.config.rootpath / "studies")["hand_distance"]
    told = []
    context = StudyContext(LoadScenario(script.scenario), True, lambda what, share: told.append(share), None)
    study = LoadStudy(script)(context)
    assert told and all(0.0 <= share <= 1.0 for share in told)
    return study


def test_claims(result):
    """The last needs the whole search, `test_gain_search` has it: here it holds or is not judged."""
    assert [claim.holds for claim in result.claims[:-1]] == [True, True, False, True, False]
    assert result.claims[-1].holds is not False
    assert "rest at 0.305660377 m" in result.claims[1].measured
    assert "with the task's gains" in result.claims[3].measured


def test_tables(result):
    rows = {row[:2]: row[2:] for row in result.tables["laws"].rows()}
    assert rows["moving", "default"][1] == rows["constant", "default"][1] == 0
    assert rows["moving", "published_lagged"][1] > 1000
    assert rows["moving", "published"][0] == rows["moving", "published_loop"][0] != rows["constant", "published"][0]
    assert rows["moving", "default"][0] == rows["constant", "default"][0] == "k_1 8, k_2 20"
    off = result.tables["resting"].columns["off_the_closed_form_m"]
    assert off[0] == 0.0 and abs(off[1]) < 1e-8 < 1e-6 < abs(off[3]) < abs(off[2])
    assert all(kept == 0 for kept in result.tables["search_lagged_steps"].columns["that_keep_all_bands"])
    settled = result.tables["epochs"].columns["moving_settled_rms_m"]
    assert settled[-1] < 0.05 * settled[0]


def test_what_overflows_leaves_the_figure(result, redrawn):
    columns = result.tables["curves"].columns
    assert columns["moving_published_lagged_m"][-1] != columns["moving_published_lagged_m"][-1]
    assert set(redrawn(result)) == {"hand_distance", "learning"}
