"""A study's file, written and read back."""

import pytest

from drake_blfdmp.evaluation.study_file import write_study
from drake_blfdmp.planning.scenario import Scenario
from drake_blfdmp.viewing import style
from drake_blfdmp.viewing.drawing import Drawing, stems
from drake_blfdmp.viewing.redrawing import read_study


@pytest.fixture(scope="session")
def redrawn(tmp_path_factory):
    """A function that gives a study's figures as drawn from its file; they look as those drawn from the study itself.

    What was read, written once more, gives the same bytes: nothing was lost on the way.
    """

    def draw(study):
        folder = tmp_path_factory.mktemp("kept")
        write_study(folder / "study.mcap", study, Scenario(), {"name": "kept"})
        attachments, figures = read_study(folder / "study.mcap").attachments, {}
        assert stems(attachments) == list(study.figures)
        for stem, drawing in study.figures.items():
            kept = Drawing.of(stem, attachments)
            assert kept.make is drawing.make
            again = {name: data for name, (data, _) in kept.attachments(stem).items()}
            assert again == {name: attachments[name] for name in again}
            figures[stem] = kept.figure()
            ours, theirs = folder / f"{stem}.svg", folder / f"{stem}-kept.svg"
            style.save(drawing.figure(), ours)
            style.save(figures[stem], theirs)
            assert ours.read_bytes() == theirs.read_bytes(), stem
        return figures

    return draw
