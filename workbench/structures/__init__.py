"""Planar structures: co-rotational elements, band assembly, drivers with commit and rollback."""
