"""Equivalent single degrees of freedom by Biggs: shapes of deflection, integrated.

A member moves as y(x, t) = u(t) phi(x), phi the shape that its load makes statically, 1 at a point
of reference (Heng 2017, equations 4.1 to 4.6; Biggs 1964, chapter 5). Equal kinetic energy and
equal work give the factors

    K_M = (1/L) integral phi^2 dx,   K_L = sum(f_i phi_i) + (1 - sum(f_i)) (1/L) integral phi dx,

f_i the shares of the load that are forces and the rest a line load, so that with K_LM = K_M / K_L
K_LM M u'' + R(u) = F(t), M the mass and F the load of the whole member and R its resistance to that
load. Hinges form one after the other; each stage has its own shape. Elements between nodes are
exact: cubics, and the quartic of a line load.
"""

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from workbench.base.arrays import Array
from workbench.base.fields import Choice
from workbench.scenarios import Column

_POINT, _WEIGHT = np.polynomial.legendre.leggauss(5)  # exact up to the ninth degree
_POINT, _WEIGHT = 0.5 * (1.0 + _POINT), 0.5 * _WEIGHT
NONE, LINEAR, SECTION = "none", "linear", "section"
AXIAL = Choice((NONE, LINEAR, SECTION))
AXIAL_HELP = "how the axial load lowers M_p: linear, M_p (1 - n), or by the envelope of the section"
_TOGETHER = 1e-9  # hinges that yield within this share of a load yield at once


class Shape(NamedTuple):
    """A shape of deflection: `nodes` (n,) in m, and in each element between them a polynomial.

    `coefficients` (n - 1, 5) in xi from 0 to 1; the deflection is 1 at the point of reference.
    """

    nodes: Array
    coefficients: Array

    def _at_points(self, derivative: int = 0) -> tuple[Array, Array, Array]:
        """Places (m), values and weights (m) at the points of integration, [elements, points]."""
        lengths = np.diff(self.nodes)[:, None]
        c = self.coefficients
        for _ in range(derivative):
            c = np.polynomial.polynomial.polyder(c, axis=1) / lengths
        values = np.polynomial.polynomial.polyval(_POINT, c.T)
        return self.nodes[:-1, None] + lengths * _POINT, np.asarray(values), lengths * _WEIGHT

    @property
    def mass_factor(self) -> float:
        """K_M of a uniform mass."""
        _, value, weight = self._at_points()
        return float(np.sum(weight * value**2) / (self.nodes[-1] - self.nodes[0]))

    def momentum(self, other: "Shape") -> float:
        """Momentum of a uniform mass of 1 that moves in this shape, in the `other` one."""
        _, value, weight = self._at_points()
        moved = weight * value * other._at_points()[1]
        return float(np.sum(moved) / (self.nodes[-1] - self.nodes[0]))

    @property
    def mean(self) -> float:
        """K_L of a line load: mean of the deflection."""
        _, value, weight = self._at_points()
        return float(np.sum(weight * value) / (self.nodes[-1] - self.nodes[0]))

    @property
    def stretching(self) -> float:
        """Half the integral of phi'^2 (1/m): elongation of the chord per squared displacement."""
        _, slope, weight = self._at_points(1)
        return float(0.5 * np.sum(weight * slope**2))

    def inertia(self, first: int, last: int) -> tuple[float, float]:
        """Integral of phi between two nodes, in m, and the place (m) of its resultant."""
        at, value, weight = (each[first:last] for each in self._at_points())
        total = float(np.sum(weight * value))
        return total, float(np.sum(weight * value * at)) / total


class Stage(NamedTuple):
    """A stage of the resistance: from which displacement (m) and load (N) on, and its `stiffness`.

    `shape` of deflection; `load_factor` K_L and `mass_factor` K_M; `moments` (nodes,) in N m at its
    start, sagging positive, and their growth `rates` (nodes,) per load, in m; the nodes of its
    `hinges`.
    """

    start: float
    load: float
    stiffness: float
    shape: Shape
    load_factor: float
    mass_factor: float
    moments: Array
    rates: Array
    hinges: frozenset[int]

    @property
    def load_mass_factor(self) -> float:
        """K_LM = K_M / K_L."""
        return self.mass_factor / self.load_factor


class Beam(NamedTuple):
    """A member under a load of 1 in all.

    Arguments: places of `nodes` (m), its ends and where forces act or hinges may form; whether both
    ends are `clamped`; shares of the load that are `forces` at the nodes between, the rest is a
    line load; `bending` stiffness EI (N m2); number of the node of `reference`.
    """

    nodes: tuple[float, ...]
    clamped: tuple[bool, bool]
    forces: tuple[float, ...]
    bending: float
    reference: int = 1

    @property
    def line(self) -> float:
        """Line load per metre, of a load of 1."""
        return (1.0 - sum(self.forces)) / (self.nodes[-1] - self.nodes[0])

    def stages(self, capacities: Array) -> tuple[Stage, ...]:
        """Stages of the resistance up to the mechanism; `capacities` (nodes,) of moments in N m.

        The mechanism turns about its ends: straight bars between nodes that move alike.
        """
        last = len(self.nodes) - 1
        ends = {end for end, held in zip((0, last), self.clamped, strict=True) if held}
        places = ends | set(range(1, last))
        hinges: set[int] = set()
        v = load = 0.0
        moments = np.zeros(last + 1)
        reached = []
        while not (ends <= hinges and hinges - ends):
            deflection, rates = self._solve(hinges)
            compliance = float(deflection[self.reference, 0])
            reached.append(
                self._stage((v, load, 1.0 / compliance), deflection, moments, rates, hinges)
            )
            left = {i: (capacities[i] - abs(moments[i])) / abs(rates[i]) for i in places - hinges}
            step = min(left.values())
            load, v = load + step, v + step * compliance
            moments = moments + step * rates
            hinges |= {i for i, each in left.items() if each <= step + _TOGETHER * load}
        straight = np.zeros((last, 5))
        heights = np.array([0.0, *(1.0 for _ in range(1, last)), 0.0])
        straight[:, 0], straight[:, 1] = heights[:-1], np.diff(heights)
        reached.append(self._stage((v, load, 0.0), straight, moments, np.zeros(last + 1), hinges))
        return tuple(reached)

    def _stage(
        self,
        start: tuple[float, float, float],
        deflection: Array,
        moments: Array,
        rates: Array,
        hinges: set[int],
    ) -> Stage:
        shape = Shape(np.array(self.nodes), deflection / deflection[self.reference, 0])
        length = self.nodes[-1] - self.nodes[0]
        factor = float(self.forces @ shape.coefficients[1:, 0]) + self.line * length * shape.mean
        mass = shape.mass_factor
        return Stage(*start, shape, factor, mass, moments, rates, frozenset(hinges))

    def _solve(self, hinges: set[int]) -> tuple[Array, Array]:
        """Deflection under a load of 1, polynomials [elements, 5], and moments at the nodes."""
        nodes, last = self.nodes, len(self.nodes) - 1
        # dofs: deflections of inner nodes, rotations to the left and to the right of every node
        count = last - 1
        deflection = [-1, *range(count), -1]
        left, right = [-1] * (last + 1), [-1] * (last + 1)
        for i in range(last + 1):
            if i in (0, last):
                if not self.clamped[i > 0] or i in hinges:
                    left[i] = right[i] = count
                    count += 1
                continue
            left[i] = right[i] = count
            count += 1
            if i in hinges:
                right[i] = count
                count += 1
        stiffness, load = np.zeros((count + 1, count + 1)), np.zeros(count + 1)  # last: held
        elements = []
        for e in range(last):
            length = nodes[e + 1] - nodes[e]
            near = np.array([[6.0, 3.0 * length], [3.0 * length, 2.0 * length**2]])
            far = np.array([[-6.0, 3.0 * length], [-3.0 * length, length**2]])
            other = near * np.array([[1.0, -1.0], [-1.0, 1.0]])
            element = np.block([[near, far], [far.T, other]])
            dofs = [deflection[e], right[e], deflection[e + 1], left[e + 1]]
            stiffness[np.ix_(dofs, dofs)] += 2.0 * self.bending / length**3 * element
            shares = np.array([1.0, length / 6.0, 1.0, -length / 6.0])
            load[dofs] += 0.5 * self.line * length * shares
            elements.append((dofs, length))
        for i, share in enumerate(self.forces):
            load[deflection[i + 1]] += share
        moved = np.append(np.linalg.solve(stiffness[:-1, :-1], load[:-1]), 0.0)
        polynomials = np.zeros((last, 5))
        moments = np.zeros(last + 1)
        for e, (dofs, length) in enumerate(elements):
            a, s, b, t = moved[dofs] * np.array([1.0, length, 1.0, length])
            quartic = self.line * length**4 / (24.0 * self.bending)
            square, cubic = 3.0 * (b - a) - 2.0 * s - t, 2.0 * (a - b) + s + t
            polynomials[e] = a, s, square + quartic, cubic - 2.0 * quartic, quartic
            curved = self.bending / length**2
            moments[e] = -curved * 2.0 * polynomials[e, 2]
            moments[e + 1] = -curved * (polynomials[e] @ [0.0, 0.0, 2.0, 6.0, 12.0])
        return polynomials, moments


def beam_of(column: Column, uniform: bool = False) -> Beam:
    """The column as a beam under a force at its hit point, or under a `uniform` line load."""
    return Beam(
        (0.0, column.length_below, column.length),
        (column.base == "clamped", column.head != "pinned"),
        (0.0 if uniform else 1.0,),
        column.steel.elastic_modulus * column.properties.second_moment,
    )


def plastic_moment(column: Column, axial: str) -> float:
    """Plastic moment (N m) of the column beside its axial load, held as it is before the hit.

    `axial`: none, M_p; linear, M_p (1 - n); section, of the exact plastic envelope.
    """
    properties = column.properties
    share = abs(column.axial_load) / properties.squash_load
    if axial == SECTION:
        left = float(np.interp(share, *column.strength_section.interaction_envelope()))
    else:
        left = 1.0 - share if axial == LINEAR else 1.0
    return properties.plastic_moment * left


@lru_cache(maxsize=256)
def stages_of(column: Column, axial: str = SECTION, uniform: bool = False) -> tuple[Stage, ...]:
    """Stages of a column under a force at its hit point, or under a `uniform` line load.

    `axial`, see `plastic_moment`.
    """
    return beam_of(column, uniform).stages(np.full(3, plastic_moment(column, axial)))
