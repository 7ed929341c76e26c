"""The co-rotational frame of a two-node planar element, shared by every local law.

A local law knows only the deformations (elongation, rotation of end 1, rotation of end 2)
against the chord and their conjugate forces. This package turns them into the six global
forces and the tangent, once for equilibrium at the end of a step (`end_gradients`) and once for
an energy-exact step between two states (`step_gradients`): the two differ only in the
gradients of chord length and chord angle that they use.
"""
