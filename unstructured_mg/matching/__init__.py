"""Capture to descriptors, to windowed dissimilarities and best yaws, to ranked candidate pairs (P section 4, A.1)."""
