"""Frames on disk to a Capture: clips of textured meshes in metres, z up, floor at 0; and the procedural capture."""
