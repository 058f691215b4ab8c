import re
from pathlib import Path

from drake_blfdmp.demonstration.formats import FORMATS

PAGE = Path(__file__).resolve().parents[3] / "docs" / "recordings.md"


def test_the_page_names_every_format_and_no_other():
    rows = [line.split("|")[1] for line in PAGE.read_text(encoding="utf-8").splitlines() if line.startswith("| `")]
    assert {name for row in rows for name in re.findall(r"`(\w+)`", row)} == set(FORMATS)
