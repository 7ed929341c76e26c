"""Tables of tests from elsewhere into the user's own data, checked before anything is written."""

from workbench.extras.intake.add import add_table as add_table
from workbench.extras.intake.kinds import check_file as check_file
from workbench.extras.intake.kinds import problems_of_own as problems_of_own
