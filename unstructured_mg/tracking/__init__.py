"""One candidate pair to a TrackedPair: one template surface and tet cage fitted to both windows (P section 5)."""
