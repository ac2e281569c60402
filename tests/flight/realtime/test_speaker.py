"""One sender is listened to, another one once it is silent."""

from __future__ import annotations

from skylimb.flight.realtime.speaker import SILENT, Speaker


def test_another_sender_is_heard_once_the_first_is_silent() -> None:
    speaker = Speaker().after("first", 0.0)
    assert speaker.hears("first", 10.0)
    assert not speaker.hears("second", SILENT)
    assert speaker.hears("second", SILENT + 0.001)
    speaker = speaker.after("second", 1.0)
    assert not speaker.hears("first", 1.0)
    assert (speaker.turns, speaker.changes) == (2, 1)


def test_the_same_sender_begins_anew_after_a_silence() -> None:
    speaker = Speaker().after("first", 0.0).after("first", 0.1)
    assert (speaker.turns, speaker.changes) == (1, 0)
    speaker = speaker.after("first", 0.1 + 2.0 * SILENT)
    assert (speaker.turns, speaker.changes) == (2, 0)
