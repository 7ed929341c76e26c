"""Reference solutions: distributed plasticity, with refinement ladders of their own."""
