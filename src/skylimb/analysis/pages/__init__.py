"""HTML pages that stand alone: one base with the style, which every page of the package extends."""
