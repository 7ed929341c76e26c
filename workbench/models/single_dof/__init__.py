"""Single-degree-of-freedom column (Heng 2017, section 5.2; Paper II of the thesis)."""

from workbench.models.single_dof.model import SingleDof as SingleDof
