"""Vehicles of EN 1991-1-7 as strikers, and the static forces that stand for them.

The standard was not at hand: the numbers are recalled and *not verified in print*, but for the
forces of cars (50 and 25 kN) and for what the JCSS Probabilistic Model Code, 2.18, has as well: the
angle, the motion below and the stiffness. A national annex may have others.
"""

from math import radians, sin, sqrt
from typing import NamedTuple

from workbench.base.errors import InputError
from workbench.base.fields import Choice, Number
from workbench.scenarios.column import Striker


class Traffic(NamedTuple):
    """Vehicles of one place: static forces (N) along and across the traffic, Table 4.1.

    And the design values of Table C.2 (0: it has none): mass (kg), velocity (m/s).
    """

    title: str
    along: float
    across: float
    mass: float = 0.0
    velocity: float = 0.0


TRAFFIC = {
    "motorway": Traffic("motorways and main roads", 1e6, 5e5, 3e4, 90.0 / 3.6),
    "rural": Traffic("country roads in rural areas", 7.5e5, 3.75e5),
    "urban": Traffic("roads in urban areas", 5e5, 2.5e5, 3e4, 50.0 / 3.6),
    "yard-lorries": Traffic("courtyards with lorries", 1.5e5, 7.5e4, 3e4, 15.0 / 3.6),
    "yard-cars": Traffic("courtyards with cars alone", 5e4, 2.5e4, 1.5e3, 20.0 / 3.6),
    "garage": Traffic("parking garages with cars alone", 5e4, 2.5e4, 1.5e3, 10.0 / 3.6),
}
FORCES = {
    name + suffix: force
    for name, each in TRAFFIC.items()
    for suffix, force in (("", each.along), ("-across", each.across))
}
LIGHTEST = min(each.mass for each in TRAFFIC.values() if each.mass)  # kg, of design vehicles
VEHICLE_STIFFNESS = 3.0e5  # N/m, Annex C; JCSS: of cars and lorries alike, standard deviation 6e4
DECELERATION = 3.0  # m/s^2, Table C.2; the mean of Table C.1 and of the JCSS is 4
ANGLE = 10.0  # degrees to the road, the mean of Table C.1 and of the JCSS


def velocity_after(
    velocity: float, distance: float, deceleration: float = DECELERATION, angle: float = ANGLE
) -> float:
    """Velocity (m/s) at a column at a `distance` (m) from where the vehicle leaves its lane.

    It leaves with a `velocity` (m/s) at an `angle` (degrees) to the road and is braked on its way
    s = d / sin(angle) by a `deceleration` (m/s^2): v_r = (v_0^2 - 2 a s)^1/2. Raises `InputError`
    for a distance that it does not reach, d_b = v_0^2 sin(angle) / (2 a).
    """
    velocity = Number(1e-3, 200.0, "m/s").check("velocity", velocity)
    distance = Number(0.0, 1e4, "m").check("distance", distance)
    deceleration = Number(1e-3, 20.0, "m/s^2").check("deceleration", deceleration)
    angle = Number(0.1, 90.0, "degrees").check("angle", angle)
    reached = velocity**2 * sin(radians(angle)) / (2.0 * deceleration)
    if distance >= reached:
        text = f"must be below {reached:.4g} m, where the vehicle has come to rest"
        raise InputError("distance", distance, text, "no impact is to be designed for")
    return velocity * sqrt(1.0 - distance / reached)


def design_striker(
    traffic: str,
    distance: float = 0.0,
    deceleration: float = DECELERATION,
    angle: float = ANGLE,
    stiffness: float | None = None,
) -> Striker:
    """Return the vehicle of Table C.2 as a striker, as fast as `velocity_after` a distance (m).

    It crushes with a `stiffness` (N/m), such as `VEHICLE_STIFFNESS`, or is rigid. Raises
    `InputError`, also for a kind of `traffic` without design values.
    """
    known = tuple(name for name, each in TRAFFIC.items() if each.mass)
    vehicle = TRAFFIC[Choice(known).check("traffic", traffic)]
    velocity = velocity_after(vehicle.velocity, distance, deceleration, angle)
    return Striker(vehicle.mass, velocity, stiffness=stiffness)
