"""What tests tell of the parameters and scatters of a mixed model, and of new tests: a mixture.

Given the ratio of variances lambda, parameters and new tests are Student-distributed. As few
campaigns hardly tell lambda, its restricted likelihood is integrated over sqrt(lambda) with the
weakly informative half-Cauchy density that Gelman 2006 recommends for few groups. With fewer than
three campaigns the assumed density would decide, so a prior is asked for that is known from
elsewhere: with one the distributions are normal given tau and sigma, which are both integrated.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from workbench.errors import InputError
from workbench.studs.quantities import Array
from workbench.studs.statistics.intervals import Interval, tails_of
from workbench.studs.statistics.mixed import ROUND_OFF, Estimate, criterion_at
from workbench.studs.statistics.problem import Indices, Problem, jacobian

LEAST_CAMPAIGNS = 3
LARGEST_RATIO = 100.0  # tau over sigma; beyond it the likelihood has vanished for 3 campaigns
LEAST_RATIO = 0.002  # above zero, where a prior may lie; without one it tells nothing more
POINTS = 80
# scale of the half-Cauchy density of tau over sigma: 3 to 6.5 % of new tests lie below the 5 %
# fractile of three campaigns or more where the ratio is 0.4 to 2
USUAL_RATIO = 1.0
VARIANCES = (np.arange(16) + 0.5) / 16.0  # shares of its distribution, at which sigma^2 is taken
NEGLIGIBLE = 14.0  # of a logarithm of a density below its largest
NORMAL = 1e9  # degrees of freedom
TAU = "tau"  # the scatter between campaigns among the priors
Priors = Mapping[str, tuple[float, float]]
"""What is known from elsewhere: value and spread by name.

Of ``tau`` its median and the standard deviation of its logarithm, of a parameter the mean and
standard deviation in its own unit.
"""
NOTHING: Priors = MappingProxyType({})


class Mixture(NamedTuple):
    """Distributions (points,) of the free parameters, Student with `nu` degrees of freedom."""

    weight: Array
    theta: Array  # (points, p)
    ratio: Array  # tau / sigma
    variance: Array  # sigma^2
    inverse: Array  # (points, free, free), covariance over sigma^2
    nu: float


def mixture_of(estimate: Estimate, priors: Priors) -> Mixture:
    """One distribution per ratio tau / sigma, weighing by its restricted likelihood and the priors.

    Priors of parameters that rest on a bound, or that the estimate does not have, count for
    nothing.
    """
    free = np.flatnonzero(~estimate.at_bound)
    given, every = _linear(estimate, free), np.arange(len(free))
    # fine near zero, where the likelihood changes; its tail falls like a power
    least = LEAST_RATIO if TAU in priors else 0.02
    r = np.concatenate([[0.0], np.geomspace(least, LARGEST_RATIO, POINTS)])
    theta, found = np.tile(estimate.theta, (len(r), 1)), []
    for k, each in enumerate(r):
        value, variance, solved = criterion_at(given, float(each) ** 2, given.start, every)
        theta[k, free] = solved.theta
        found.append((value, variance, np.linalg.pinv(solved.normal)))
    values, variances, inverses = (np.array(each) for each in zip(*found, strict=True))
    weight = np.exp(-0.5 * (values - values.min())) * np.gradient(r)
    flat = Mixture(weight, theta, r, variances, inverses, given.count - len(free))
    if not priors:
        weight = weight / (1.0 + (r / USUAL_RATIO) ** 2)
        return flat._replace(weight=weight / weight.sum())
    return _with_priors(flat, priors, list(given.names), free)


def _linear(estimate: Estimate, free: Indices) -> Problem:
    """The problem of the `free` parameters, its prediction linear around the best ones."""
    given, theta = estimate.problem, estimate.theta
    x, none = jacobian(given, theta, free), np.full(len(free), np.inf)
    y, names = given.y - given.predict(theta) + x @ theta[free], tuple(given.names[k] for k in free)
    known = replace(given, y=y, design=x, predict=lambda own: x @ own, tangent=None)
    return replace(known, names=names, start=theta[free], lower=-none, upper=none)


def _with_priors(flat: Mixture, priors: Priors, names: list[str], free: Indices) -> Mixture:
    """Normal distributions for several sigma^2 per ratio, under priors of tau and parameters."""
    from scipy.special import chdtri

    count = len(VARIANCES)
    weight, theta, r, variance, inverse = (np.repeat(each, count, axis=0) for each in flat[:5])
    variance = variance * np.tile(flat.nu / chdtri(flat.nu, VARIANCES), len(flat.ratio))
    sigma = np.sqrt(variance)
    with np.errstate(divide="ignore"):
        logarithm = np.log(weight)
        if TAU in priors:  # its density times d tau / d r
            median, spread = priors[TAU]
            off = np.log(r * sigma / median) / spread
            logarithm += np.where(r > 0.0, -0.5 * off**2 - np.log(np.maximum(r, 1e-300)), -np.inf)
        else:
            logarithm -= np.log1p((r / USUAL_RATIO) ** 2)
    for k, name in enumerate(names):
        if name in priors:
            mean, spread = priors[name]
            column = variance[:, None] * inverse[:, :, k]
            total = column[:, k] + spread**2
            off = mean - theta[:, free[k]]
            logarithm += -0.5 * (off**2 / total + np.log(total))
            theta = theta.copy()
            theta[:, free] += column * (off / total)[:, None]
            outer = column[:, :, None] * column[:, None, :] / total[:, None, None]
            inverse = inverse - outer / variance[:, None, None]
    kept = logarithm > logarithm.max() - NEGLIGIBLE
    weight = np.exp(logarithm[kept] - logarithm.max())
    parts = theta[kept], r[kept], variance[kept], inverse[kept]
    return Mixture(weight / weight.sum(), *parts, NORMAL)


class Part(NamedTuple):
    """One of several candidates: its `weight`, its fit, and the new tests as it describes them."""

    weight: float
    estimate: Estimate
    mixture: Mixture
    held: Problem


def tells_new_campaigns(estimate: Estimate, priors: Priors) -> bool:
    """Whether anything can be said of a new campaign: from three on, or with a prior of tau."""
    return estimate.problem.campaigns >= LEAST_CAMPAIGNS or TAU in priors


def _quantile(weight: Array, nu: Array, centre: Array, scale: Array, share: float) -> float:
    """Value which a `share` of a mixture of Student distributions (points,) lies below."""
    from scipy.optimize import brentq
    from scipy.special import stdtr

    def below(y: float) -> float:
        return float(weight @ stdtr(nu, (y - centre) / scale)) - share

    low = high = float(weight @ centre)
    width = 10.0 * float(np.max(scale[weight > 1e-12]))
    while below(low) > 0.0:
        low -= width
    while below(high) < 0.0:
        high += width
    return float(brentq(below, low, high, xtol=1e-9 * width))


def averaged_quantile(
    parts: Sequence[Part], shares: Sequence[float], median: Sequence[float] = ()
) -> Array:
    """Values (shares + median, n) that shares of a distribution lie below, in the unit of y.

    `shares`, of new tests in a new campaign; `median`, of what the tests tell of the median over
    campaigns. The distributions of the candidates are averaged with their weights.
    """
    weights, centres, scales, freedoms = [], [], [], []
    for weight, estimate, mixture, held in parts:
        free = np.flatnonzero(~estimate.at_bound)
        middle, x = held.predict(estimate.theta), jacobian(held, estimate.theta, free)
        spread = np.maximum(np.einsum("nj,kjl,nl->kn", x, mixture.inverse, x), 0.0)
        own = np.array([spread + 1.0 + mixture.ratio[:, None] ** 2, spread])
        scales.append(np.sqrt(mixture.variance[:, None] * own))
        centres.append(middle + (mixture.theta[:, free] - estimate.theta[free]) @ x.T)
        weights.append(weight * mixture.weight)
        freedoms.append(np.full(len(mixture.weight), float(mixture.nu)))
    centre, share_of, nu = (np.concatenate(each) for each in (centres, weights, freedoms))
    least = ROUND_OFF * max(1.0, float(np.max(np.abs(centre))))
    both = np.maximum(np.concatenate(scales, axis=1), least)
    found = []
    for scale, wanted in zip(both, (shares, median), strict=True):
        columns, index = np.unique(np.vstack([centre, scale]), axis=1, return_inverse=True)
        for share in wanted:
            each = [
                _quantile(share_of, nu, column[: len(nu)], column[len(nu) :], share)
                for column in columns.T
            ]
            found.append(np.array(each)[np.ravel(index)])
    return np.array(found)


def predictive_quantile(
    estimate: Estimate, held: Problem, share: float, priors: Priors = NOTHING
) -> Array:
    """Value (n,) below which a `share` of new tests in a new campaign lies, in the unit of y.

    Arguments: `held`, a problem whose rows describe the new tests (its y is not used); `priors`.
    Raises `InputError` for fewer than three campaigns behind the estimate without a prior of tau.
    """
    if not tells_new_campaigns(estimate, priors):
        count, reason = estimate.problem.campaigns, f"must be {LEAST_CAMPAIGNS} or more"
        advice = "fewer do not tell how much campaigns differ"
        raise InputError("campaigns", count, f"{reason} to say anything of a new campaign", advice)
    if estimate.is_exact:
        return held.predict(estimate.theta)
    part = Part(1.0, estimate, mixture_of(estimate, priors), held)
    return np.asarray(averaged_quantile([part], [share])[0])


def posterior_mean(estimate: Estimate, mixture: Mixture) -> Array:
    """Mean parameters (p,) of a mixture, within their bounds."""
    given = estimate.problem
    return np.asarray(np.clip(mixture.weight @ mixture.theta, given.lower, given.upper))


def posterior_intervals(
    estimate: Estimate, mixture: Mixture, confidence: float
) -> dict[str, Interval]:
    """Bayesian intervals of the free parameters and of ``tau`` under the priors of a mixture.

    Flat densities where no prior is given, of the logarithm of sigma too. Exact for linear
    predictions, otherwise with the prediction linear around each best fit.
    """
    tails = tails_of(confidence)
    free, nu = np.flatnonzero(~estimate.at_bound), np.full(len(mixture.weight), mixture.nu)
    ends: dict[str, tuple[float, float]] = {}
    for k, column in enumerate(free):
        scale = np.sqrt(np.maximum(mixture.variance * mixture.inverse[:, k, k], 1e-30))
        own = (mixture.weight, nu, mixture.theta[:, column], scale)
        low, high = (_quantile(*own, share) for share in tails)
        ends[estimate.problem.names[column]] = (low, high)
    tau = mixture.ratio * np.sqrt(mixture.variance)
    order = np.argsort(tau)
    low, high = np.interp(tails, np.cumsum(mixture.weight[order]), tau[order])
    ends[TAU] = (float(low), float(high))
    return {name: Interval(*each, confidence, "posterior") for name, each in ends.items()}
