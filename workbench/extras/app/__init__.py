"""Page in a browser: a structure at the left, its answers at the right; tests on studs below."""
