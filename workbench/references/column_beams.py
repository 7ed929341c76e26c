"""A scenario's column as a chain of fiber beams, and what is read off it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from workbench.materials import Steel
from workbench.scenarios import Column
from workbench.sections.shapes import Rectangle
from workbench.structures.assembly import ElementGroup, PlanarAssembly
from workbench.structures.fiber_beams import FiberBeams, FiberSection, radau_rule
from workbench.structures.statics import apply_loads

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
POISSON_RATIO = 0.3
WATCHED = ("base", "hit-below", "hit-above", "head")
SEGMENTS = ("below", "above")


class ColumnElements(ElementGroup, Protocol):
    """What a column reads off its element group, committed and in SI units.

    `crumples`: whether an element means nothing once a plastic hinge has shortened it to nothing.
    """

    lengths: Array
    crumples: bool

    @property
    def local_forces(self) -> Array:
        """N and end moments M1, M2 (elements, 3); internal moments are -M1 and M2."""
        ...

    @property
    def shear_forces(self) -> Array:
        """Shear forces (elements,)."""
        ...

    @property
    def shear_strains(self) -> Array:
        """Shear strains (elements,)."""
        ...

    @property
    def elongations(self) -> Array:
        """Changes of length along the axis (elements,)."""
        ...

    def plastic_rotations(self) -> Array:
        """Plastic curvature integrated over each element (elements,)."""
        ...


@dataclass(frozen=True)
class ColumnBeams:
    """The column under its axial load, ready to be hit or pushed.

    `assembly` and its element group `beams`, numbered from base to head; dofs of the hit point
    (along the strike) and of the head (along the axis, upwards); number of the first element
    above the hit point; `shear_yields`, whether the shear force is limited by yielding.
    """

    column: Column
    assembly: PlanarAssembly
    beams: ColumnElements
    hit: int
    head: int
    first_above: int
    shear_yields: bool = False

    def axial_forces(self) -> Array:
        """Axial forces (4,) at the watched sections, tension positive, in N."""
        return np.asarray(self.beams.local_forces[self._watched, 0])

    def moments(self) -> Array:
        """Bending moments (4,) at the watched sections, positive at the base under a strike."""
        local, watched = self.beams.local_forces, self._watched
        return np.array([-local[watched[0], 1], local[watched[1], 2],
                         -local[watched[2], 1], local[watched[3], 2]])  # fmt: skip

    def plastic_rotations(self) -> Array:
        """Plastic curvature integrated over the half segment next to each watched section."""
        rotation = self.beams.plastic_rotations()
        middle = np.cumsum(self.beams.lengths) - 0.5 * self.beams.lengths
        below, above = self.column.length_below, self.column.length_above
        cuts = [0.0, 0.5 * below, below, below + 0.5 * above, below + above]
        halves = np.searchsorted(cuts, middle) - 1
        return np.bincount(halves, weights=rotation, minlength=4).astype(float)

    def shear_forces(self) -> Array:
        """Shear force (2,) of the segments below and above, mean along each, in N."""
        return self._mean(self.beams.shear_forces)

    def shear_strains(self) -> Array:
        """Shear strain (2,) of the segments below and above, mean along each."""
        return self._mean(self.beams.shear_strains)

    def _mean(self, values: Array) -> Array:
        """Means (2,) along both segments of values (elements,)."""
        parts = (slice(0, self.first_above), slice(self.first_above, None))
        lengths = self.beams.lengths
        return np.array([np.average(values[part], weights=lengths[part]) for part in parts])

    def shortening(self) -> float:
        """Movement of the head towards the base since the unloaded state, in m."""
        return -float(self.assembly.displacement[self.head])

    def contraction(self) -> float:
        """Loss of length along the deformed axis, in m."""
        return -float(np.sum(self.beams.elongations))

    def slightest(self) -> float:
        """Least length of an element over its initial length, where that must not vanish."""
        if not self.beams.crumples:
            return 1.0
        return float(np.min(1.0 + self.beams.elongations / self.beams.lengths))

    @property
    def _watched(self) -> list[int]:
        return [0, self.first_above - 1, self.first_above, len(self.beams.lengths) - 1]


def shear_stiffness(column: Column) -> float:
    """Elastic shear stiffness of the column in N: G A_v, with 5/6 of A for a rectangle."""
    section = column.strength_section
    share = 5.0 / 6.0 if isinstance(section.shape, Rectangle) else 1.0
    return share * shear_modulus(column.steel) * section.shear_area


def shear_modulus(steel: Steel) -> float:
    """Shear modulus of steel, in Pa."""
    return steel.elastic_modulus / (2.0 * (1.0 + POISSON_RATIO))


def fiber_section(
    column: Column, layers: int, hardening_ratio: float, shear_flexible: bool
) -> FiberSection:
    """The fibers of the column's strength section with its material and mass.

    Arguments: `layers` over the depth; `hardening_ratio` of the regularising hardening modulus to
    the elastic one; `shear_flexible`, whether the shear area strains elastically.
    """
    steel = column.steel
    section = column.strength_section
    y, area = section.fibers(layers)
    return FiberSection(
        y=y,
        area=area,
        elastic_modulus=steel.elastic_modulus,
        yield_stress=steel.yield_stress,
        hardening_modulus=hardening_ratio * steel.elastic_modulus,
        mass_per_length=column.properties.mass_per_length,
        shear_stiffness=shear_stiffness(column) if shear_flexible else 0.0,
    )


def build_column(
    column: Column,
    section: FiberSection,
    below: Array,
    above: Array,
    *,
    balanced: bool = True,
    lumped: bool = False,
) -> ColumnBeams:
    """The column as fiber beams with supports, head mass and axial load, at rest.

    Arguments: `section` of all elements; element lengths (m) `below` and `above` the hit point;
    `balanced` elements, which sample plasticity at the end nearest to a potential hinge, or the
    classical ones with two Gauss points; `lumped` mass. The restraint spring is unstressed, and a
    fixed head locked, once the axial load is on. Raises `SolverError`.
    """
    lengths = np.concatenate([below, above])
    count = len(lengths)
    nodes = np.stack([np.arange(count), np.arange(1, count + 1)], axis=1)
    height = np.concatenate([[0.0], np.cumsum(lengths)])
    rule = radau_rule(np.concatenate([_upper_half(below), _upper_half(above)]))
    beams = FiberBeams(
        nodes,
        np.zeros(count, dtype=np.int64),
        [section],
        rule if balanced else None,
        balanced=balanced,
    )
    return stand_column(column, beams, height, len(below), lumped=lumped)


def stand_column(
    column: Column,
    beams: ColumnElements,
    heights: Array,
    first_above: int,
    *,
    group: ElementGroup | None = None,
    offsets: Array | None = None,
    lumped: bool = False,
    shear_yields: bool = False,
) -> ColumnBeams:
    """A chain of elements with the supports, head mass and axial load of a column, at rest.

    Arguments: `beams`, numbered from base to head; `heights` (m) of their nodes; number of the
    first element above the hit point; `group` that assembles them (None: `beams` itself);
    `offsets` (nodes,) of the nodes along the strike, an initial crookedness, in m; `lumped` mass;
    `shear_yields`, see `ColumnBeams`. Raises `SolverError`.
    """
    count = len(heights) - 1
    offsets = np.zeros_like(heights) if offsets is None else offsets
    group = beams if group is None else group
    assembly = PlanarAssembly(np.stack([heights, offsets], axis=1), [group], lumped=lumped)
    base = ("u", "v") if column.base == "pinned" else ("u", "v", "rotation")
    top = ("v",) if column.head == "pinned" else ("v", "rotation")
    assembly.hold([assembly.dof(0, name) for name in base])
    assembly.hold([assembly.dof(count, name) for name in top])
    head = assembly.dof(count, "u")
    assembly.add_mass(count, column.head_mass)
    assembly.load[head] = -column.axial_load
    if column.axial_load != 0.0:
        apply_loads(assembly)
    if column.head == "fixed":
        assembly.hold([head])
    elif column.restraint_stiffness > 0.0:
        assembly.add_spring(head, column.restraint_stiffness)
    hit = assembly.dof(first_above, "v")
    assembly.assemble(assembly.displacement, None)
    assembly.stored = assembly.account(assembly.displacement, 0.5).stored
    return ColumnBeams(column, assembly, beams, hit, head, first_above, shear_yields)


def _upper_half(lengths: Array) -> NDArray[np.bool_]:
    """Which elements of a segment lie nearer to its end than to its start."""
    return np.asarray(np.cumsum(lengths) - 0.5 * lengths > 0.5 * np.sum(lengths))
