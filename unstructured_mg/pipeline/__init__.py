"""Runs the rooms in order over a work folder: stages, store, executor, progress."""
