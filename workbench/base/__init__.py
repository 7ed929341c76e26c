"""Foundations: input checks and messages, units, errors, tables, data files, compiled kernels."""
