"""Made files that several tests look at."""

import pytest
from made_files import poke


@pytest.fixture(scope="session")
def poked(tmp_path_factory):
    """A small file with everything that a run's has."""
    return poke(tmp_path_factory.mktemp("poke") / "poke.mcap")
