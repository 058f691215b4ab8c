"""Where the models are, and how a parser finds them."""

from pathlib import Path

from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant

from drake_blfdmp.errors import TaskError

PACKAGE_NAME = "blfdmp_models"


def ModelsDirectory() -> Path:
    """The directory of the robot's models: beside the package in a checkout, `drake_blfdmp/_models` in a wheel.

    Raises:
        TaskError: neither exists; the installation is broken.
    """
    package = Path(__file__).resolve().parents[1]
    candidates = (package / "_models", package.parent / "models")
    for directory in candidates:
        if (directory / "dual_panda.dmd.yaml").is_file():
            return directory
    searched = ", ".join(str(c) for c in candidates)
    raise TaskError(f"the robot's models are missing (searched {searched}): reinstall drake_blfdmp")


def MakeParser(plant: MultibodyPlant) -> Parser:
    """A parser of `plant` that resolves `package://blfdmp_models/`."""
    parser = Parser(plant)
    parser.package_map().Add(PACKAGE_NAME, ModelsDirectory())
    return parser
