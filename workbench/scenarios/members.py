"""What columns and members of frames share: properties, and the ranges of their overrides."""

from dataclasses import dataclass
from typing import Any

from workbench.fields import Number, checked
from workbench.materials import Steel
from workbench.sections import Section

LENGTH = Number(0.02, 100.0, "m", advice="lengths are in metres, not millimetres")
OVERRIDES = {
    "area": Number(1e-6, 2.0, "m2", advice="areas are in m2: 91 cm2 is 91e-4"),
    "second_moment": Number(
        1e-12, 1.0, "m4", advice="second moments are in m4: 8091 cm4 is 8091e-8"
    ),
    "plastic_moment": Number(1.0, 1e9, "N m"),
    "squash_load": Number(1.0, 1e10, "N"),
    "mass_per_length": Number(0.01, 1e5, "kg/m"),
}


def override(name: str) -> Any:
    """The field of a part that overrides what its section gives, None unless given."""
    return checked(OVERRIDES[name], optional=True)


@dataclass(frozen=True)
class MemberProperties:
    """What lumped models need of a member, section values with the scenario's overrides (SI).

    `area` (m2) and `second_moment` (m4) are elastic; `plastic_moment` (N m), `squash_load` (N)
    and `shear_resistance` (N) are strengths; `mass_per_length` in kg/m, `impact_mass` in kg.
    """

    area: float
    second_moment: float
    plastic_moment: float
    squash_load: float
    shear_resistance: float
    mass_per_length: float
    impact_mass: float

    @property
    def strength(self) -> tuple[float, ...]:
        """In tension and compression (N), sagging and hogging (N m): see `Joint.weaker`."""
        return self.squash_load, self.squash_load, self.plastic_moment, self.plastic_moment


def strength_section(section: Section, fillets: bool) -> Section:
    """The section whose fibers and envelope give the strength: plates only unless `fillets`."""
    return section if fillets else section.without_fillets()


def member_properties(part: Any, steel: Steel, length: float, fillets: bool) -> MemberProperties:
    """Properties of a column or member `part` of `length` (m), by its section and its overrides.

    Stiffness and mass are those of the whole profile, the strength leaves the root fillets out
    unless `fillets`; the impact mass is rho A L / 3 (Heng 2017, section 5.2).
    """
    strength = strength_section(part.section, fillets)

    def given(name: str, computed: float) -> float:
        override: float | None = getattr(part, name, None)
        return computed if override is None else override

    area = given("area", part.section.area)
    mass = given("mass_per_length", steel.density * area)
    return MemberProperties(
        area=area,
        second_moment=given("second_moment", part.section.second_moment),
        plastic_moment=given("plastic_moment", strength.plastic_moment(steel)),
        squash_load=given("squash_load", strength.squash_load(steel)),
        shear_resistance=strength.shear_resistance(steel),
        mass_per_length=mass,
        impact_mass=given("impact_mass", mass * length / 3.0),
    )
