"""Reduced models, a file or folder each; what they share: `base`, `domain`, `resistance`."""
