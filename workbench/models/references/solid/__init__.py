"""Reference beyond beam theory: the column as a plane-stress continuum, on scikit-fem."""

from workbench.models.references.solid.model import SolidPlaneStress as SolidPlaneStress
