"""Physics baselines: numbers of all models, kept in one table, each with the reason it changed."""
