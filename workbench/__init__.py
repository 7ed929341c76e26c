"""Steel-impact validation workbench: how far each reduced model can be trusted, at what cost."""

__version__ = "0.1.0"
