"""The search of gicube-explore, which proposes configurations in rounds."""
import itertools
import math
import random
import warnings

from studies.runs import InputError, RunFailed
from studies.table import on_front

ROUND = 10  # chosen: parallel points; more points learn less from each other
START = 20  # chosen, like those below, by the measurement of docs/guide/explore.md
CANDIDATES = 8
NEIGHBOURS = 5  # of a round, beside points of the front; the sampler proposes the others
GOOD = 18  # the share of points that count as good is 0.3, up to this many: their hypervolumes take the sampler's time


def import_optuna():
    try:
        import optuna
    except ImportError as error:
        raise RunFailed(f"gicube-explore: expected optuna (Debian package python3-optuna), got {error}") from error
    optuna.logging.set_verbosity(optuna.logging.ERROR)
    warnings.filterwarnings("ignore", category=optuna.exceptions.ExperimentalWarning)
    return optuna


def size_of(parameters):
    return math.prod(len(values) for _, values in parameters)


def search(parameters, count, seed, measure):
    """Proposes different configurations until `count` are accepted. measure(round) takes a list of dictionaries, and
    returns for each (figures to minimise, violations of the constraints, 0 for one that holds), or None for a refused
    one; it returns None for the list to end the search. Equal seeds and figures give equal searches. Returns whether
    the search is complete."""
    optuna = import_optuna()
    space = {name: optuna.distributions.IntDistribution(0, len(values) - 1) for name, values in parameters}
    sampler = optuna.samplers.TPESampler(seed=seed, n_startup_trials=START, multivariate=True,
                                         n_ei_candidates=CANDIDATES,
                                         gamma=lambda n: max(1, min(math.ceil(0.3 * n), GOOD)),
                                         constraints_func=lambda trial: trial.user_attrs["violations"])
    study, chance, found = None, random.Random(seed), {}
    corners = [{name: 0 for name, _ in parameters}, {name: len(values) - 1 for name, values in parameters}]
    accepted = 0
    while accepted < count and len(found) < size_of(parameters):
        wanted = min(ROUND, count - accepted)
        asked, known = dict.fromkeys(neighbours(parameters, found, chance)[:min(NEIGHBOURS, wanted)]
                                     if study is not None else []), 0
        while len(asked) < wanted and len(found) + len(asked) < size_of(parameters):
            if study is None:  # before the first figures
                place = tuple((corners.pop(0) if corners else {name: chance.randrange(len(values)) for name,
                    values in parameters}).values())
                trial = None
            # the sampler repeats a point, or has no choice
            elif known > ROUND or count == size_of(parameters):
                place, trial = unseen(parameters, found.keys() | asked.keys(), chance), None
            else:
                trial = study.ask(space)
                place = tuple(trial.params[name] for name, _ in parameters)
            if place not in found and place not in asked:
                asked[place] = trial
                continue
            known += 1
            if trial:
                tell(optuna, study, trial, None)
        settings = [{name: values[i] for (name, values), i in zip(parameters, place)} for place in asked]
        results = measure(settings)
        if results is None:
            return False
        for (place, trial), result in zip(asked.items(), results):
            found[place] = result
            accepted += result is not None
            if result is None:
                if trial:
                    tell(optuna, study, trial, None)
                continue
            if study is None:
                study = optuna.create_study(directions=["minimize"] * len(result[0]), sampler=sampler)
            if trial:
                tell(optuna, study, trial, result)
            else:
                values, violations = told(result)
                study.add_trial(optuna.trial.create_trial(
                    params={name: i for (name, _), i in zip(parameters, place)}, distributions=space, values=values,
                    user_attrs={"violations": violations}, system_attrs={"constraints": violations}))
    return True


def neighbours(parameters, found, chance):
    """New configurations, one step of one field beside the front of the measured ones, in a random order. Those beside
    points with much of the front's hypervolume tend to come first. If all points violate a constraint, the front has
    those with the least violations."""
    measured = {place: result for place, result in found.items() if result is not None}
    least = min((sum(violations) for _, violations in measured.values()), default=0)
    valid = {place: told(result)[0] for place, result in measured.items() if sum(result[1]) <= least}
    front = {place: values for (place, values), on in zip(valid.items(), on_front(list(map(tuple, valid.values()))))
             if on}
    ranges = [(min(each), max(each)) for each in zip(*valid.values())]
    scaled = {place: [(value - low) / ((high - low) or 1) for value, (low, high) in zip(values, ranges)] for place,
              values in front.items()}
    worst = [1.01] * len(ranges)  # the ends of the front also count
    whole = hypervolume(list(scaled.values()), worst)
    weights = {}
    for place in front:
        share = whole - hypervolume([values for other, values in scaled.items() if other != place], worst)
        for axis, (_, values) in enumerate(parameters):
            for step in (-1, 1):
                beside = (*place[:axis], place[axis] + step, *place[axis + 1:])
                if 0 <= beside[axis] < len(values) and beside not in found:
                    weights[beside] = weights.get(beside, 0) + share + 1e-9
    return sorted(weights, key=lambda place: -weights[place] * chance.random())


def told(result):
    figures, violations = result
    return [math.log(max(figure, 1e-300)) for figure in figures], list(violations)


def tell(optuna, study, trial, result):
    """Refused and repeated configurations give no information."""
    if result is None:
        study.tell(trial, state=optuna.trial.TrialState.FAIL)
        return
    values, violations = told(result)
    trial.set_user_attr("violations", violations)
    study.tell(trial, values)


def unseen(parameters, seen, chance):
    """A new configuration: random, or else the next in order."""
    for _ in range(100):
        place = tuple(chance.randrange(len(values)) for _, values in parameters)
        if place not in seen:
            return place
    return next(place for place in itertools.product(*(range(len(values)) for _, values in parameters)) if place
                not in seen)


def hypervolume(points, worst):
    """Exact hypervolume that points (less is better) dominate below the point `worst`, by slices along the last
    figure."""
    inside = sorted((point for point in points if all(a < b for a, b in zip(point, worst))),
                    key=lambda point: point[-1])
    if not inside:
        return 0.0
    if len(worst) == 1:
        return worst[0] - inside[0][0]
    heights = [point[-1] for point in inside[1:]] + [worst[-1]]
    return sum((above - point[-1]) * hypervolume([each[:-1] for each in inside[:i + 1]], worst[:-1])
               for i, (point, above) in enumerate(zip(inside, heights)) if above > point[-1])


def check_count(count, parameters):
    if not 1 <= count <= size_of(parameters):
        raise InputError("--points", f"1 to {size_of(parameters)}, the configurations of the space", count)
