"""Transitions to a MotionGraph: strongly connected part, probabilities, paths (P section 7)."""
