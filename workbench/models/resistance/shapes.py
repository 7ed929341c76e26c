"""The three shapes of the resistance curve of a column.

Equilibrium at the impact point, with small rotations of two rigid bars (kappa = 1/L_a + 1/L_b):
F = sum(s_g M_g) + kappa N v over the hinge groups g, elastic with M_g = K_g v. The yield surface
is straight from (N_p, 0) to a corner (N_c, M_p) and flat below: M = min(M_p, r (N_p - |N|)) with
r = M_p / (N_p - N_c); N_c = 0 is the linear surface of the thesis. Compatibility of
the axial force N, one for both bars, with the chords' stretching kappa v^2 / 2, the axial
flexibility c and the plastic elongation of the hinges (associated flow: r per rotation on the
slopes, none on the flat) gives (c + r^2 sum phi_g) dN = (kappa v - sigma r sum s_g) dv over
the plastic groups, sigma = sign N on the slopes. At N = N_c the corner holds N while hinges stretch
faster than chords. Heng 2017, section 5.2, shows the stages in figure 5.5 but no
formula; see the theory page for the derivation.

**Second part.** Equivalent single degrees of freedom by Biggs: shapes of deflection, integrated.

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
from typing import Any, NamedTuple

import numpy as np

from workbench.base.arrays import Array
from workbench.base.compiled import njit
from workbench.base.errors import OutOfDomainError
from workbench.base.fields import Choice
from workbench.mechanics.structures.kernels import copy
from workbench.models.resistance import curve as events
from workbench.models.resistance.curve import Groups, Pieces, PlasticMechanism, ResistanceCurve
from workbench.models.resistance.kernels import PIECE, falling_root, lost_at, sum_up
from workbench.scenarios import Column

RESISTANCES = ("analytic", "cubic", "linear")
_MOST_PIECES = 40


@njit(cache=True, error_model="numpy")
def analytic(m: Groups) -> tuple[Pieces, bool]:
    """Exact event-driven pieces; and whether a plastic hinge would unload, which they exclude."""
    s, K, phi, kappa, Mp, Np, N0, c_ax, Nc = m
    groups = s.size
    pieces, plastic = np.zeros(_MOST_PIECES, PIECE), np.zeros(3, np.int8)
    slope, v, N, hold, caught, unloads = Mp / (Np - Nc), 0.0, N0, False, False, False
    sigma = np.sign(N0) if abs(N0) > Nc else 0.0
    event, group, n = events.START, -1, 0
    for _ in range(_MOST_PIECES):
        s_plastic, C, w_elastic, r = 0.0, c_ax, 0.0, slope * abs(sigma)
        for g in range(groups):
            if plastic[g]:
                s_plastic += s[g]
                C += r * r * phi[g]
            else:
                w_elastic += s[g] * K[g]
        if sigma > 0.0 and Nc == N and not caught:
            # the corner holds N while hinges stretch faster than chords
            hold = kappa * v < r * s_plastic * (1.0 - 1e-12)
        if caught:
            n0, n1, n2 = Np, 0.0, 0.0
        elif hold:
            n0, n1, n2 = Nc, 0.0, 0.0
        else:
            n0, n1, n2 = N, (kappa * v - sigma * r * s_plastic) / C, 0.5 * kappa / C
        m0 = min(Mp, slope * (Np - abs(n0)))
        m1, m2 = -sigma * r * n1, -sigma * r * n2
        # the next event
        x, next_event, next_group = np.inf, events.START, -1
        if not caught:
            for g in range(groups):
                if not plastic[g]:
                    at = falling_root(m0 - K[g] * v, m1 - K[g], m2, 1e-13 * Mp)
                    if at < x:
                        x, next_event, next_group = at, events.YIELDS, g
            if hold:
                at = slope * s_plastic / kappa - v
                if at < x:
                    x, next_event, next_group = max(at, 0.0), events.TENSION, -1
            else:
                if sigma > 0.0:  # N falls to the corner, or rises to the next one
                    at = falling_root(n0 - Nc, n1, n2, 0.0) if n0 > Nc else np.inf
                else:
                    at = falling_root((Nc if sigma == 0.0 else -Nc) - n0, -n1, -n2, 0.0)
                if at < x:
                    x, next_event, next_group = at, events.CORNER, -1
                at = falling_root(Np - n0, -n1, -n2, 0.0)
                if at < x:
                    x, next_event, next_group = at, events.CATENARY, -1
        if x > 1e-13 * (v + r):
            piece, c = pieces[n], pieces[n].c
            piece.start, piece.event, piece.group = v, event, group
            c[0] = s_plastic * m0 + w_elastic * v + kappa * n0 * v
            c[1] = s_plastic * m1 + w_elastic + kappa * (n0 + n1 * v)
            c[2] = s_plastic * m2 + kappa * (n1 + n2 * v)
            c[3] = kappa * n2
            piece.axial[0], piece.axial[1], piece.axial[2] = n0, n1, n2
            for g in range(3):
                piece.plastic[g] = plastic[g]
            n += 1
            if not caught:
                # plastic rotation of a group grows at the rate (K_g - dM/dv) phi_g
                last = n1 if x == np.inf else n1 + 2.0 * n2 * x
                slowest = min(sigma * r * n1, sigma * r * last)
                for g in range(groups):
                    if plastic[g] and K[g] + slowest < -1e-9 * K[g]:
                        unloads = True
            if x == np.inf:
                break
            N = n0 + x * (n1 + x * n2)
            v += x
        event, group = next_event, next_group
        if event == events.YIELDS:
            plastic[group] = 1
        elif event == events.CORNER:
            if sigma < 0.0:
                N, sigma = -Nc, 0.0
            else:
                N, sigma = Nc, 1.0
            if Nc == 0.0:
                event = events.NO_AXIAL_FORCE
        elif event == events.TENSION:
            hold, N, sigma = False, Nc, 1.0
        elif event == events.CATENARY:
            caught, N, sigma = True, Np, 1.0
    return pieces[:n], unloads


@njit(cache=True, error_model="numpy")
def simplified_points(m: Groups) -> tuple[float, float, float, float, float, float]:
    """Points that both simplifications share: (F0, k_e, v_y, v_b, v_nd, v_c).

    F0 mechanism load at the initial axial force, k_e elastic stiffness, v_y = F0 / k_e, v_b
    last hinge, v_nd axial force gone, v_c catenary (infinite without axial restraint).
    """
    s, K, phi, kappa, Mp, Np, N0, c_ax, _ = m
    r, total = Mp / Np, np.sum(s)
    Mr = Mp * (1.0 - abs(N0) / Np)
    F0, ke = total * Mr, np.sum(s * K)
    vy = F0 / ke
    vb = max(Mr / np.min(K), vy)
    v_hat = r * total / kappa
    C = c_ax + r * r * np.sum(phi)
    q = kappa / C
    if q == 0.0:
        return F0, ke, vy, vb, (vb if N0 == 0.0 else np.inf), np.inf
    push = N0 / q  # q ((v^2 - v_b^2) / 2 -+ v_hat (v - v_b)) is the growth of N after v_b
    N_b = 0.0
    if N0 <= 0.0:
        v_nd = -v_hat + np.sqrt(v_hat * v_hat - 2.0 * push + vb * vb + 2.0 * v_hat * vb)
        v_pd = max(v_nd, v_hat)
    elif vb < v_hat:
        # initial tension falls first; at v_hat the force is that of N = 0 whatever N is
        left = (v_hat - vb) ** 2 - 2.0 * push
        v_nd, v_pd = v_hat - np.sqrt(max(left, 0.0)), v_hat
        N_b = max(-0.5 * q * left, 0.0)
    else:
        v_nd, v_pd, N_b = vb, vb, N0
    rest = (Np - N_b) / q
    v_c = v_hat + np.sqrt((v_pd - v_hat) ** 2 + 2.0 * rest)
    return F0, ke, vy, vb, v_nd, v_c


@njit(cache=True, error_model="numpy")
def put(pieces: Pieces, n: int, event: int, start: float, c: tuple[float, float, float]) -> int:
    """Append a piece that begins with an event; the number of pieces then."""
    pieces[n].event, pieces[n].start = event, start
    pieces[n].c[0], pieces[n].c[1], pieces[n].c[2] = c
    return n + 1


@njit(cache=True, error_model="numpy")
def cubic(m: Groups) -> Pieces:
    """Simplification 1: elastic line, plateau, cubic, catenary.

    A reconstruction: the source names it and shows its curve, and of several dozen definitions
    that give the published peaks this is one.
    """
    s, _, _, kappa, Mp, Np, _, _, _ = m
    F0, ke, vy, vb, v_nd, v_c = simplified_points(m)
    pieces = np.zeros(4, PIECE)
    put(pieces, 0, events.START, 0.0, (0.0, ke, 0.0))
    put(pieces, 1, events.LOAD, vy, (F0, 0.0, 0.0))
    put(pieces, 2, events.LAST, vb, (F0, 0.0, 0.0))
    if v_c == np.inf:
        return pieces[:3]
    x1, x2, plateau = v_nd - vb, v_c - vb, kappa * Np
    rise1, rise2 = np.sum(s) * Mp - F0, plateau * v_c - F0
    c1, c3 = 0.0, rise2 / x2**3
    if x1 >= 1e-9:
        slope1, slope2 = rise1 / x1, rise2 / x2
        c3_both = (slope2 - slope1) / ((x2 - x1) * (x2 + x1))
        c1_both = slope1 - c3_both * x1 * x1
        if c1_both >= 0.0:
            c1, c3 = c1_both, c3_both
    pieces[2].c[1], pieces[2].c[3] = c1, c3
    put(pieces, 3, events.CATENARY, v_c, (plateau * v_c, plateau, 0.0))
    return pieces


@njit(cache=True, error_model="numpy")
def linear(m: Groups) -> Pieces:
    """Simplification 2: axial force linear in the displacement once all hinges have yielded.

    A choice: the source shows a curve but prints neither formula nor number.
    """
    s, _, _, kappa, Mp, Np, N0, _, _ = m
    F0, ke, vy, vb, _, v_c = simplified_points(m)
    pieces, total, r = np.zeros(5, PIECE), np.sum(s), Mp / Np
    put(pieces, 0, events.START, 0.0, (0.0, ke + kappa * N0, 0.0))
    n = put(pieces, 1, events.LOAD, vy, (F0 + kappa * N0 * vy, kappa * N0, 0.0))
    pieces[0].axial[0] = pieces[1].axial[0] = N0
    if v_c == np.inf:
        return pieces[:n]
    rate = (Np - N0) / (v_c - vb)
    v, N, event = vb, N0, events.LAST
    while True:
        sigma = -1.0 if N < 0.0 else 1.0
        pieces[n].axial[0], pieces[n].axial[1] = N, rate
        c0 = total * Mp - total * sigma * r * N + kappa * N * v
        c1 = -total * sigma * r * rate + kappa * (N + rate * v)
        n = put(pieces, n, event, v, (c0, c1, kappa * rate))
        if N >= 0.0:
            break
        v, N, event = v - N / rate, 0.0, events.NO_AXIAL_FORCE
    pieces[n].axial[0] = Np
    return pieces[: put(pieces, n, events.CATENARY, v_c, (kappa * Np * v_c, kappa * Np, 0.0))]


@njit(cache=True, error_model="numpy")
def of_shape(shape: int, m: Groups) -> tuple[Pieces, float, bool]:
    """Pieces of a shape, by its place in RESISTANCES, and displacement of the first yielding.

    And whether a hinge would unload, as of `analytic`.
    """
    if shape == 0:
        pieces, unloads = analytic(m)
        first = 0
        while first + 1 < pieces.size and not pieces[first].plastic.any():
            first += 1
        return pieces, pieces[first].start, unloads
    pieces = cubic(m) if shape == 1 else linear(m)
    limit, kept = pieces[1].start, 0
    # a single hinge group has no plateau; a piece takes the event of the first one where it is
    for i in range(pieces.size):
        if i > 0 and pieces[i].start == pieces[i - 1].start:
            pieces[i].event = pieces[i - 1].event
    for i in range(pieces.size):
        if i + 1 == pieces.size or pieces[i + 1].start > pieces[i].start:
            take_piece(pieces[i], pieces[kept])
            kept += 1
    return pieces[:kept], limit, False


@njit(cache=True, error_model="numpy")
def take_piece(source: Any, target: Any) -> None:
    """Copy what the shapes write of a piece."""
    copy(source.c, target.c)
    copy(source.axial, target.axial)
    target.start, target.event, target.group = source.start, source.event, source.group


class MechanismRows(NamedTuple):
    """Mechanisms of n columns: (n, groups) rotation rates, stiffnesses, flexibilities; (n,) others.

    As `PlasticMechanism.kernel`, then the `reach` (m) of each and the number of the `shape`.
    """

    rates: Array
    moments: Array
    flexibilities: Array
    slope_sum: Array
    plastic_moment: Array
    squash_load: Array
    axial_force: Array
    axial_flexibility: Array
    corner: Array
    reach: Array
    shape: int


@njit(cache=True, error_model="numpy")
def curve_of(rows: MechanismRows, i: int) -> tuple[Pieces, float, float, bool]:
    """Curve of row i: pieces, displacements of first yielding and of loss, whether one unloads."""
    m = (
        *(rows.rates[i], rows.moments[i], rows.flexibilities[i], rows.slope_sum[i]),
        *(rows.plastic_moment[i], rows.squash_load[i], rows.axial_force[i]),
        *(rows.axial_flexibility[i], rows.corner[i]),
    )
    pieces, limit, unloads = of_shape(rows.shape, m)
    sum_up(pieces)
    return pieces, limit, lost_at(pieces), unloads


def resistance_curve(mechanism: PlasticMechanism, shape: str) -> ResistanceCurve:
    """The resistance curve of a mechanism.

    Arguments: `mechanism`; `shape`: analytic, cubic or linear. Raises `OutOfDomainError` if a
    yielded hinge would unload on the way (analytic), ValueError for another shape.
    """
    pieces, limit, unloads = of_shape(RESISTANCES.index(shape), mechanism.kernel)
    if unloads:
        raise OutOfDomainError(
            "a yielded hinge would unload while the push goes on, which the analytic "
            "resistance excludes: use the four-DOF model or a simplified resistance"
        )
    return ResistanceCurve(shape, mechanism, pieces, float(limit))


_POINT, _WEIGHT = np.polynomial.legendre.leggauss(5)  # exact up to the ninth degree
_POINT, _WEIGHT = 0.5 * (1.0 + _POINT), 0.5 * _WEIGHT
NONE, LINEAR, SECTION = "none", "linear", "section"
AXIAL = Choice((NONE, LINEAR, SECTION))
AXIAL_HELP = "how the axial load lowers M_p: linear, M_p (1 - n), or by the envelope of the section"
_TOGETHER = 1e-9  # hinges that yield within this share of a load yield at once


class DeflectedShape(NamedTuple):
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

    def momentum(self, other: "DeflectedShape") -> float:
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
    shape: DeflectedShape
    load_factor: float
    mass_factor: float
    moments: Array
    rates: Array
    hinges: frozenset[int]

    @property
    def load_mass_factor(self) -> float:
        """K_LM = K_M / K_L."""
        return self.mass_factor / self.load_factor


class DeflectedBeam(NamedTuple):
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
        shape = DeflectedShape(np.array(self.nodes), deflection / deflection[self.reference, 0])
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


def beam_of(column: Column, uniform: bool = False) -> DeflectedBeam:
    """The column as a beam under a force at its impact point, or under a `uniform` line load."""
    return DeflectedBeam(
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
    """Stages of a column under a force at its impact point, or under a `uniform` line load.

    `axial`, see `plastic_moment`.
    """
    return beam_of(column, uniform).stages(np.full(3, plastic_moment(column, axial)))
