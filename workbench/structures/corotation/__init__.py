"""The co-rotational frame of a two-node planar element, shared by every local law.

A law knows only the deformations against the chord and their conjugate forces; here they become
global forces and tangent, for equilibrium or for an energy-exact step between two states.
"""
