"""Laboratory of integrators: schemes and laws on bench problems, a column and a frame."""
