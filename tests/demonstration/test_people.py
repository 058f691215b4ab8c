import numpy as np
import pytest
from synthetic_carry import carry

from drake_blfdmp.demonstration.people import choose_person
from drake_blfdmp.demonstration.raw_recording import Body
from drake_blfdmp.errors import RecordingError

_, X = carry()
FRAMES = np.arange(len(X))
STILL = np.repeat(X[:1], len(X), axis=0)


def bodies(**people):
    return {name: Body(x, np.arange(len(x))) for name, x in people.items()}


def test_the_one_who_moves_both_hands_most_is_meant():
    waving = STILL.copy()
    waving[:, 2] += np.stack([np.sin(0.3 * FRAMES), 0 * FRAMES, np.cos(0.3 * FRAMES)], axis=-1)  # One hand only.
    chosen = choose_person("a", bodies(bystander=STILL, waver=waving, carrier=X + 2.0))
    assert chosen.name == "carrier"
    assert chosen.evidence.startswith("person: carrier of 3, whose hands move most")
    assert "bystander" in chosen.evidence and "waver" in chosen.evidence


def test_a_jump_is_no_way():
    jumping = STILL + 0.0005 * np.sin(FRAMES)[:, None, None]
    jumping[50, [2, 5]] += 100.0
    assert choose_person("a", bodies(jumping=jumping, carrier=X)).name == "carrier"


def test_who_is_named_is_taken():
    assert choose_person("a", bodies(still=STILL, carrier=X), "still").name == "still"
    with pytest.raises(RecordingError, match=r"^a: holds no person '7'; it has still, carrier$"):
        choose_person("a", bodies(still=STILL, carrier=X), "7")


def test_one_person_needs_no_choice_and_none_is_refused():
    assert choose_person("a", bodies(only=X)).evidence == ""
    with pytest.raises(RecordingError, match="holds no person"):
        choose_person("a", {})


def test_people_who_are_never_seen_or_seen_once_are_no_trouble():
    assert choose_person("a", bodies(empty=X[:0], once=X[:1], unseen=np.full_like(X, np.nan), real=X)).name == "real"
