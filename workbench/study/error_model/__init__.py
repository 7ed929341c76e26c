"""Data with provenance: the catalogue, and published numbers as a model."""

from workbench.base.catalogue import Dataset, check, dataset, datasets, load

__all__ = ["Dataset", "check", "dataset", "datasets", "load"]
