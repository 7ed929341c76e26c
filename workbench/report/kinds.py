"""Kinds of figures, known without the libraries that draw them."""

from __future__ import annotations

from workbench.errors import InputError

# kind -> module of `workbench.report.figures`; each has a function draw(request) -> Drawing
KINDS = {
    "structure": "structure",
    "deformed": "deformed",
    "animation": "animation",
    "history": "history",
    "force-displacement": "force_displacement",
    "peaks": "peaks",
    "interaction": "interaction",
    "energy": "energy",
    "convergence": "convergence",
    "meshes": "meshes",
    "cost": "cost",
    "sweep": "sweep",
    "shear-domain": "shear_domain",
    "stud-scatter": "stud_scatter",
    "stud-residuals": "stud_residuals",
    "stud-curves": "stud_curves",
    "stud-model": "stud_model",
    "stud-unseen": "stud_unseen",
    "stud-interaction": "stud_interaction",
    "stud-guideline": "stud_guideline",
}


def check_kind(kind: str) -> None:
    """Refuse a kind of figure that nothing draws. Raises `InputError`."""
    if kind not in KINDS:
        raise InputError("figure.kind", kind, "must be one of " + ", ".join(KINDS))
