"""The impact laboratory: contact laws, complementarity, integrators, problems with known answers.

The compiled impact models share `restitution`; the laboratory's parts say what they rest on.
"""

from workbench.impact.laws import Penalty as Penalty
from workbench.impact.laws import Restitution as Restitution
from workbench.impact.restitution import collide as collide
from workbench.impact.restitution import contact_loss as contact_loss
from workbench.impact.restitution import explicit_percussion as explicit_percussion
from workbench.impact.restitution import rebound as rebound
from workbench.impact.restitution import touches as touches
