"""Planar structures: groups of beams and superelements, band assembly, drivers with rollback."""
