#!/usr/bin/env python3
"""Makes closed_forms.json: reference values of the closed forms, by mpmath at 60 digits, printed to 20.

Formulas are those with complete elliptic integrals K and E and with arccos, logarithm and gamma function as the
literature writes them (Johnson 1985; Sneddon 1965; Maugis & Barquins 1983), not the rearranged ones of the library: at
60 digits their cancellation does no harm. Run: python3 closed_forms.py > closed_forms.json
"""
import json
from mpmath import mp, mpf, sqrt, pi, gamma, log, acos, acosh, ellipk, ellipe, findroot, quad, nstr

mp.dps = 60


def s(x):
    return float(nstr(x, 20))


def hertz(ratio):
    """A/B -> k, a, b, P at E* = d = B = 1."""
    ratio = mpf(ratio)
    if ratio == 1:
        a = sqrt(mpf(1) / 2)
        return dict(ratio=1.0, k=1.0, a=s(a), b=s(a), force=s(4 / (3 * sqrt(mpf(2)))), peak=s(4 / (pi * sqrt(mpf(2)))))

    def parts(k):
        m = 1 - k * k
        K, E = ellipk(m), ellipe(m)
        return K, (K - E) / m, (E - k * k * K) / (m * k * k)

    def miss(logk):
        _, u, v = parts(mp.exp(logk))
        return log(u / v) - log(ratio)

    k = mp.exp(findroot(miss, (log(ratio) * mpf("0.55"), log(ratio) * mpf("0.6")), solver="secant", tol=1e-90))
    K, u, _ = parts(k)
    a = sqrt(u / (K * ratio))
    b = k * a
    return dict(ratio=s(ratio), k=s(k), a=s(a), b=s(b), force=s(2 * pi * a / (3 * K)), peak=s(1 / (b * K)))


def hertz_inverse(k):
    k = mpf(k)
    m = 1 - k * k
    K, E = ellipk(m), ellipe(m)
    return dict(k=s(k), ratio=s((K - E) * k * k / (E - k * k * K)))


def power(n):
    n = mpf(n)
    k = sqrt(pi) * gamma(n / 2 + 1) / gamma((n + 1) / 2)
    a = k ** (-1 / n)
    return dict(exponent=s(n), a=s(a), force=s(2 * n / (n + 1) * a))


def power_pressure(n, x):
    """p at r = x a, E* = c = d = 1."""
    n, x = mpf(n), mpf(x)
    k = sqrt(pi) * gamma(n / 2 + 1) / gamma((n + 1) / 2)
    a = k ** (-1 / n)
    u = acosh(1 / x)
    return dict(exponent=s(n), at=s(x), pressure=s(n / (pi * a) * quad(lambda v: (x * mp.cosh(v)) ** (n - 1), [0, u / 2, u])))


def abel_forms(name, abel, slope, b, a):
    """d, P, U and p(a/2), p(a/4) from D(s) and D'(s); b a break."""
    cuts = sorted({mpf(0), a} | ({b} if 0 < b < a else set()))
    d = abel(a)
    force = 2 * quad(lambda v: d - abel(v), cuts)
    energy = quad(lambda v: (d - abel(v)) ** 2, cuts)

    def p(r):
        end = acosh(a / r)
        inner = [mpf(0)] + ([acosh(b / r)] if r < b < a else []) + [end]
        return quad(lambda v: slope(r * mp.cosh(v)), inner) / pi

    return dict(a=s(a), depth=s(d), force=s(force), energy=s(energy), pressures=[[0.4, s(p(a * mpf(4) / 10))], [0.8, s(p(a * mpf(8) / 10))]])


def sphere(a):
    a = mpf(a)
    return abel_forms("sphere", lambda v: v * mp.atanh(v), lambda v: mp.atanh(v) + v / (1 - v * v), mpf(0), a)


def flat_ended(a):
    a = mpf(a)
    out = abel_forms("flat", lambda v: v * acos(1 / v) if v > 1 else mpf(0),
                     lambda v: acos(1 / v) + 1 / sqrt((v - 1) * (v + 1)) if v > 1 else mpf(0), mpf(1), a)
    w = acos(1 / a)
    out["depth"], out["force"] = s(a * w), s(a * a * (w + sqrt(1 - 1 / a**2) / a))
    return out


def rounded(a):
    a = mpf(a)

    def abel(v):
        return v * v if v <= 1 else v * (v - sqrt(v * v - 1)) + v * acos(1 / v)

    def slope(v):
        return 2 * v if v <= 1 else 2 * v - 2 * sqrt(v * v - 1) + acos(1 / v)

    return abel_forms("rounded", abel, slope, mpf(1), a)


def flat_ellipse(k):
    k = mpf(k)
    return dict(k=s(k), force=s(pi / ellipk(1 - k * k)))


table = {
    "source": "Computed by closed_forms.py with mpmath (60 digits, printed to 20). Units: E* = 1.",
    "hertz": {"what": "d = B = 1; k = b/a, semi-axes a and b, force P, peak pressure",
              "rows": [hertz(r) for r in ["1", "0.999999999", "0.99", "0.5", "0.25", "0.1", "0.01", "1e-4", "1e-6", "1e-8", "1e-10", "1e-12"]]},
    "hertz_inverse": {"what": "A/B of the axis ratio k", "rows": [hertz_inverse(k) for k in ["0.5", "0.1", "1e-2", "1e-3", "1e-4", "1e-6"]]},
    "power": {"what": "gap r^n at d = 1: contact radius a, force P",
              "rows": [power(n) for n in ["0.05", "0.1", "0.5", "1", "1.5", "2", "2.7", "3", "4", "6", "8", "10", "20", "37.5", "80", "200"]]},
    "power_pressure": {"what": "gap r^n at d = 1: pressure at r = at * a",
                       "rows": [power_pressure(n, x) for n in ["0.3", "0.5", "1", "1.5", "2", "3", "4", "20", "200"] for x in ["0.01", "0.5", "0.95"]]},
    "sphere": {"what": "R = 1", "rows": [sphere(a) for a in ["1e-6", "0.001", "0.1", "0.3", "0.5", "0.7", "0.9", "0.99"]]},
    "flat_ended_cone": {"what": "b = t = 1", "rows": [flat_ended(a) for a in ["1.0001", "1.1", "2", "10"]]},
    "rounded_cone": {"what": "R = b = t = 1", "rows": [rounded(a) for a in ["1.1", "2", "10", "1000"]]},
    "flat_ellipse": {"what": "P/(E* a d)", "rows": [flat_ellipse(k) for k in ["1", "0.5", "0.2", "0.1", "0.01", "1e-3", "1e-6"]]},
}
print(json.dumps(table, indent=1))
