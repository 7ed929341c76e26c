"""Compiled loops over the elements of the solid: forces, tangents and energies of a step.

**Second part.** Steel at a point of the solid: polar decomposition, plane-stress return, squeeze
guard.

Compiled, one point at a time. Tensors are (11, 22, 12), strains with the engineering shear 2 e12;
deformation gradients and what derives from them (11, 12, 21, 22).
Source: Simo and Hughes 1998, section 3.4.

**Third part.** The discretised column with its state, as the drivers of structures see it.
"""

from typing import NamedTuple

import numpy as np
from scipy.sparse import coo_array, csc_array, diags_array
from scipy.sparse.linalg import splu

from workbench.base.arrays import Array, Indices
from workbench.base.compiled import njit
from workbench.base.errors import SolverError
from workbench.mechanics.structures.elements import StepEnergies
from workbench.models.references.solid.mesh import SolidMesh, Supports, solid_mesh, supports_of
from workbench.scenarios import Column
from workbench.steel.materials import POISSON_RATIO, CowperSymonds, Steel

RETURN_ITERATIONS = 50
CLOSED = 2e-15  # of the yield stress: round-off; the iteration comes from below
SQUEEZED = 0.2  # share of its area below which a point resists being squeezed to nothing
SQUEEZE_STIFFNESS = 0.002  # over Young's modulus


class SolidSteel(NamedTuple):
    """Young's modulus (Pa), Poisson's ratio, yield stress and isotropic hardening modulus (Pa).

    Of a step with strain rate: `reference_flow` D dt, equivalent plastic strain at which the
    overstress is the yield stress, infinite without a rate; `exponent` q of the law.
    """

    modulus: float
    poisson: float
    yield_stress: float
    hardening: float
    reference_flow: float = np.inf
    exponent: float = 1.0


class Tensor(NamedTuple):
    """Stress (Pa), or strain with the engineering shear."""

    t11: float
    t22: float
    t12: float


class Stretched(NamedTuple):
    """F = R U in the plane.

    Biot `strain` U - I; `cosine` and `sine` of the rotation; the `trace` of U; the `area` ratio
    det F.
    """

    strain: Tensor
    cosine: float
    sine: float
    trace: float
    area: float


class Returned(NamedTuple):
    """Result of the return mapping.

    `stress`; multiplier `gamma`, 0 where elastic, NaN where the iteration does not converge; the
    step of plastic strain `flow` and the equivalent plastic strain `hardened` at its end.
    """

    stress: Tensor
    gamma: float
    flow: Tensor
    hardened: float


@njit(cache=True, error_model="numpy")
def stretched(f11: float, f12: float, f21: float, f22: float) -> Stretched:
    """Polar decomposition of a deformation gradient."""
    a, b = f11 + f22, f21 - f12
    trace = np.sqrt(a * a + b * b)
    c, s = a / trace, b / trace
    u11, u22, u12 = c * f11 + s * f21, c * f22 - s * f12, c * f12 + s * f22
    area = f11 * f22 - f12 * f21
    return Stretched(Tensor(u11 - 1.0, u22 - 1.0, 2.0 * u12), c, s, trace, area)


@njit(cache=True, error_model="numpy")
def von_mises_squared(stress: Tensor) -> float:
    """Square of the equivalent stress in plane stress."""
    t1, t2, t3 = stress
    return t1**2 - t1 * t2 + t2**2 + 3.0 * t3**2


@njit(cache=True, error_model="numpy")
def _multiplier(a: float, b: float, strength: float, k1: float, k2: float, H: float) -> float:
    """Multiplier of the return to a surface of that `strength` and hardening; NaN: none found.

    The square of the equivalent stress is a / (1 + k1 gamma)^2 + b / (1 + k2 gamma)^2.
    """
    gamma = 0.0
    # strength / stress(gamma) - 1 + 2/3 H gamma is concave and rises: Newton from 0 is safe
    for _ in range(RETURN_ITERATIONS):
        l1, l2 = 1.0 + k1 * gamma, 1.0 + k2 * gamma
        square = a / l1**2 + b / l2**2
        value = strength / np.sqrt(square) - 1.0 + 2.0 / 3.0 * H * gamma
        if value > -CLOSED:
            return gamma
        slope = strength * (a * k1 / l1**3 + b * k2 / l2**3) / square**1.5 + 2.0 / 3.0 * H
        gamma -= value / slope
    return np.nan


@njit(cache=True, error_model="numpy")
def _overstress(
    a: float, b: float, strength: float, k1: float, k2: float, steel: SolidSteel
) -> float:
    """Overstress x over the yield stress at the end of a step; NaN where none is found.

    p(x), the plastic strain of the return to the surface grown by it, is D dt x^q: the difference
    falls and is concave but for round-off, so that Newton comes down from an upper bound.
    """
    fy, H, flow, q = steel.yield_stress, steel.hardening, steel.reference_flow, steel.exponent
    x = (np.sqrt(a + b) - strength) / fy
    for k in range(RETURN_ITERATIONS):
        gamma = _multiplier(a, b, strength + (fy * x if k else 0.0), k1, k2, H)
        l1, l2 = 1.0 + k1 * gamma, 1.0 + k2 * gamma
        stress = np.sqrt(a / l1**2 + b / l2**2)
        p = 2.0 / 3.0 * gamma * stress
        if k == 0:  # without any overstress: the largest plastic strain
            x = min(x, (p / flow) ** (1.0 / q))
            continue
        fall = (a * k1 / l1**3 + b * k2 / l2**3) / stress  # - d stress / d gamma
        growth = 2.0 / 3.0 * (stress / fall - gamma)  # - dp / d stress
        step = (p - flow * x**q) / (growth * fy / (1.0 + H * growth) + q * flow * x ** (q - 1.0))
        x = max(x + step, 0.0)
        if abs(step) <= 4.0 * CLOSED * (1.0 + x):
            return float(x)
    return np.nan


@njit(cache=True, error_model="numpy")
def return_mapping(elastic: Tensor, hardened: float, steel: SolidSteel) -> Returned:
    """Simo-Taylor return to the von Mises yield surface in plane stress, grown by strain rate.

    Arguments: strain less the plastic strain at the start, `elastic`; equivalent plastic strain
    `hardened` at the start; `steel`. With a rate the strength is fy (1 + x) + H times the
    equivalent plastic strain, x = (p / D dt)^(1/q) by that of the step, p: Perzyna's form of the
    law of Cowper and Symonds, backward Euler.
    """
    E, nu, fy, H = steel.modulus, steel.poisson, steel.yield_stress, steel.hardening
    e1, e2, e3 = elastic
    double_shear, bulk = E / (1.0 + nu), E / (1.0 - nu)
    # eigenvectors of elasticity and of the yield function: (1, 1, 0), (-1, 1, 0), (0, 0, 1)
    eta1, eta2, shear = bulk * (e1 + e2), double_shear * (e2 - e1), 0.5 * double_shear * e3
    a, b = 0.25 * eta1**2, 0.75 * eta2**2 + 3.0 * shear**2
    strength = fy + H * hardened
    k1, k2 = bulk / 3.0, double_shear
    if steel.reference_flow < np.inf and a + b > strength**2:
        strength += fy * _overstress(a, b, strength, k1, k2, steel)
    gamma = _multiplier(a, b, strength, k1, k2, H)
    eta1, eta2 = eta1 / (1.0 + k1 * gamma), eta2 / (1.0 + k2 * gamma)
    shear /= 1.0 + k2 * gamma
    stress = Tensor(0.5 * (eta1 - eta2), 0.5 * (eta1 + eta2), shear)
    n1, n2, n3 = normal(stress)
    flow = Tensor(gamma * n1, gamma * n2, gamma * n3)
    hardened += 2.0 / 3.0 * gamma * np.sqrt(von_mises_squared(stress))
    return Returned(stress, gamma, flow, hardened)


@njit(cache=True, error_model="numpy")
def normal(stress: Tensor) -> Tensor:
    """Direction of plastic flow: derivative of half the square of the equivalent stress by 2/3."""
    t1, t2, t3 = stress
    return Tensor((2.0 * t1 - t2) / 3.0, (2.0 * t2 - t1) / 3.0, 2.0 * t3)


@njit(cache=True, error_model="numpy")
def add_return_tangent(back: Returned, steel: SolidSteel, C: Array) -> None:
    """Add the consistent tangent of a return without strain rate to C (3, 3)."""
    E, nu, H = steel.modulus, steel.poisson, steel.hardening
    gamma = back.gamma
    double_shear, bulk = E / (1.0 + nu), E / (1.0 - nu)
    x1 = bulk / (1.0 + bulk / 3.0 * gamma)
    x2 = double_shear / (1.0 + double_shear * gamma)
    C[0, 0] += 0.5 * (x1 + x2)
    C[1, 1] += 0.5 * (x1 + x2)
    C[0, 1] += 0.5 * (x1 - x2)
    C[1, 0] += 0.5 * (x1 - x2)
    C[2, 2] += 0.5 * x2
    if gamma == 0.0:
        return
    n1, n2, n3 = normal(back.stress)
    m = (
        0.5 * (x1 + x2) * n1 + 0.5 * (x1 - x2) * n2,
        0.5 * (x1 - x2) * n1 + 0.5 * (x1 + x2) * n2,
        0.5 * x2 * n3,
    )
    square = von_mises_squared(back.stress)
    softening = 4.0 / 9.0 * H * square / (1.0 - 2.0 / 3.0 * H * gamma)
    scale = 1.0 / (n1 * m[0] + n2 * m[1] + n3 * m[2] + softening)
    for i in range(3):
        for j in range(3):
            C[i, j] -= scale * m[i] * m[j]


@njit(cache=True, error_model="numpy")
def squeeze(stretch: Stretched, modulus: float) -> Tensor:
    """Stress of the guard k/2 <ln(SQUEEZED / J)>^2, J = det F.

    Perfect plasticity in nominal stress lets a singular corner shrink to no volume at all; the
    guard acts below J = SQUEEZED only.
    """
    e1, e2, e3 = stretch.strain
    pressure = SQUEEZE_STIFFNESS * modulus * np.log(SQUEEZED / stretch.area) / stretch.area
    # derivatives of J = U11 U22 - U12^2 by (U11, U22, 2 U12)
    return Tensor(-pressure * (1.0 + e2), -pressure * (1.0 + e1), 0.5 * pressure * e3)


@njit(cache=True, error_model="numpy")
def add_squeeze_tangent(stretch: Stretched, modulus: float, C: Array) -> None:
    """Add the tangent of the squeeze guard to C (3, 3)."""
    e1, e2, e3 = stretch.strain
    k, logarithm = SQUEEZE_STIFFNESS * modulus, np.log(SQUEEZED / stretch.area)
    j = (1.0 + e2, 1.0 + e1, -0.5 * e3)
    for i in range(3):
        for n in range(3):
            C[i, n] += k * (1.0 + logarithm) / stretch.area**2 * j[i] * j[n]
    pressure = k * logarithm / stretch.area
    C[0, 1] -= pressure
    C[1, 0] -= pressure
    C[2, 2] += 0.5 * pressure


@njit(cache=True, error_model="numpy")
def nominal_stress(stretch: Stretched, stress: Tensor) -> tuple[float, float, float, float]:
    """Nominal stress (11, 12, 21, 22), conjugate to F, of the Biot stress conjugate to U."""
    c, s = stretch.cosine, stretch.sine
    e1, e2, e3 = stretch.strain
    t1, t2, t3 = stress
    lever = (0.5 * (t1 - t2) * e3 + t3 * (e2 - e1)) / stretch.trace
    return (
        c * t1 - s * t3 - lever * s,
        c * t3 - s * t2 - lever * c,
        s * t1 + c * t3 + lever * c,
        s * t3 + c * t2 - lever * s,
    )


@njit(cache=True, error_model="numpy")
def nominal_tangent(stretch: Stretched, stress: Tensor, C: Array, D: Array, K: Array) -> None:
    """Derivative K (4, 4) of the nominal stress by F.

    Arguments: tangent C (3, 3) of the Biot stress by the strain; D (3, 4), room for the derivative
    of the strain by F.
    """
    c, s = stretch.cosine, stretch.sine
    e1, e2, e3 = stretch.strain
    t1, t2, t3 = stress
    turn = (-s / stretch.trace, -c / stretch.trace, c / stretch.trace, -s / stretch.trace)
    fixed = ((c, 0.0, s, 0.0), (0.0, -s, 0.0, c), (-s, c, c, s))
    half, apart = 0.5 * (t1 - t2), e2 - e1
    lever = (half * e3 + t3 * apart) / stretch.trace
    stiffening = 0.5 * stretch.trace * (t1 + t2) + half * apart - t3 * e3
    along, across, rest = (-s, c, c, s), (-c, -s, -s, c), (c, -s, s, c)
    for i in range(4):
        D[0, i] = fixed[0][i] + 0.5 * e3 * turn[i]
        D[1, i] = fixed[1][i] - 0.5 * e3 * turn[i]
        D[2, i] = fixed[2][i] + apart * turn[i]
    for i in range(4):
        # due to turning, sum_k T_k d2U_k / dF2
        turning_i = half * along[i] + t3 * across[i] + 0.5 * stiffening * turn[i] - lever * rest[i]
        for j in range(4):
            turning_j = half * along[j] + t3 * across[j] + 0.5 * stiffening * turn[j]
            turning_j -= lever * rest[j]
            K[i, j] = turning_i * turn[j] + turn[i] * turning_j
            for k in range(3):
                for n in range(3):
                    K[i, j] += D[k, i] * C[k, n] * D[n, j]


class Elements(NamedTuple):
    """Nine-node quadrilaterals.

    `gradients` (elements, points, 2, nodes) of the shape functions by x and y, in 1/m; `weights`
    (elements, points), thickness times area, in m3; `dofs` (elements, 2 nodes), x and y in turn.
    """

    gradients: Array
    weights: Array
    dofs: Indices


class PointStates(NamedTuple):
    """State of the points.

    `plastic` strain (elements, points, 3), equivalent plastic strain `hardened` (elements, points),
    Biot `stress` without squeeze guard (Pa) and `strain`, both as `plastic`.
    """

    plastic: Array
    hardened: Array
    stress: Array
    strain: Array


class Energies(NamedTuple):
    """Elastic energy at the end of a step and plastic work of the step, both in J.

    The plastic work takes the mean of the stresses at both ends. NaN where a point has no answer:
    it is turned inside out, or its return does not converge.
    """

    stored: float
    plastic: float


def empty_state(elements: Elements) -> PointStates:
    """Points that nothing has happened to."""
    tensor = (*elements.weights.shape, 3)
    return PointStates(
        np.zeros(tensor), np.zeros(elements.weights.shape), np.zeros(tensor), np.zeros(tensor)
    )


@njit(cache=True, error_model="numpy")
def respond(
    elements: Elements,
    u: Array,
    old: PointStates,
    new: PointStates,
    steel: SolidSteel,
    force: Array,
    matrices: Array,
) -> Energies:
    """Add the nodal forces of all elements to `force` (dofs,) and keep the trial state in `new`.

    Arguments: displacements `u` (dofs,) in m; committed state `old`; `matrices` (elements, dofs of
    one, dofs of one) for the tangents, empty where they are of no interest.
    """
    gradients, weights, dofs = elements
    nodes = gradients.shape[3]
    tangents = len(matrices) > 0
    moved, nodal = np.empty(2 * nodes), np.empty(2 * nodes)
    C, D, K = np.empty((3, 3)), np.empty((3, 4)), np.empty((4, 4))
    stored = plastic = 0.0
    for e in range(len(weights)):
        for a in range(2 * nodes):
            moved[a] = u[dofs[e, a]]
            nodal[a] = 0.0
        if tangents:
            matrices[e] = 0.0
        for g in range(weights.shape[1]):
            slope = gradients[e, g]
            f11, f12, f21, f22 = 1.0, 0.0, 0.0, 1.0
            for a in range(nodes):
                f11 += slope[0, a] * moved[2 * a]
                f12 += slope[1, a] * moved[2 * a]
                f21 += slope[0, a] * moved[2 * a + 1]
                f22 += slope[1, a] * moved[2 * a + 1]
            stretch = stretched(f11, f12, f21, f22)
            if not (stretch.trace > 0.0 and stretch.area > 0.0):
                return Energies(np.nan, np.nan)
            e1, e2, e3 = stretch.strain
            p1, p2, p3 = old.plastic[e, g]
            elastic = Tensor(e1 - p1, e2 - p2, e3 - p3)
            back = return_mapping(elastic, old.hardened[e, g], steel)
            if not np.isfinite(back.hardened):
                return Energies(np.nan, np.nan)
            weight = weights[e, g]
            t1, t2, t3 = back.stress
            d1, d2, d3 = back.flow
            before = old.stress[e, g]
            work = (before[0] + t1) * d1 + (before[1] + t2) * d2 + (before[2] + t3) * d3
            plastic += 0.5 * weight * work
            density = t1**2 + t2**2 - 2.0 * steel.poisson * t1 * t2
            density = (0.5 * density + (1.0 + steel.poisson) * t3**2) / steel.modulus
            keep(new, e, g, stretch.strain, back.stress, Tensor(p1 + d1, p2 + d2, p3 + d3))
            new.hardened[e, g] = back.hardened
            stress = back.stress
            squeezed = stretch.area < SQUEEZED
            if squeezed:
                s1, s2, s3 = squeeze(stretch, steel.modulus)
                stress = Tensor(t1 + s1, t2 + s2, t3 + s3)
                logarithm = np.log(SQUEEZED / stretch.area)
                density += 0.5 * SQUEEZE_STIFFNESS * steel.modulus * logarithm**2
            stored += weight * density
            n11, n12, n21, n22 = nominal_stress(stretch, stress)
            for a in range(nodes):
                nodal[2 * a] += weight * (n11 * slope[0, a] + n12 * slope[1, a])
                nodal[2 * a + 1] += weight * (n21 * slope[0, a] + n22 * slope[1, a])
            if tangents:
                C[:] = 0.0
                add_return_tangent(back, steel, C)
                if squeezed:
                    add_squeeze_tangent(stretch, steel.modulus, C)
                nominal_tangent(stretch, stress, C, D, K)
                add_stiffness(slope, weight, K, matrices[e])
        for a in range(2 * nodes):
            force[dofs[e, a]] += nodal[a]
    return Energies(stored, plastic)


@njit(cache=True, error_model="numpy")
def keep(new: PointStates, e: int, g: int, strain: Tensor, stress: Tensor, plastic: Tensor) -> None:
    """Write what a point has come to."""
    for i in range(3):
        new.strain[e, g, i] = strain[i]
        new.stress[e, g, i] = stress[i]
        new.plastic[e, g, i] = plastic[i]


@njit(cache=True, error_model="numpy")
def add_stiffness(slope: Array, weight: float, K: Array, matrix: Array) -> None:
    """Add the stiffness of a point with tangent K (4, 4) to that of its element."""
    nodes = slope.shape[1]
    for a in range(nodes):
        for i in range(2):
            for j in range(2):
                x = weight * (slope[0, a] * K[2 * i, 2 * j] + slope[1, a] * K[2 * i + 1, 2 * j])
                y = slope[0, a] * K[2 * i, 2 * j + 1] + slope[1, a] * K[2 * i + 1, 2 * j + 1]
                y *= weight
                for b in range(nodes):
                    matrix[2 * a + i, 2 * b + j] += x * slope[0, b] + y * slope[1, b]


# shares of an element's mass at its corners, in the middles of its edges, in its centre
SIMPSON = np.repeat([1.0 / 36.0, 4.0 / 36.0, 16.0 / 36.0], [4, 4, 1])


class LumpedAssembly:
    """A structure of plates or solids, whose dofs are the unknowns of its supports.

    Lumped `mass` and `velocity` (unknowns,); `steel`, and the `rate` at which it may flow.
    """

    mass: Array
    velocity: Array
    steel: SolidSteel
    rate: CowperSymonds | None

    def mass_times(self, x: Array) -> Array:
        """Product of the mass matrix with x (unknowns,)."""
        return np.asarray(self.mass * x)

    def begin_step(self, duration: float) -> None:
        """Let the steel flow at a rate from now on, in explicit steps of that `duration` (s)."""
        if self.rate is not None:
            flow, exponent = self.rate.reference_rate * duration, self.rate.exponent
            self.steel = self.steel._replace(reference_flow=flow, exponent=exponent)

    def kinetic_energy(self) -> float:
        """Kinetic energy of the unknowns, in J."""
        return 0.5 * float(np.sum(self.mass * self.velocity**2))


class SolidAssembly(LumpedAssembly):
    """A structure (see `equilibrium.Structure`) whose dofs are the unknowns q of its supports.

    Arguments: `mesh`; `supports`; `steel`; `hardening_ratio`, isotropic hardening modulus over
    Young's modulus; `mass` of every unknown (unknowns,), only needed in motion. Public state:
    `displacement` (unknowns,), committed, and `velocity`; `load` (unknowns,) in N; unknowns that
    are `held`; `spring` (stiffness and unstressed position of the head) in N/m and m;
    `squash_load` and `round_off` of forces in N; of the last evaluation internal forces `force`
    (dofs,) and `tangent` (unknowns, unknowns); energy `stored` and plastic work so far,
    `dissipated`, in J.
    """

    def __init__(
        self,
        mesh: SolidMesh,
        supports: Supports,
        steel: Steel,
        hardening_ratio: float,
        mass: Array | None = None,
    ) -> None:
        self.mesh, self.supports, modulus = mesh, supports, steel.elastic_modulus
        hardening = steel.hardening_modulus or hardening_ratio * modulus
        self.rate, self.hardening_ratio = steel.rate, hardening / modulus
        self.steel = SolidSteel(modulus, POISSON_RATIO, steel.yield_stress, hardening)
        self.squash_load = steel.yield_stress * mesh.area
        # strain is a difference of numbers near 1
        self.round_off = 8.0 * np.finfo(float).eps * modulus * mesh.area
        self.size = supports.unknowns
        self.displacement, self.velocity, self.load = np.zeros((3, self.size))
        self.mass = np.zeros(self.size) if mass is None else mass
        self.held: Indices = np.zeros(0, dtype=np.int64)
        self.spring = (0.0, 0.0)
        self.force = np.zeros(mesh.size)
        self.tangent = csc_array((self.size, self.size))
        self.stored = self.dissipated = 0.0
        self.elements = Elements(mesh.gradients, mesh.weights, mesh.dofs)
        self._old, self._new = empty_state(self.elements), empty_state(self.elements)
        self._matrices = np.empty((len(mesh.dofs), mesh.dofs.shape[1], mesh.dofs.shape[1]))
        self._energies = Energies(0.0, 0.0)

    def _forces(self, q: Array, tangent: bool) -> Array:
        """Internal forces (unknowns,) at q, all NaN where the material has no answer."""
        mesh, supports = self.mesh, self.supports
        self.force = np.zeros(mesh.size)
        matrices = self._matrices if tangent else self._matrices[:0]
        u = supports.expand(q)
        self._energies = respond(
            self.elements, u, self._old, self._new, self.steel, self.force, matrices
        )
        if np.isnan(self._energies.stored):
            return np.full(self.size, np.nan)
        stiffness, unstressed = self.spring
        force = supports.gather(q, self.force)
        force[supports.head] += stiffness * (q[supports.head] - unstressed)
        if tangent:
            rows = np.repeat(mesh.dofs, mesh.dofs.shape[1], axis=1).ravel()
            places = rows, np.tile(mesh.dofs, (1, mesh.dofs.shape[1])).ravel()
            matrix = coo_array((matrices.ravel(), places), shape=(mesh.size, mesh.size)).tocsr()
            derivative = supports.derivative(q)
            diagonal = supports.curvature(q, self.force)
            diagonal[supports.head] += stiffness
            self.tangent = (derivative.T @ matrix @ derivative + diags_array(diagonal)).tocsc()
        return force

    def assemble(self, end: Array, _weight: float | None = None) -> Array:
        """Internal forces (unknowns,) at `end`, NaN where there are none; prepares the tangent."""
        return self._forces(end, True)

    def resist(self, end: Array) -> Array:
        """Internal forces (unknowns,) at `end`. Raises `SolverError` where there are none."""
        force = self._forces(end, False)
        if np.isnan(force[0]):
            at = f"displacement {end[self.supports.hit]:.4g} m"
            tried = "no more: a point of the solid is turned inside out"
            raise SolverError(at, self.largest_strain(), tried)
        return force

    def solve(self, right: Array, held: Indices | None = None) -> Array | None:
        """Tangent^-1 times `right` (unknowns,), `held` ones at zero; None if it is singular."""
        free = np.delete(np.arange(self.size), self.held if held is None else held)
        try:
            factors = splu(
                self.tangent[free][:, free],
                permc_spec="MMD_AT_PLUS_A",
                diag_pivot_thresh=0.01,
                options={"SymmetricMode": True},
            )
        except RuntimeError:  # exactly singular
            return None
        solution = np.zeros_like(right)
        solution[free] = factors.solve(right[free])
        return solution if np.all(np.isfinite(solution)) else None

    def tangent_times(self, x: Array) -> Array:
        """Product of the tangent with x (unknowns,)."""
        return np.asarray(self.tangent @ x)

    def tangent_row(self, dof: int) -> tuple[Array, Indices]:
        """Row of an unknown in the tangent, which is symmetric, and its columns."""
        first, last = self.tangent.indptr[dof : dof + 2]
        return self.tangent.data[first:last], self.tangent.indices[first:last]

    def allowed_residual(self, tolerance: float, _start: Array, _residual: Array) -> float:
        """Largest residual entry (N) of a solved step: a wild start must not loosen it."""
        scale = max(*(float(np.max(np.abs(x))) for x in (self.force, self.load)), 1e-6)
        return max(tolerance * min(scale, self.squash_load), self.round_off)

    def account(self, end: Array, _weight: float) -> StepEnergies:
        """Energies of the step to `end`, with the mean of the stresses at both ends."""
        stiffness, unstressed = self.spring
        stored, plastic = self._energies
        pulled = float(end[self.supports.head]) - unstressed
        return StepEnergies(stored + 0.5 * stiffness * pulled**2, plastic, 0.0, plastic)

    def commit(self, end: Array) -> None:
        """Accept the state of the last evaluation, which was at `end`."""
        self.dissipated += self._energies.plastic
        self.displacement = end.copy()
        self._old, self._new = self._new, self._old

    @property
    def stress(self) -> Array:
        """Biot stress (elements, points, 3) of the last evaluation, squeeze guard left out."""
        return self._new.stress

    def area_ratio(self) -> Array:
        """Det U, the share of its area that a point keeps, of all points of the committed state."""
        e1, e2, e3 = np.moveaxis(self._old.strain, 2, 0)
        return np.asarray((1.0 + e1) * (1.0 + e2) - 0.25 * e3**2)

    def largest_strain(self) -> float:
        """Largest principal nominal strain (magnitude) of the committed state."""
        e1, e2, e3 = np.moveaxis(self._old.strain, 2, 0)
        centre, radius = 0.5 * (e1 + e2), np.hypot(0.5 * (e1 - e2), 0.5 * e3)
        return float(np.max(np.abs(centre) + radius))

    def segment_shear(self) -> tuple[float, float]:
        """Shear force of the segments below and above the hit section, committed, in N.

        The part of the reaction of its end across the chord of the deformed segment: at rest that
        is the force in all of its sections, in motion that of its end.
        """
        mesh, u = self.mesh, self.supports.expand(self.displacement)
        shears = []
        for end, length in ((mesh.base, mesh.lengths[0]), (mesh.head, -mesh.lengths[1])):
            across, along = self.force[end[0]].sum(), self.force[end[1]].sum()
            dx = u[mesh.hit[0]].mean() - u[end[0]].mean()
            dy = length + u[mesh.hit[1]].mean() - u[end[1]].mean()
            shears.append(float((across * dy - along * dx) / np.hypot(dx, dy)))
        return shears[0], shears[1]


def solid_column(
    column: Column,
    smallest: float | None = None,
    refinement: int = 0,
    hardening_ratio: float = 1e-6,
) -> SolidAssembly:
    """The solid of a column with its mass, before any load; arguments as of `solid_mesh`.

    End plates turn about their centroid, so that the mass of every unknown is constant: a plate has
    the inertia sum m X^2, and what couples its turn to the displacement of the head sums to zero.
    """
    mesh = solid_mesh(column, smallest, refinement)
    supports = supports_of(mesh, column.base, column.head)
    nodal = nodal_mass(mesh, column)
    mass = np.asarray(supports.gathering @ nodal)
    for plate in supports.plates:
        mass[plate.turn] = nodal[plate.vertical] @ plate.places**2
    mass[supports.head] += column.head_mass
    mass[supports.hit] += column.attached_mass
    return SolidAssembly(mesh, supports, column.steel, hardening_ratio, mass)


def nodal_mass(mesh: SolidMesh, column: Column) -> Array:
    """Mass at every dof of the mesh (dofs,), in kg: that of the column, spread over its mesh.

    It stands at the nodes by the quadrature rule that samples there, Simpson's, whose weights are
    all positive.
    """
    density = column.properties.mass_per_length / mesh.area
    mass = np.zeros(mesh.size)
    shares = density * mesh.weights.sum(1)[:, None] * np.repeat(SIMPSON, 2)
    np.add.at(mass, mesh.dofs, shares)
    return mass
