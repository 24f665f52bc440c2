"""From the fingers that were measured to the population they come from, each finger pulled towards it."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import minimize
from scipy.stats import chi2

from frictionloop.findings import Finding
from frictionloop.identification.estimate import Estimate, Interval, Measured, measured
from frictionloop.identification.project_entry_result import EntryResult
from frictionloop.parameters.population import Population, Spread
from frictionloop.quantities import Array, must_be, unit_of

TAU = "friction.susceptibility_per_um2"

LEAST_FINGERS, LEAST_CORRELATED, SURE_FINGERS = 3, 5, 8
"""Fingers from which a spread is told, from which a correlation is (of three or four it is often 1 by chance), and from
which neither is rough (assumed)."""
Entry = Mapping[str, Sequence[float]]
"""Path -> (logarithm of the value, its standard error), of one recording or slide."""


class FingerSpread(NamedTuple):
    """How far fingers differ: the standard deviation of a logarithm over fingers."""

    value: float
    total: float
    """Variance of the fingers' means, value^2 and what scatters within a finger."""
    noise: float
    """The latter."""
    freedom: float

    def interval(self, confidence: float = 0.95) -> Interval:
        """Return the interval from that of the whole variance, a chi square over its degrees of freedom."""
        ends = chi2.ppf([(1 + confidence) / 2, (1 - confidence) / 2], self.freedom)
        squares = np.maximum(self.freedom * self.total / ends - self.noise, 0.0)
        return Interval(*np.sqrt(squares).tolist())

    def __str__(self) -> str:
        """Value, and the interval of 95 % in brackets."""
        low, high = self.interval()
        return f"{self.value:.2g} ({low:.2g} to {high:.2g})"


@dataclass(frozen=True)
class People:
    """A population, and its fingers."""

    population: Population
    medians: tuple[Estimate, ...]
    spreads: tuple[FingerSpread, ...]
    """Of the logarithms, from finger to finger, what scatters within one taken off."""
    correlations: tuple[tuple[str, str, Estimate], ...]
    within: Array
    """Standard deviation of the logarithm within a finger, from recording to recording, shape (values,)."""
    names: tuple[str, ...]
    raw: Array
    """Logarithms of the fingers' own means, shape (fingers, values)."""
    pooled: Array
    """The same, pulled towards the population as far as they are uncertain."""

    @property
    def findings(self) -> tuple[Finding, ...]:
        """What so few fingers do not tell."""
        return tuple(few_fingers(len(self.names)))

    def numbers(self) -> dict[str, Any]:
        """Return medians, spreads of logarithms with their intervals, and correlations, by name."""
        found: dict[str, Any] = {"fingers": len(self.names)}
        for each, median, spread in zip(self.population.value, self.medians, self.spreads, strict=True):
            found |= {f"median {each.path}": median, f"spread {each.path}": [spread.value, *spread.interval()]}
        return found | {f"{a} with {b}": estimate for a, b, estimate in self.correlations}

    def to_dict(self) -> dict[str, Any]:
        """Return the population and how sure it is, by name."""
        return {"population": self.population, "fingers": self.names, **self.numbers()}


def few_fingers(count: int) -> Iterator[Finding]:
    """Yield what so many fingers do not tell."""
    needed = {"a population": LEAST_FINGERS, "correlations": LEAST_CORRELATED, "sure spreads": SURE_FINGERS}
    for what, least in needed.items():
        if count < least:
            yield Finding("FEW-FINGERS", value=count, limit=least, more={"what": what})
            return


def people(measured: Mapping[str, Sequence[Entry]]) -> People:
    """Return the population of fingers by empirical Bayes: partial pooling with the spreads from the data themselves.

        x_ij = m_i + within,   m_i ~ N(mu, S),   pooled m_i = mu + S (S + V_i)^-1 (mean x_i - mu)

    x are logarithms; V_i is the covariance within a finger over its number of recordings (from repeated recordings, or
    their own errors where none is repeated); S is found by restricted maximum likelihood, mu by weighted least squares.

    Parameters
    ----------
    measured : mapping
        Finger -> one entry for each of its recordings, path -> (logarithm, its standard error); all of the same paths.

    Raises
    ------
    FrictionloopError
        For fewer than three fingers, or entries of different paths.
    """
    names = tuple(measured)
    if len(names) < LEAST_FINGERS:
        raise must_be("fingers", len(names), f"at least {LEAST_FINGERS}")
    paths = tuple(next(iter(measured.values()))[0])
    if any(tuple(entry) != paths for entries in measured.values() for entry in entries):
        raise must_be("fingers", "unlike", f"all with {', '.join(paths)}")
    values = [np.array([[entry[path][0] for path in paths] for entry in measured[name]]) for name in names]
    errors = [np.array([[entry[path][1] for path in paths] for entry in measured[name]]) for name in names]
    counts = np.array([len(each) for each in values])
    raw = np.array([each.mean(axis=0) for each in values])
    inside = _within(values, errors)
    noise = np.array([inside / count for count in counts])
    between, mu = _restricted(raw, noise)
    weights = between @ np.linalg.inv(between + noise)
    pooled = mu + np.einsum("ijk,ik->ij", weights, raw - mu)
    inner = np.diag(np.mean(noise, axis=0))
    total, spread = np.diag(between) + inner, np.sqrt(np.maximum(np.diag(between), 0.0))
    medians, spreads, value = [], [], []
    for path, m, s, t, v in zip(paths, mu, spread, total, inner, strict=True):
        median = math.exp(m)
        medians.append(Estimate(median, median * math.sqrt(t / len(names)), unit_of(path), len(names) - 1.0))
        spreads.append(FingerSpread(float(s), float(t), float(v), len(names) - 1.0))
        value.append(Spread(path=path, median=float(f"{median:.6g}"), spread=float(f"{s:.4g}")))
    safe = np.where(spread > 0, spread, 1.0)
    matrix = between / np.outer(safe, safe) if len(names) >= LEAST_CORRELATED else np.eye(len(paths))
    np.fill_diagonal(matrix, 1.0)
    freedom = len(names) - 2.0
    pairs = []
    for a in range(len(paths) if len(names) >= LEAST_CORRELATED else 0):
        for b, r in enumerate(matrix[a, :a].tolist()):
            pairs.append((paths[a], paths[b], Estimate(r, (1 - r * r) / math.sqrt(freedom), "", freedom)))
    rows = tuple(tuple(round(float(each), 4) for each in row) for row in matrix) if len(paths) > 1 else ()
    population = Population(fingers=len(names), value=tuple(value), correlation=rows)
    within = np.sqrt(np.diag(inside))
    return People(population, tuple(medians), tuple(spreads), tuple(pairs), within, names, raw, pooled)


def _within(values: Sequence[Array], errors: Sequence[Array]) -> Array:
    """Return the covariance from recording to recording of a finger, at least that of the recordings' own errors."""
    own = np.diag(np.mean(np.concatenate(errors) ** 2, axis=0))
    freedom = sum(len(each) - 1 for each in values)
    if freedom == 0:
        return own
    scatter = sum((each - each.mean(axis=0)).T @ (each - each.mean(axis=0)) for each in values) / freedom
    short = np.maximum(np.diag(own) - np.diag(scatter), 0.0)
    return np.asarray(scatter + np.diag(short))


def _restricted(raw: Array, noise: Array) -> tuple[Array, Array]:
    """Return the covariance from finger to finger and the mean: least of the restricted -2 log likelihood."""
    size = raw.shape[1]
    lower = np.tril_indices(size)
    start = np.atleast_2d(np.cov(raw.T)) - noise.mean(axis=0)
    power, direction = np.linalg.eigh(start)
    floor = 1e-3 * max(float(np.max(np.diag(np.atleast_2d(np.cov(raw.T))))), 1e-12)
    start = direction @ np.diag(np.maximum(power, floor)) @ direction.T

    def parts(x: Array) -> tuple[Array, Array, float]:
        root = np.zeros((size, size))
        root[lower] = x
        between = root @ root.T
        inverse = np.linalg.inv(between + noise)
        precision = inverse.sum(axis=0)
        mu = np.linalg.solve(precision, np.einsum("ijk,ik->j", inverse, raw))
        away = raw - mu
        cost = float(np.einsum("ij,ijk,ik->", away, inverse, away))
        cost += float(np.linalg.slogdet(precision)[1] - np.sum(np.linalg.slogdet(inverse)[1]))
        return between, mu, cost

    found = minimize(lambda x: parts(x)[2], np.linalg.cholesky(start)[lower], method="Nelder-Mead",
                     options={"xatol": 1e-7, "fatol": 1e-9, "maxiter": 4000, "maxfev": 4000})  # fmt: skip
    between, mu, _ = parts(found.x)
    return between, mu


def together(parts: Sequence[EntryResult]) -> tuple[People | None, list[Measured], list[Finding]]:
    """Return the population that the fingers of slides make, its medians as measured values, and what is said of it."""
    persons = [(part, part.curves["person"]) for part in parts if part.curves.get("person")]
    # Recordings with amplitude commands tell tau too; then those count alone.
    with_tau = [pair for pair in persons if TAU in pair[1]["found"][0]]
    used = with_tau if len({person["finger"] for _, person in with_tau}) >= LEAST_FINGERS else persons
    paths = set.intersection(*({*person["found"][0]} for _, person in used)) if used else set()
    entries: dict[str, list[Mapping[str, Any]]] = {}
    for _, person in used:
        for each in person["found"]:
            entries.setdefault(person["finger"], []).append({path: each[path] for path in sorted(paths)})
    if len(entries) < LEAST_FINGERS:
        return None, [], list(few_fingers(len(entries))) if entries else []
    found = people(entries)
    files = tuple(dict.fromkeys(each["path"] for part, _ in used for each in part.files))
    date = used[0][0].files[0]["date"]
    values = [
        replace(_median(path, median, float(scatter), len(entries)), files=files, date=date)
        for path, median, scatter in zip(sorted(paths), found.medians, found.within, strict=True)
    ]
    return found, values, list(found.findings)


def _median(path: str, median: Estimate, scatter: float, count: int) -> Measured:
    """Return a median over fingers: what scatters within one is chance, the rest of its error is between them."""
    within = min(median.value * scatter / math.sqrt(count), median.standard_error)
    between = math.sqrt(max(median.standard_error**2 - within**2, 0.0))
    value = measured(path, [median], None, f"median of {count} fingers, partial pooling")
    return replace(value, within=within, between=between)
