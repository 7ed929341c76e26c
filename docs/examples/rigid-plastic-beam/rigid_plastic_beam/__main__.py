"""Prints where the study is:   workbench run $(python -m rigid_plastic_beam)."""

from pathlib import Path

print(Path(__file__).with_name("study.py"))
