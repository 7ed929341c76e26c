"""Column hit by a vehicle that crushes: two masses on two springs (Heng 2017, figure 3.1)."""

from workbench.models.soft_impact.model import SoftImpact as SoftImpact
