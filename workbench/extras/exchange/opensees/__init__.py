"""OpenSees: a model that runs it, and scripts for it."""
