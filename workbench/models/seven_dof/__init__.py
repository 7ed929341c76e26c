"""Seven-degree-of-freedom column, hit from any side: two rigid bars with hinges in space."""

from workbench.models.seven_dof.model import SevenDof as SevenDof
