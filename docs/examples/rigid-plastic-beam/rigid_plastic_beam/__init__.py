"""A clamped beam that a mass strikes: a model of the workbench, and a study of how far it holds."""
