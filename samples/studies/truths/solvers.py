"""Computed truths, in double precision and by methods independent of the board's."""
import functools
import math

import numpy as np


def gauss(count, low=0.0, high=1.0):
    """Gauss-Legendre nodes and weights."""
    at, weights = np.polynomial.legendre.leggauss(count)
    return low + (high - low) * (at + 1) / 2, weights * (high - low) / 2


@functools.cache
def h_function(albedo, nodes=200):
    """Chandrasekhar's H for isotropic scattering at Gauss points of 0..1: the points, their weights, H (Radiative
    Transfer, 1960, V)."""
    # H changes most at small cosines, so the nodes are those of a square root.
    root, weights = gauss(nodes)
    mu, weights = root**2, 2 * root * weights
    h = np.ones(nodes)
    for _ in range(2000):
        new = 1 / (math.sqrt(1 - albedo) + albedo / 2 * (mu / (mu[:, None] + mu)) @ (weights * h))
        if abs(new / h - 1).max() < 1e-14:
            break
        h = np.sqrt(h * new)  # converges also without absorption
    return mu, weights, h


def h_at(albedo, cosine):
    mu, weights, h = h_function(albedo)
    return 1 / (math.sqrt(1 - albedo) + albedo / 2 * (weights * h * mu / (cosine + mu)).sum())


def half_space_albedo(albedo, cosine):
    """Share of light from this direction that a half space reflects."""
    return 1 - math.sqrt(1 - albedo) * h_at(albedo, cosine)


@functools.cache
def slab(depth, albedo, g, streams=64, cosine=1.0):
    """Reflectance and transmittance of a slab with Henyey and Greenstein's phase function for collimated light, by
    discrete ordinates (double Gauss) and doubling (van de Hulst 1980)."""
    mu, weights = gauss(streams // 2)
    mu, weights = np.append(mu, cosine), np.append(weights, 0)  # the beam is another direction
    orders = np.arange(streams)
    legendre = np.array([np.polynomial.legendre.Legendre.basis(order)(mu) for order in orders])
    ahead = np.einsum("l,li,lj->ij", (2 * orders + 1.0) * g**orders, legendre, legendre)
    back = np.einsum("l,li,lj->ij", (2 * orders + 1.0) * (-g) ** orders, legendre, legendre)
    halvings = 24
    thin = depth / 2**halvings
    # These intensities include their weights, so that the beam is one of them.
    gain = thin * albedo / 2 * (weights / mu)[:, None]
    reflect = gain * back
    loss = thin / mu
    passed = np.diag(1 - loss + loss**2 / 2) + gain * ahead
    one = np.eye(len(mu))
    for _ in range(halvings):
        between = np.linalg.solve(one - reflect @ reflect, passed)
        reflect, passed = reflect + passed @ reflect @ between, passed @ between
    return mu @ reflect[:, -1] / cosine, mu @ passed[:, -1] / cosine


def optical_depths(boxes, start, end):
    """Optical depths between points (n, 3) through boxes (low, high, extinction); the last box around a place counts.
    Exact, as sums over the pieces between the boxes' planes."""
    way = end - start
    length = np.sqrt((way * way).sum(axis=1))
    planes = [(axis, value) for low, high, _ in boxes for axis in range(3) for value in (low[axis], high[axis])]
    with np.errstate(divide="ignore", invalid="ignore"):
        cuts = np.stack([(value - start[:, axis]) / way[:, axis] for axis, value in dict.fromkeys(planes)], 1)
    cuts = np.sort(np.clip(np.nan_to_num(np.column_stack([cuts, np.zeros(len(way)), np.ones(len(way))]), nan=0.0), 0,
                           1), axis=1)
    middles = start[:, None] + way[:, None] * ((cuts[:, 1:] + cuts[:, :-1]) / 2)[..., None]
    kappa = np.zeros(middles.shape[:2])
    for low, high, extinction in boxes:
        kappa[((middles > low) & (middles < high)).all(axis=2)] = extinction
    return (kappa * np.diff(cuts, axis=1)).sum(axis=1) * length


def henyey_greenstein(g, uniform):
    """Random cosines of the scattering angle."""
    if g == 0:
        return 2 * uniform - 1
    return (1 + g * g - ((1 - g * g) / (1 - g + 2 * g * uniform)) ** 2) / (2 * g)


def turned(direction, cosine, turn):
    """Unit vectors (n, 3) at an angle to others."""
    ring = np.sqrt(np.maximum(0, 1 - cosine * cosine))
    x, y, z = direction.T
    sign = np.where(z >= 0, 1.0, -1.0)  # Duff and others (2017)
    a = -1 / (sign + z)
    b = x * y * a
    u = np.stack([1 + sign * x * x * a, sign * b, -sign * x], 1)
    v = np.stack([b, sign + y * y * a, -y], 1)
    return (ring * np.cos(turn))[:, None] * u + (ring * np.sin(turn))[:, None] * v + cosine[:, None] * direction


def reflectance(cosine, inside, outside=1.0):
    """Fresnel's reflectance of unpolarised light."""
    sine = inside / outside * np.sqrt(np.maximum(0, 1 - cosine * cosine))
    through = np.sqrt(np.maximum(0, 1 - sine * sine))
    across = (inside * cosine - outside * through) / (inside * cosine + outside * through)
    parallel = (outside * cosine - inside * through) / (outside * cosine + inside * through)
    return np.where(sine >= 1, 1.0, (across**2 + parallel**2) / 2)


def photons_in_box(size, extinction, albedo, g, place, direction, seed, index=1.0):
    """Plain Monte Carlo of photons from places (n, 3) in a box, with absorption by weight. Returns the absorbed share
    of each, and the shares that leave by the six faces."""
    random = np.random.default_rng(seed)
    place, direction = np.array(place, float), np.array(direction, float)
    size = np.asarray(size, float)
    weight, absorbed, faces = np.ones(len(place)), np.zeros(len(place)), np.zeros(6)
    alive = np.arange(len(place))
    while len(alive):
        p, d = place[alive], direction[alive]
        free = random.exponential(1 / extinction, len(alive))
        while True:
            with np.errstate(divide="ignore"):
                walls = np.where(d > 0, (size - p) / d, np.where(d < 0, -p / d, np.inf))
            axis = walls.argmin(axis=1)
            wall = walls[np.arange(len(p)), axis]
            out = wall < free
            if not out.any():
                break
            rows = np.flatnonzero(out)
            cosine = abs(d[rows, axis[rows]])
            back = random.random(len(rows)) < (reflectance(cosine, index) if index != 1 else 0)
            gone = rows[~back]
            np.add.at(faces, 2 * axis[gone] + (d[gone, axis[gone]] > 0), weight[alive[gone]])
            weight[alive[gone]] = 0
            free[gone] = -1
            turn = rows[back]
            p[turn] = np.clip(p[turn] + d[turn] * wall[turn, None], 0, size)
            free[turn] -= wall[turn]
            d[turn, axis[turn]] *= -1
            if not len(turn):
                break
        stay = free >= 0
        alive, p, d = alive[stay], p[stay] + d[stay] * free[stay, None], d[stay]
        absorbed[alive] += weight[alive] * (1 - albedo)
        weight[alive] *= albedo
        faint = weight[alive] < 0.01
        weight[alive[faint]] *= np.where(random.random(faint.sum()) < 0.1, 10, 0)
        left = weight[alive] > 0
        alive = alive[left]
        place[alive] = p[left]
        direction[alive] = turned(d[left], henyey_greenstein(g, random.random(len(alive))),
                                  2 * np.pi * random.random(len(alive)))
    return absorbed, faces / len(absorbed)
