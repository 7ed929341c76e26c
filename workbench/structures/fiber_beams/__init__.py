"""Co-rotational Bernoulli beams with fiber sections: all elements of a structure in one group."""

from workbench.structures.fiber_beams.group import FiberBeams, gauss_rule, radau_rule

__all__ = ["FiberBeams", "gauss_rule", "radau_rule"]
