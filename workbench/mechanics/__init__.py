"""Mechanics: the impact integrator, structures of elements, frames."""
