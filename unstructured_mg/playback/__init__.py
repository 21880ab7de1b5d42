"""A path in the graph to posed, textured frames, and what is made of them: exports, renderings, the report."""
