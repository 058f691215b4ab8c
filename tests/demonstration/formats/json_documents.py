"""What the tests of JSON recordings share: a motion, frames of named points, files, and the errors they give."""

import json

import numpy as np
import pytest
from file_samples import listed
from synthetic_carry import carry

from drake_blfdmp.demonstration.formats import read_recording
from drake_blfdmp.errors import RecordingError
from drake_blfdmp.skeleton import POINTS

T, X = carry(duration=2.0)
HOLES = X.copy()
HOLES[5, 2] = HOLES[9] = np.nan


def said(recording):
    return " | ".join(recording.evidence)


def written(path, document, **options):
    path.write_text(document if isinstance(document, str) else json.dumps(document), **options)
    return path


def check_error(text, path, **options):
    with pytest.raises(RecordingError) as caught:
        read_recording(path, **options)
    assert text in str(caught.value)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)


def frames(x=X, names=POINTS):
    return [dict(zip(names, points, strict=True)) for points in listed(x)]
