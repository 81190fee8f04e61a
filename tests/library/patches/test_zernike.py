"""The basis against scipy, for every (n, m), and the folded product against the plain one."""

from math import factorial

import numpy as np
import pytest
from scipy.special import eval_jacobi

from sparsurf.patches.zernike import polynomials


@pytest.mark.parametrize("m", range(21))
def test_radial_polynomials_equal_scipy_and_the_formula_of_the_paper(m):
    r = np.linspace(0, 1, 101)
    for n, values in polynomials.radial(m, r**2):
        k = (n - m) // 2
        assert np.allclose(values, eval_jacobi(k, 0, m, 2 * r**2 - 1), atol=1e-12)
        # the paper's sum over powers has coefficients up to 5e8: about 7 digits are left near r = 1
        powers = sum(
            (-1) ** s * factorial(n - s) / (factorial(s) * factorial(n - k - s) * factorial(k - s)) * r ** (n - 2 * s)
            for s in range(k + 1)
        )  # fmt: skip
        assert np.allclose(r**m * values, powers, atol=1e-7)


def test_there_are_121_invariants_ordered_by_n_then_m():
    indices = polynomials.indices()
    assert len(indices) == 121
    assert indices == sorted(indices)
    assert all(0 <= m <= n and (n - m) % 2 == 0 for n, m in indices)


def test_a_polynomial_projects_on_itself():
    # The image holds Re Z_nm at the pixels' centres. Pixels are 0.08 wide and the disc's edge is ragged, so
    # orthogonality holds to a few percent only; for the low orders the own coefficient dominates.
    centre = (np.arange(25) - 12) / 12.5
    x, y = np.meshgrid(centre, -centre)
    r, t = np.hypot(x, y), np.arctan2(y, x)
    for k, (n, m) in enumerate(polynomials.indices()[:9]):
        picture = r**m * eval_jacobi((n - m) // 2, 0, m, 2 * r**2 - 1) * np.cos(m * t)
        c = np.abs((polynomials.basis() * picture).sum(axis=(1, 2)))
        assert np.argmax(c) == k
        assert c[k] == pytest.approx(1.0 if m == 0 else 0.5, rel=0.1)


def test_folded_product_equals_the_plain_one():
    rng = np.random.default_rng(1)
    fold, (one, other, diagonal) = polynomials.fold(), polynomials.pixels_in_disc()
    picture = rng.normal(size=625)
    rows, columns = np.divmod(np.arange(625), 25)
    picture[(rows - 12) ** 2 + (columns - 12) ** 2 > 144] = 0
    plain = np.abs(polynomials.basis().reshape(121, 625) @ picture)[fold.order]
    first, second = picture[one], picture[other]
    real = np.concatenate([first + second, picture[diagonal]]) @ fold.even
    imaginary = np.zeros(121)
    imaginary[: fold.odd.shape[1]] = (first - second) @ fold.odd
    assert np.abs(np.hypot(real, imaginary) - plain).max() < 1e-12
