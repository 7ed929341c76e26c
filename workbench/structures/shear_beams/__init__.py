"""Fibers that yield under normal and shear stress together (webs and solid sections)."""

from workbench.structures.shear_beams.law import ShearYielding

__all__ = ["ShearYielding"]
