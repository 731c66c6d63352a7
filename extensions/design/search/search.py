"""Choice of the next design: a Gaussian process of the designs so far, and the largest expected
improvement.

First designs are drawn at random. From then on a Gaussian process (Matern 5/2, one length for each
variable; scikit-learn) of the logarithm of the objective gives mean and standard deviation of every
candidate. The candidates are ordered by expected improvement times the probability that they meet
the limits. Candidates are all designs of a small space, otherwise random designs and modifications
of the best designs. Two objectives are joined by weights that are drawn again for each design
(ParEGO, Knowles, IEEE Trans. Evol. Comput. 10, 2006). A choice depends only on the seed, on its
number and on the earlier designs.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
import warnings
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cache
from typing import Any

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray
from scipy.stats import norm

from granwave.extensions.design.search.variables import Space, Values

Array = NDArray[np.float64]
_ENUMERATED = 3000  # number of designs of a space up to which all are candidates
_RANDOM = 1024  # random candidates of a larger space
_OF_BEST = 8  # best designs whose changes are candidates
_CHANGES = 64  # candidates made from each of these
_MOST_RANDOM = 20_000  # draws in the search for an untried design
_LEAST_DEVIATION = 1e-9  # smallest standard deviation of a prediction
_LEAST_PROBABLE = 0.01  # probability of meeting the limits, below which a candidate comes last
_MOST_MODELLED = 300  # largest number of designs in the model of the objective
_MOST_ROWS = 120  # largest number of designs in the model of a limit
_LATEST = 40  # latest designs that the model of a limit always contains
_FAR = -6  # below this value the two terms of the expected improvement cancel to rounding
_JOINT = 0.05  # weight of the sum of two objectives in their joint loss (ParEGO)
_FEWEST_MODELLED = 4  # complete designs that a model of the whole space needs


@dataclasses.dataclass(frozen=True)
class TriedDesign:
    """A design that was run or rejected, or is being run.

    Attributes
    ----------
    losses
        Objectives, each to be minimised; None for designs that are rejected or still running.
    margins
        Relative distance of a value beyond its limit, by limit; negative or 0 where it is met.
    in_work
        True for a design that is being run.
    """

    values: Values
    losses: tuple[float, ...] | None
    margins: Mapping[str, float]
    in_work: bool = False

    @property
    def feasible(self) -> bool:
        """True if no value is beyond its limit."""
        return all(margin <= 0 for margin in self.margins.values())


def n_first(space: Space, evaluations: int) -> int:
    """Return the number of designs that are drawn at random before the search is guided."""
    return max(2, min(len(space.variables) // 2 + 3, 10, evaluations // 3))


def random_designs(space: Space, seed: int, start: int = 0) -> Iterator[Values]:
    """Yield random designs without end, reproducible for the same seed and start."""
    rng = np.random.default_rng([seed, start])
    while True:
        yield space.at(rng.random(len(space.variables)).tolist())


def ordered(
    space: Space, designs: Sequence[TriedDesign], seed: int, *, guided: bool
) -> Iterator[Values]:
    """Yield designs that were not tried, the most promising first.

    Parameters
    ----------
    designs
        Earlier designs: complete, rejected and running ones.
    guided
        False: at random.
    """
    rng = np.random.default_rng([seed, len(designs)])
    if not guided or len(_complete(designs)) < 2:
        yield from _drawn(space, designs, seed, rng)
        return
    candidates = _candidates(space, designs, rng)
    if not candidates:
        return
    worth = worth_of(space, designs, candidates, rng)
    for place in np.argsort(-worth, kind="stable"):
        yield candidates[place]


def promising(
    space: Space, designs: Sequence[TriedDesign], seed: int, candidates: Sequence[Values]
) -> list[Values]:
    """Return the candidates that were not tried, the most promising first."""
    tried = _names(designs)
    left = [values for values in candidates if repr(values) not in tried]
    if len(left) < 2 or len(_complete(designs)) < 2:
        return left
    worth = worth_of(space, designs, left, np.random.default_rng([seed, len(designs)]))
    return [left[place] for place in np.argsort(-worth, kind="stable")]


def _complete(designs: Iterable[TriedDesign]) -> list[TriedDesign]:
    """Return the designs with objectives."""
    return [design for design in designs if design.losses]


def _names(designs: Iterable[TriedDesign]) -> set[str]:
    """Return a text for each design, by which designs are compared."""
    return {repr(design.values) for design in designs}


def _by_loss(design: TriedDesign) -> tuple[bool, tuple[float, ...]]:
    """Return the rank of a complete design by its losses; designs within the limits come first."""
    return not design.feasible, design.losses or ()


def _candidates(space: Space, designs: Sequence[TriedDesign], rng: Generator) -> list[Values]:
    """Return all untried designs of a small space, otherwise random designs and modifications of
    the best designs.
    """
    tried = _names(designs)
    if space.size <= _ENUMERATED:
        return [values for values in space.all() if repr(values) not in tried]
    drawn = random_designs(space, int(rng.integers(2**31)))
    candidates = list(itertools.islice(drawn, _RANDOM))
    for design in sorted(_complete(designs), key=_by_loss)[:_OF_BEST]:
        candidates += [space.changed(design.values, rng) for _ in range(_CHANGES)]
    untried = {repr(values): values for values in candidates if repr(values) not in tried}
    return list(untried.values())


def _drawn(
    space: Space, designs: Sequence[TriedDesign], seed: int, rng: Generator
) -> Iterator[Values]:
    """Yield untried designs at random; of a small space finally all others."""
    tried = _names(designs)
    left: dict[str, Values] = {}
    is_small = space.size <= _ENUMERATED
    if is_small:
        left = {repr(values): values for values in space.all() if repr(values) not in tried}
    for values in itertools.islice(random_designs(space, seed, len(designs)), _MOST_RANDOM):
        name = repr(values)
        if name not in tried:
            tried.add(name)
            left.pop(name, None)
            yield values
        if is_small and not left:
            return
    rest = list(left.values())
    yield from (rest[n] for n in rng.permutation(len(rest)))


def worth_of(
    space: Space, tried: Sequence[TriedDesign], candidates: Sequence[Values], rng: Generator
) -> Array:
    """Return the worth of candidates, by which they are ordered: (n,).

    The worth is the logarithm of the expected improvement plus the logarithm of the probability
    that the limits are met. Candidates with a small probability come last, ordered by this
    probability.
    """
    complete = _best_and_latest(_complete(tried))
    designs = [design.values for design in complete]
    scores = joined(np.array([design.losses for design in complete]), rng)
    feasible = np.array([design.feasible for design in complete])
    x = space.features(candidates)
    model = fitted(space, designs, scores)
    running = [design.values for design in tried if design.losses is None and design.in_work]
    if running:  # predictions replace the results of running designs
        predictions = model.predict(space.features(running))
        model = fitted(space, [*designs, *running], np.concatenate([scores, predictions]))
    mean, deviation = model.predict(x, return_std=True)
    worth = np.zeros(len(x))  # without a feasible design only the limits count
    if feasible.any():
        least = float(scores[feasible].min())
        worth = _log_improvement(least, mean, np.maximum(deviation, _LEAST_DEVIATION))
    log_probability = np.zeros(len(x))
    for limit in _limits(space, tried, rng):
        middle, width = limit.predict(x, return_std=True)
        log_probability += norm.logcdf(-middle / np.maximum(width, _LEAST_DEVIATION))
    hopeless = log_probability < math.log(_LEAST_PROBABLE)
    return np.where(hopeless, log_probability + worth.min() - 1, worth + log_probability)


def _best_and_latest(complete: list[TriedDesign]) -> list[TriedDesign]:
    """Return the designs for the model of the objective, in their order."""
    if len(complete) <= _MOST_MODELLED:
        return complete
    half = _MOST_MODELLED // 2
    ranked = sorted(range(len(complete)), key=lambda n: _by_loss(complete[n]))
    latest = range(len(complete) - half, len(complete))
    return [complete[n] for n in sorted({*ranked[:half], *latest})]


def _log_improvement(least: float, mean: Array, deviation: Array) -> Array:
    """Return the logarithm of the expected improvement of a smallest score: (n,)."""
    z = (least - mean) / deviation
    far = z < _FAR
    near_z = np.where(far, 0.0, z)
    far_z = np.where(far, z, 1.0)
    improvement = np.log(norm.pdf(near_z) + near_z * norm.cdf(near_z))
    asymptote = norm.logpdf(z) - 2 * np.log(np.abs(far_z))
    return np.asarray(np.log(deviation) + np.where(far, asymptote, improvement))


def joined(losses: Array, rng: Generator | None = None) -> Array:
    """Join the objectives of designs, (n, n_objectives), to a score for each: (n,).

    Positive objectives count by their logarithms; several have random weights, drawn at each call.
    """
    columns = []
    for column in losses.T:
        scaled = _scaled(column)
        spread = float(np.ptp(scaled))
        columns.append((scaled - scaled.min()) / (spread or 1.0))
    if len(columns) == 1:
        return columns[0]
    weights = (rng or np.random.default_rng(0)).dirichlet(np.ones(len(columns)))
    weighted = np.array([weight * column for weight, column in zip(weights, columns, strict=True)])
    joint: Array = weighted.max(axis=0) + _JOINT * weighted.sum(axis=0)
    return joint


@cache
def _threads() -> Any:
    from threadpoolctl import ThreadpoolController  # comes with scikit-learn

    return ThreadpoolController()


def _scaled(losses: Array) -> Array:
    """Return the logarithms of losses with the same sign, in their order;
    other losses unchanged.
    """
    if (losses > 0).all():
        return np.log(losses)
    if (losses < 0).all():
        return -np.log(-losses)
    return losses


def fitted(space: Space, designs: Sequence[Values], values: Array) -> Any:
    """Return the Gaussian process (of scikit-learn) of a quantity over the designs of a space."""
    from sklearn.gaussian_process import GaussianProcessRegressor
    from sklearn.gaussian_process.kernels import ConstantKernel, Matern, WhiteKernel

    x = space.features(designs)
    matern = Matern(np.ones(x.shape[1]), (0.1, 10.0), nu=2.5)
    kernel = ConstantKernel(1.0, (1e-2, 1e2)) * matern + WhiteKernel(1e-4, (1e-8, 0.1))
    # on small matrices several threads are slower than one
    with warnings.catch_warnings(), _threads().limit(limits=1):
        warnings.simplefilter("ignore")  # a length at its bound
        return GaussianProcessRegressor(kernel, normalize_y=True).fit(x, values)


def importance(space: Space, designs: Sequence[TriedDesign], n: int = 2048) -> dict[str, float]:
    """Return the fraction of the variance of the first objective due to each variable alone
    (first-order Sobol index).

    The variance is computed over the complete space with the fitted model, by Jansen's estimator:
    half of the mean square of the difference of two designs with equal values of this variable is
    the variance due to the others. The fractions sum to less than 1 if several variables have joint
    effects. A larger sum, by errors of sampling, is reduced to 1.
    """
    complete = _complete(designs)
    if len(complete) < _FEWEST_MODELLED:
        return {}
    losses = np.array([design.losses for design in complete])
    model = fitted(space, [design.values for design in complete], joined(losses[:, :1]))
    drawn = random_designs(space, 1)
    first = list(itertools.islice(drawn, n))
    second = list(itertools.islice(drawn, n))
    first_scores = model.predict(space.features(first))
    second_scores = model.predict(space.features(second))
    variance = float(np.var(np.concatenate([first_scores, second_scores])))
    if not variance:
        return {}
    indices = {}
    for variable in space.variables:
        key = variable.key
        mixed = [{**a, key: b[key]} for a, b in zip(first, second, strict=True)]
        change = second_scores - model.predict(space.features(mixed))
        index = 1 - 0.5 * float(np.mean(change**2)) / variance
        indices[key] = min(max(index, 0.0), 1.0) if math.isfinite(index) else 0.0
    total = max(1.0, sum(indices.values()))
    return {key: index / total for key, index in indices.items()}


def front(losses: Sequence[Sequence[float]]) -> list[int]:
    """Return the positions of the designs on the Pareto front, by the first objective.

    A design is on the front if no other design is at least as good in all objectives and better in
    one. Of equal designs the first one is used.
    """
    table = [tuple(row) for row in losses]
    places = {row: n for n, row in reversed(list(enumerate(table)))}
    values = np.array(list(places))
    on_front = []
    for row, place in places.items():
        better = (values <= row).all(axis=1) & (values != row).any(axis=1)
        if not better.any():
            on_front.append((row, place))
    return [place for _, place in sorted(on_front)]


def expected_random(
    space: Space, designs: Sequence[TriedDesign], counts: Sequence[int]
) -> list[float]:
    """Return the expected smallest first loss among each number of random designs, by the model.

    Only designs that meet the limits according to the model count. Empty if too few designs are
    complete.
    """
    complete = _complete(designs)
    losses = np.array([design.losses[0] for design in complete if design.losses])
    if len(complete) < _FEWEST_MODELLED or not ((losses > 0).all() or (losses < 0).all()):
        return []
    drawn = list(itertools.islice(random_designs(space, 2), 2 * _RANDOM))
    x = space.features(drawn)
    within = np.ones(len(x), dtype=bool)
    for model in _limits(space, designs, np.random.default_rng(3)):
        within &= model.predict(x) <= 0
    if not within.any():
        return []
    sign = math.copysign(1.0, losses[0])
    model = fitted(space, [design.values for design in complete], _scaled(losses))
    sorted_losses = sign * np.exp(sign * np.sort(model.predict(x[within])))
    ranks = np.arange(len(sorted_losses) + 1) / len(sorted_losses)
    return [float(sorted_losses @ ((1 - ranks[:-1]) ** n - (1 - ranks[1:]) ** n)) for n in counts]


def _limits(space: Space, designs: Sequence[TriedDesign], rng: Generator) -> Iterator[Any]:
    """Return a model of the margin of each limit that some designs exceed."""
    names: dict[str, None] = {}
    for design in designs:
        names.update(dict.fromkeys(design.margins))
    for name in names:
        rows = [design for design in designs if name in design.margins]
        margins = {design.margins[name] for design in rows}
        if max(margins) > 0 and len(margins) > 1:
            rows = _limited_rows(rows, rng)
            values = np.arcsinh(3 * np.array([design.margins[name] for design in rows]))
            yield fitted(space, [design.values for design in rows], values)


def _limited_rows(rows: list[TriedDesign], rng: Generator) -> list[TriedDesign]:
    """Return the designs for the model of a limit: complete designs, the latest designs, and some
    others.
    """
    if len(rows) <= _MOST_ROWS:
        return rows
    kept = {n for n, design in enumerate(rows) if design.losses}
    kept |= set(range(len(rows) - _LATEST, len(rows)))
    rest = rng.permutation([n for n in range(len(rows)) if n not in kept])
    others = rest[: max(0, _MOST_ROWS - len(kept))]
    return [rows[n] for n in sorted({*kept, *others})]
