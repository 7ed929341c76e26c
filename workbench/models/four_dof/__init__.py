"""Four-degree-of-freedom column (Heng 2017, section 5.1; Paper I of the thesis)."""

from workbench.models.four_dof.model import FourDof as FourDof
from workbench.models.four_dof.model import FourDofShear as FourDofShear
