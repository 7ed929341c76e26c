"""Steel-impact validation workbench: how far can each reduced model be trusted?"""

__version__ = "0.1.0"
