"""Choice of the next design: a Gaussian process of what is known, and the largest expected
improvement.

First designs are drawn at random. From then on a Gaussian process (Matern 5/2, one length for each
variable; scikit-learn) of the logarithm of the objective gives mean and deviation of every
candidate, and the candidates are ordered by expected improvement times the probability that they
meet the limits. Candidates are all designs of a small space, else random ones and changes of the
best. Two objectives are joined by weights that are drawn anew for each design (ParEGO, Knowles,
IEEE Trans. Evol. Comput. 10, 2006). A choice depends on the seed, its number and the earlier
designs alone.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
import warnings
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from typing import Any

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray
from scipy.stats import norm

from granwave.extensions.design.search.variables import Space, Values

Array = NDArray[np.float64]
_ENUMERATED = 3000  # designs of a space up to which all are candidates
# candidates: random ones, and changes of each of the best
_RANDOM = 1024
_OF_BEST = 8
_CHANGES = 64
_MOST_RANDOM = 20_000  # draws in search of a design that was not tried
_LEAST_DEVIATION = 1e-9  # of a model
_LEAST_PROBABLE = 0.01  # probability to meet the limits, below which a candidate comes last
_MOST_MODELLED = 300  # designs that the model of the objective is made of
# designs that the model of a limit is made of, and the latest of them
_MOST_ROWS = 120
_LATEST = 40


@dataclasses.dataclass(frozen=True)
class Known:
    """A design of which something is known.

    Attributes
    ----------
    losses
        Objectives, each to be made small; None if not known, as of designs in work or refused.
    margins
        By limit: how far a value is beyond it, over the limit; negative or 0 where it is met.
    in_work
        True of a design that is being run.
    """

    values: Values
    losses: tuple[float, ...] | None
    margins: Mapping[str, float]
    in_work: bool = False

    @property
    def feasible(self) -> bool:
        """True if no known value is beyond its limit."""
        return all(margin <= 0 for margin in self.margins.values())


def n_first(space: Space, evaluations: int) -> int:
    """Return the number of designs that are drawn at random before the search is guided."""
    return max(2, min(len(space.variables) // 2 + 3, 10, evaluations // 3))


def random_designs(space: Space, seed: int, start: int = 0) -> Iterator[Values]:
    """Give designs at random, without end; those from the same start on are the same."""
    rng = np.random.default_rng([seed, start])
    while True:
        yield space.at(rng.random(len(space.variables)).tolist())


def ordered(space: Space, known: Sequence[Known], seed: int, *, guided: bool) -> Iterator[Values]:
    """Give designs that were not tried, the most promising first.

    Parameters
    ----------
    known
        Earlier designs: complete ones, refused ones and those in work.
    guided
        False: at random.
    """
    rng = np.random.default_rng([seed, len(known)])
    complete = [one for one in known if one.losses]
    if not guided or len(complete) < 2:
        yield from _drawn(space, known, seed, rng)
        return
    tried = {repr(one.values) for one in known}
    if space.size <= _ENUMERATED:
        found = [values for values in space.all() if repr(values) not in tried]
    else:
        drawn = itertools.islice(random_designs(space, int(rng.integers(2**31))), _RANDOM)
        best = sorted(complete, key=lambda one: (not one.feasible, one.losses))[:_OF_BEST]
        changed = [space.changed(one.values, rng) for one in best for _ in range(_CHANGES)]
        found = list(
            {
                repr(values): values for values in (*drawn, *changed) if repr(values) not in tried
            }.values()
        )
    if not found:
        return
    worth = worth_of(space, known, found, rng)
    for place in np.argsort(-worth, kind="stable"):
        yield found[place]


def promising(
    space: Space, known: Sequence[Known], seed: int, found: Sequence[Values]
) -> list[Values]:
    """Return those of some designs that were not tried, the most promising first."""
    tried = {repr(one.values) for one in known}
    left = [values for values in found if repr(values) not in tried]
    if len(left) < 2 or sum(one.losses is not None for one in known) < 2:
        return left
    worth = worth_of(space, known, left, np.random.default_rng([seed, len(known)]))
    return [left[place] for place in np.argsort(-worth, kind="stable")]


def _drawn(space: Space, known: Sequence[Known], seed: int, rng: Generator) -> Iterator[Values]:
    tried = {repr(one.values) for one in known}
    small = space.size <= _ENUMERATED
    left = (
        {repr(values): values for values in space.all() if repr(values) not in tried}
        if small
        else {}
    )
    for values in itertools.islice(random_designs(space, seed, len(known)), _MOST_RANDOM):
        name = repr(values)
        if name not in tried:
            tried.add(name)
            left.pop(name, None)
            yield values
        if small and not left:
            return
    rest = list(left.values())
    yield from (rest[n] for n in rng.permutation(len(rest)))


def worth_of(
    space: Space, known: Sequence[Known], found: Sequence[Values], rng: Generator
) -> Array:
    """Return what candidates are ordered by: (n,).

    It is the logarithm of the expected improvement where the limits may be met, and below that of
    all those the logarithm of the probability that they are.
    """
    complete = [one for one in known if one.losses]
    if len(complete) > _MOST_MODELLED:  # the best and the latest, in their order
        half = _MOST_MODELLED // 2
        ranked = sorted(
            range(len(complete)), key=lambda n: (not complete[n].feasible, complete[n].losses)
        )
        complete = [
            complete[n]
            for n in sorted({*ranked[:half], *range(len(complete) - half, len(complete))})
        ]
    designs = [one.values for one in complete]
    scores = joined(np.array([one.losses for one in complete]), rng)
    feasible = np.array([one.feasible for one in complete])
    x = space.features(found)
    model = fitted(space, designs, scores)
    pending = [one.values for one in known if one.losses is None and one.in_work]
    if pending:  # as if they had been found to be what is expected
        scores_too = np.concatenate([scores, model.predict(space.features(pending))])
        model = fitted(space, [*designs, *pending], scores_too)
    mean, deviation = model.predict(x, return_std=True)
    deviation = np.maximum(deviation, _LEAST_DEVIATION)
    worth = np.zeros(len(x))  # first of all a design that meets the limits
    if feasible.any():
        z = (scores[feasible].min() - mean) / deviation
        far = z < -6  # where the difference of the two terms is lost to rounding
        near = np.where(far, 0.0, z)
        away = np.where(far, z, 1.0)
        improvement = np.log(norm.pdf(near) + near * norm.cdf(near))
        worth = np.log(deviation) + np.where(
            far, norm.logpdf(z) - 2 * np.log(np.abs(away)), improvement
        )
    within = np.zeros(len(x))
    for limit in _limits(space, known, rng):
        middle, width = limit.predict(x, return_std=True)
        within += norm.logcdf(-middle / np.maximum(width, _LEAST_DEVIATION))
    hopeless = within < math.log(_LEAST_PROBABLE)
    return np.where(hopeless, within + worth.min() - 1, worth + within)


def joined(losses: Array, rng: Generator | None = None) -> Array:
    """Join objectives to one number for each design: logarithms of positive ones, weighted anew at
    each call.
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
    joint: Array = weighted.max(axis=0) + 0.05 * weighted.sum(axis=0)
    return joint


@cache
def _threads() -> Any:
    from threadpoolctl import ThreadpoolController  # comes with scikit-learn

    return ThreadpoolController()


def _scaled(losses: Array) -> Array:
    """Return the logarithms of losses that all have one sign, in their order; others as they are."""
    if (losses > 0).all():
        return np.log(losses)
    return -np.log(-losses) if (losses < 0).all() else losses


def fitted(space: Space, designs: Sequence[Values], values: Array) -> Any:
    """Return the Gaussian process (of scikit-learn) of a quantity over the designs of a space."""
    from sklearn.gaussian_process import GaussianProcessRegressor
    from sklearn.gaussian_process.kernels import ConstantKernel, Matern, WhiteKernel

    x = space.features(designs)
    matern = Matern(np.ones(x.shape[1]), (0.1, 10.0), nu=2.5)
    kernel = ConstantKernel(1.0, (1e-2, 1e2)) * matern + WhiteKernel(1e-4, (1e-8, 0.1))
    with (
        warnings.catch_warnings(),
        _threads().limit(limits=1),
    ):  # on small matrices threads wait for each other
        warnings.simplefilter("ignore")  # a length at its bound
        return GaussianProcessRegressor(kernel, normalize_y=True).fit(x, values)


def importance(space: Space, known: Sequence[Known], n: int = 512) -> dict[str, float]:
    """Return the share of the variance of the first objective that each variable makes alone
    (first-order Sobol index).

    Of the fitted model over the whole space; what is missing from 1 are joint effects.
    """
    complete = [one for one in known if one.losses]
    if len(complete) < 4:
        return {}
    losses = np.array([one.losses for one in complete])
    model = fitted(space, [one.values for one in complete], joined(losses[:, :1]))
    drawn = random_designs(space, 1)
    first, second = ([next(drawn) for _ in range(n)] for _ in range(2))
    a, b = (model.predict(space.features(designs)) for designs in (first, second))
    variance = float(np.var(np.concatenate([a, b])))
    if not variance:
        return {}
    found = {}
    for one in space.variables:
        mixed = [
            {**left, one.key: right[one.key]} for left, right in zip(first, second, strict=True)
        ]
        found[one.key] = float(np.mean(b * (model.predict(space.features(mixed)) - a)) / variance)
    return {
        key: min(max(share, 0.0), 1.0) if math.isfinite(share) else 0.0
        for key, share in found.items()
    }


def front(losses: Sequence[Sequence[float]]) -> list[int]:
    """Return the places of the designs that none of the others beats in all objectives, by the
    first objective.
    """
    table = [tuple(row) for row in losses]
    places = {row: n for n, row in reversed(list(enumerate(table)))}  # the first of equal ones
    values = np.array(list(places))
    beaten = [
        bool(((values <= row).all(axis=1) & (values != row).any(axis=1)).any()) for row in values
    ]
    return [places[row] for row, worse in sorted(zip(places, beaten, strict=True)) if not worse]


def expected_random(space: Space, known: Sequence[Known], counts: Sequence[int]) -> list[float]:
    """Return the smallest first loss that so many designs at random would have, in the mean, by the
    fitted model.

    Only of designs that the model takes to be within the limits; empty where too little is known.
    """
    complete = [one for one in known if one.losses]
    losses = np.array([one.losses[0] for one in complete if one.losses])
    if len(complete) < 4 or not ((losses > 0).all() or (losses < 0).all()):
        return []
    drawn = list(itertools.islice(random_designs(space, 2), 2 * _RANDOM))
    x = space.features(drawn)
    within = np.ones(len(x), dtype=bool)
    for model in _limits(space, known, np.random.default_rng(3)):
        within &= model.predict(x) <= 0
    sign = math.copysign(1.0, losses[0])
    if not within.any():
        return []
    scaled = fitted(space, [one.values for one in complete], _scaled(losses)).predict(x[within])
    found = sign * np.exp(sign * np.sort(scaled))
    places = np.arange(len(found) + 1) / len(found)
    return [float(found @ ((1 - places[:-1]) ** n - (1 - places[1:]) ** n)) for n in counts]


def _limits(space: Space, known: Sequence[Known], rng: Generator) -> Iterator[Any]:
    """Give a model of how far each limit is exceeded, of those that some designs exceed."""
    for name in dict.fromkeys(name for one in known for name in one.margins):
        rows = [one for one in known if name in one.margins]
        if (
            any(one.margins[name] > 0 for one in rows)
            and len({one.margins[name] for one in rows}) > 1
        ):
            if len(rows) > _MOST_ROWS:  # those that were run, the latest, and some of the others
                kept = {n for n, one in enumerate(rows) if one.losses} | set(
                    range(len(rows) - _LATEST, len(rows))
                )
                rest = rng.permutation([n for n in range(len(rows)) if n not in kept])
                rows = [rows[n] for n in sorted({*kept, *rest[: max(0, _MOST_ROWS - len(kept))]})]
            margins = np.array([one.margins[name] for one in rows])
            yield fitted(space, [one.values for one in rows], np.arcsinh(3 * margins))
