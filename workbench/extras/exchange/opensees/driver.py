"""Run of a struck structure in OpenSees: steps in time, and a striker that hits, sticks, flies off.

It needs nothing of the workbench: an exported script holds this text as it is, so that a script
and the model `opensees` are one program. `ops` is the module `openseespy.opensees`.

A collision at an instant keeps momentum: Newton's restitution between the striker and the mass of
the node that it hits. Without rebound both go on as one mass until the striker would have to be
pulled; it then flies, and hits again where it catches up, without rebound after a flight of a few
steps: that is contact. Events end with a step, which converges with the length of the steps.
"""

from collections.abc import Iterable, Iterator
from math import ceil, inf, isfinite
from typing import Any

CUTS = (1, 4, 16, 64, 256)  # parts of a step that fails
SLOW = 1e-4  # of the velocity of the striker: an approach that no longer rebounds
CHATTER = 4  # steps: what flies for less is in contact all the time
GROWN = 0.01  # of the energy brought in, that a run must not gain
ASTRAY = 0.01  # of it, between the work of an element and that of its sections


class UnsolvedError(RuntimeError):
    """A step that OpenSees does not solve, or solves on a false path; with the `residual` left."""

    def __init__(self, text: str, residual: float = inf) -> None:
        super().__init__(text)
        self.residual = residual


def analyse(ops: Any, kind: str, integrator: tuple[Any, ...], test: tuple[Any, ...]) -> None:
    """Set up an analysis of a kind, Static or Transient, from the state that there is."""
    ops.wipeAnalysis()
    ops.constraints("Plain")
    ops.numberer("RCM")
    ops.system("BandGeneral")
    ops.test(*test)
    ops.algorithm("Newton")
    ops.integrator(*integrator)
    ops.analysis(kind)


def stand(ops: Any, steps: int = 5) -> None:
    """Bring the dead loads on, in equal steps, and keep them."""
    analyse(ops, "Static", ("LoadControl", 1.0 / steps), ("NormUnbalance", 1e-2, 60))
    if ops.analyze(steps) != 0:
        raise UnsolvedError("OpenSees finds no equilibrium under the dead loads")
    ops.loadConst("-time", 0.0)


class ElementWork:
    """Work of a force-based element, and that of its sections, which equals it on the true path.

    An iteration inside the element that finds another path leaves it without strength: nothing else
    tells, as equilibrium holds there too.
    """

    def __init__(self, ops: Any, tag: int) -> None:
        self.ops, self.tag, self.difference = ops, tag, 0.0
        self.weights = ops.eleResponse(tag, "integrationWeights")
        self.old = self._read()

    def astray(self) -> float:
        """Difference of the two so far, in J."""
        new = self._read()
        for weight, old_part, part in zip([-1.0, *self.weights], self.old, new, strict=True):
            rows = zip(*old_part, *part, strict=True)
            self.difference += weight * sum(0.5 * (f + g) * (v - u) for f, u, g, v in rows)
        self.old = new
        return abs(self.difference)

    def _read(self) -> list[tuple[list[float], list[float]]]:
        """Forces and deformations of the element, then of its sections."""
        ask, tag = self.ops.eleResponse, self.tag
        places = [("section", str(i + 1)) for i in range(len(self.weights))]
        return [
            (ask(tag, "basicForce"), ask(tag, "basicDeformation")),
            *((ask(tag, *at, "force"), ask(tag, *at, "deformation")) for at in places),
        ]


class Strike:
    """A striker on the way to a node, and the structure that it hits.

    Arguments: `nodes` that move; force-based `elements`; the node `hit`, number `dof` of its
    direction from 1 and `sign` of the flight; the striker's `mass` (kg), `velocity` (m/s) and
    `restitution`. After every step:
    `time` (s), `moved` (m), `speed` (m/s), `impulse` of the step (N s), `kinetic` energy, `work`
    that the structure has taken beyond that of its dead loads, and energy `lost` in contact (J).
    """

    def __init__(
        self,
        ops: Any,
        nodes: list[int],
        elements: list[int],
        hit: int,
        dof: int,
        sign: float,
        mass: float,
        velocity: float,
        restitution: float,
    ) -> None:
        self.ops, self.hit, self.dof, self.sign, self.nodes = ops, hit, dof, sign, nodes
        self.mass, self.velocity, self.restitution = mass, velocity, restitution
        self.slow = SLOW * velocity
        self.start = self.place = sign * ops.nodeDisp(hit, dof)
        self.masses = {node: list(ops.nodeMass(node)) for node in nodes}
        self.own = self.masses[hit]
        self.sticks, self.flown = False, inf  # steps since the last collision
        self.time = self.moved = self.speed = self.impulse = self.work = self.lost = 0.0
        self.given = self.kinetic = 0.5 * mass * velocity**2
        self.elements = [ElementWork(ops, tag) for tag in elements]
        self.places: list[float] = []
        self.forces: list[float] = []
        self._read()

    def follow(self, spans: Iterable[tuple[float, float]]) -> Iterator["Strike"]:
        """Take the steps of the spans, pairs of their end and longest step (s), one by one."""
        self._collide()
        for end, longest in spans:
            count = ceil((end - self.time) / longest - 1e-6)
            begin = self.time
            for number in range(1, count + 1):
                self._step(begin + (end - begin) * number / count)
                self._check()
                yield self
                self.impulse = 0.0
                if not self.sticks and self.place > self.start + self.moved:
                    self._collide()

    def _step(self, end: float) -> None:
        before, length = self.speed, end - self.time
        for parts in CUTS:  # from where the last attempt has stopped
            if self.ops.analyze(parts, (end - self.ops.getTime()) / parts) == 0:
                break
        else:
            raise UnsolvedError(
                f"OpenSees does not solve the step to {end:.4g} s in {CUTS[-1]} parts"
            )
        self.time = end
        self._read()
        if not isfinite(self.kinetic + self.work):
            raise UnsolvedError(f"OpenSees returns numbers that are not finite at {end:.4g} s")
        if not self.sticks:
            self.flown += 1
            self.place += self.velocity * length
            self.kinetic += 0.5 * self.mass * self.velocity**2
            return
        pushed = self.mass * (before - self.speed)
        if pushed >= 0.0:
            self.impulse += pushed
        else:
            self._carry(0.0, self.speed)
            self.sticks, self.velocity = False, self.speed
            self.place = self.start + self.moved

    def _check(self) -> None:
        """Raise `UnsolvedError` where the run is on a false path."""
        grown = (self.kinetic + self.work + self.lost) / self.given - 1.0
        if grown > GROWN:
            raise UnsolvedError(f"energy has grown by {grown:.2g} at {self.time:.4g} s", grown)
        astray = max((each.astray() for each in self.elements), default=0.0) / self.given
        if astray > ASTRAY:
            text = "it has left the true path, sections have taken other work than their element"
            raise UnsolvedError(f"{text}, by {astray:.2g} at {self.time:.4g} s", astray)

    def _collide(self) -> None:
        """Collision of the striker with the node at this instant."""
        own, approach = self.own[self.dof - 1], self.velocity - self.speed
        if approach <= 0.0:
            return
        self.place = self.start + self.moved
        bounces = approach > self.slow and self.flown > CHATTER
        rebound = self.restitution if bounces else 0.0
        self.flown = 0
        impulse = (1.0 + rebound) * approach * own * self.mass / (own + self.mass)
        self.lost += 0.5 * (1.0 - rebound**2) * approach**2 * own * self.mass / (own + self.mass)
        self.velocity -= impulse / self.mass
        self.sticks = rebound == 0.0
        self.speed = self.velocity + rebound * approach
        self.impulse += impulse
        self._carry(self.mass if self.sticks else 0.0, self.speed)

    def _carry(self, mass: float, speed: float) -> None:
        """Let the node move with that speed (m/s) and carry a mass (kg) of the striker's."""
        ops, at = self.ops, self.dof - 1
        old = self.masses[self.hit][at]
        masses = [own + mass * (number == at) for number, own in enumerate(self.own)]
        ops.mass(self.hit, *masses)
        self.masses[self.hit] = masses
        ops.setNodeVel(self.hit, self.dof, self.sign * speed, "-commit")
        accelerated = ops.nodeAccel(self.hit, self.dof)  # by the same force
        ops.setNodeAccel(self.hit, self.dof, accelerated * old / masses[at], "-commit")
        # by the trapezoidal rule and backward difference: Newmark's average rings
        analyse(ops, "Transient", ("TRBDF2",), ("EnergyIncr", 1e-8, 25))

    def _read(self) -> None:
        """Read place, speed and energies; the work is that of the nodes' resisting forces."""
        ops = self.ops
        ops.reactions()
        places = [value for node in self.nodes for value in ops.nodeDisp(node)]
        forces = [value for node in self.nodes for value in ops.nodeReaction(node)]
        if self.time:
            rows = zip(places, self.places, forces, self.forces, strict=True)
            self.work += sum(0.5 * (f + g) * (u - v) for u, v, f, g in rows)
            self.kinetic = sum(
                0.5 * mass * speed**2
                for node in self.nodes
                for mass, speed in zip(self.masses[node], ops.nodeVel(node), strict=True)
            )
        self.places, self.forces = places, forces
        self.moved = self.sign * ops.nodeDisp(self.hit, self.dof) - self.start
        self.speed = self.sign * ops.nodeVel(self.hit, self.dof)
