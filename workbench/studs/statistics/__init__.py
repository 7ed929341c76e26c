"""Statistics of tests: fractiles, EN 1990 D.8, EN 1994 B.2, mixed models, intervals."""
