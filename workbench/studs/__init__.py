"""Shear studs."""
