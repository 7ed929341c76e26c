"""The impact integrator and its contact law.

`integrator` follows every model, by Newton's method in `newton`; `contact` and `pace` hold its law
and constants.
"""

from workbench.mechanics.impact.contact import contact_loss as contact_loss
from workbench.mechanics.impact.contact import explicit_percussion as explicit_percussion
from workbench.mechanics.impact.contact import rebound as rebound
