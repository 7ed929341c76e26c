"""The elastic beam-column between two ends: stability functions, and their derivatives.

Bernoulli's beam under an axial force N (tension positive) and end moments M_1, M_4 bends in two
uncoupled modes, symmetric (M_1 - M_4) and antisymmetric (M_1 + M_4), with the flexibilities

    c_s = L / 2EI A(y),  A = tan h / h,        c_a = L / 2EI B(y),  B = (1 - h cot h) / h^2,

h^2 = y = -N L^2 / 4EI; the conventional S_1 and S_2 are (1/A + 1/B) and (1/B - 1/A) by EI / L.
The shortening by bending is -M F'(N) M / 2, so that forces derive from a complementary energy,
jointly convex in (N, M) above the Euler load of the pin-ended bar, y = (pi / 2)^2.
Source: Livesley and Chandler 1956; Oran 1973 for the shortening.
"""

import math

from workbench.compiled import njit

SMALL = 0.01  # of y; below it series
SERIES_A = (1.0, 1.0 / 3.0, 2.0 / 15.0, 17.0 / 315.0, 62.0 / 2835.0, 1382.0 / 155925.0)
SERIES_B = (1.0 / 3.0, 1.0 / 45.0, 2.0 / 945.0, 1.0 / 4725.0, 2.0 / 93555.0, 1382.0 / 638512875.0)


@njit(cache=True, error_model="numpy", forceinline=True)
def cotangent(y):
    """H cot h for y = h^2; h coth h for negative y, h^2 = -y."""
    if abs(y) < SMALL:
        b = SERIES_B[0] + y * (SERIES_B[1] + y * (SERIES_B[2] + y * SERIES_B[3]))
        return 1.0 - y * b
    h = math.sqrt(abs(y))
    return h / math.tan(h) if y > 0.0 else h / math.tanh(h)


@njit(cache=True, error_model="numpy")
def _series(terms, y):
    """Value, first and second derivative of a power series."""
    value = first = second = 0.0
    for k in range(len(terms) - 1, -1, -1):
        second = second * y + 2.0 * first
        first = first * y + value
        value = value * y + terms[k]
    return value, first, second


@njit(cache=True, error_model="numpy")
def modes(y):
    """A, A', A'' and B, B', B'' at y < (pi / 2)^2."""
    if abs(y) < SMALL:
        return _series(SERIES_A, y), _series(SERIES_B, y)
    a = 1.0 / cotangent(y)
    a1 = (1.0 + y * a * a - a) / (2.0 * y)
    a2 = (a * a + 2.0 * y * a * a1 - 3.0 * a1) / (2.0 * y)
    b = (1.0 - 1.0 / a) / y
    b1 = (a1 / (a * a) - b) / y
    b2 = ((a2 - 2.0 * a1 * a1 / a) / (a * a) - 2.0 * b1) / y
    return (a, a1, a2), (b, b1, b2)
