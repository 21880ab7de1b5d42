"""One TrackedPair to two Transitions: blended geometry, flowing texture, quality card (P section 6)."""
