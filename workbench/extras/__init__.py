"""Companions of the core, which does not know them; they enter by entry points."""
