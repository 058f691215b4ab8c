"""Trials become rows of a file, whatever happens on the way."""
