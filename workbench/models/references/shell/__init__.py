"""Reference in space: shells that may buckle, twist and leave the plane of the hit."""

from workbench.models.references.shell.model import Shell as Shell
