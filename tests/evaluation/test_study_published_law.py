"""The study published_law runs as it stands in its folder, in its quick version."""

import pytest

from drake_blfdmp.evaluation.study import StudyContext
from drake_blfdmp.evaluation.study_runner import FindStudies, LoadStudy
from drake_blfdmp.planning.scenario import LoadScenario


@pytest.fixture(scope="module")
def result(request):
    script = FindStudies(request.config.rootpath / "studies")["published_law"]
    told = []
    context = StudyContext(LoadScenario(script.scenario), True, lambda what, share: told.append(share), None)
    study = LoadStudy(script)(context)
    assert told and all(0.0 <= share <= 1.0 for share in told)
    return study


def test_none_of_the_sentences_holds(result):
    """The five facts, the sign, and the start: each against the paper, and each can turn out otherwise."""
    assert [claim.holds for claim in result.claims] == [False] * 7
    assert "crossed after 0.034 s" in result.claims[1].measured
    assert "200 of 200 random" in result.claims[3].measured


def test_tables_and_figures(result, redrawn):
    crossed = result.tables["crossing"].columns["crossed_at_s"]
    assert crossed[0] < 0.05 and crossed[-1] == float("inf")
    turn = result.tables["turn"].columns
    assert turn["published_rad"][0] < 0.2 * turn["demonstrated_rad"][0] < turn["default_rad"][0]
    assert set(redrawn(result)) == {"facts", "growth"}
