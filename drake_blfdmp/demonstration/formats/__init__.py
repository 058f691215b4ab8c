"""Readers of recordings: one file a format, one registry, one way in (`read_recording`)."""

from drake_blfdmp.demonstration.formats.interpretation import ReadOptions
from drake_blfdmp.demonstration.formats.reading import FORMATS, read_recording
from drake_blfdmp.demonstration.formats.recording_format import RecordingFormat

__all__ = ["FORMATS", "ReadOptions", "RecordingFormat", "read_recording"]
