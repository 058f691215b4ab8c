"""The study of other starts, goals, durations and boxes, quickly."""

import pytest

from drake_blfdmp.evaluation.study import StudyContext
from drake_blfdmp.evaluation.study_runner import FindStudies, LoadStudy
from drake_blfdmp.planning.scenario import LoadScenario


@pytest.fixture(scope="module")
def script(command_line):
    return FindStudies(command_line.ROOT / "studies")["generalisation"]


@pytest.fixture(scope="module")
def study(script):
    context = StudyContext(LoadScenario(script.scenario), True, lambda what, share: None, None, 1)
    return LoadStudy(script)(context)


@pytest.fixture(scope="module")
def rows(study):
    table = study.tables["cases"]
    return {row[:2]: dict(zip(table.columns, row, strict=True)) for row in table.rows()}


def test_the_default_law_keeps_every_band_and_reaches_what_can_be_reached(rows):
    for (case, law), row in rows.items():
        if law != "default":
            continue
        assert row["left"] == 0 and row["least_margin"] > 0.0, case
        if case in ("unchanged", "goal moved, each point", "goal moves in a circle"):
            assert row["end_hands_max_m"] > 0.01, case
        else:
            assert row["end_hands_max_m"] < 1e-3 and row["end_points_mean_m"] < 1e-3, case


def test_without_coupling_goals_are_reached_and_bands_are_not_kept(rows):
    for (case, law), row in rows.items():
        if law == "none":
            assert row["left"] == row["problems"], case
            assert row["path_max_m"] == 0.0
            if not case.endswith("circle"):
                assert row["end_points_mean_m"] < 1e-3, case


def test_figures_are_drawn_from_their_file(study, redrawn):
    assert set(redrawn(study)) == {"overview", "examples"}


def test_claims_follow_from_the_table(script, study, rows):
    assert study.claims[0].holds is True
    make_claims = LoadStudy(script).__globals__["make_claims"]
    worse = {key: dict(row) for key, row in rows.items()}
    worse["start moved", "default"] |= {"left": 3, "end_hands_max_m": 0.02, "profile_least": 0.2}
    verdicts = [claim.holds for claim in make_claims(worse)]
    assert verdicts[0] is False and verdicts[2] is False and verdicts[5] is False
    assert "3 of" in make_claims(worse)[0].measured
