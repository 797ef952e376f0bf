"""The sparse autoencoder: its gradient by Taylor's slope, its learning on patches of two patterns, its patches."""

import tracemalloc

import numpy as np
import pytest

from ipcli.models.brdf import autoencoder
from ipcli.models.brdf.parameters import Coding


def test_the_gradient_leaves_an_error_of_second_order():
    rng = np.random.default_rng(0)
    x, units = rng.normal(size=(30, 7)), 4
    at, towards = rng.normal(size=2 * 7 * 4 + 11) * 0.5, rng.normal(size=2 * 7 * 4 + 11)
    batches = autoencoder.in_batches(x, 8)
    value, gradient = autoencoder.loss(at, batches, units, Coding(sparsity=0.7))
    sizes = np.array([1e-2, 1e-3, 1e-4])
    left = [
        abs(
            autoencoder.loss(at + t * towards, batches, units, Coding(sparsity=0.7))[0] - value - t * gradient @ towards
        )
        for t in sizes
    ]
    slope = np.polyfit(np.log(sizes), np.log(left), 1)[0]
    assert slope == pytest.approx(2, abs=0.1)


def test_patches_of_few_causes_are_read_back_and_weights_are_sparse():
    rng = np.random.default_rng(1)
    causes = rng.normal(size=(3, 20))
    x = (rng.uniform(size=(400, 3)) < 0.3) @ causes
    coder = autoencoder.learn(
        autoencoder.in_batches(x), Coding(units=(8,), sparsity=0.01, l1=1e-3, iterations=150), rng
    )
    assert coder.error(x).mean() < 0.1
    assert (coder.layers[0].weights == 0).mean() > 0.2
    assert coder.error(rng.normal(size=(400, 20)) * x.std()).mean() > 4 * coder.error(x).mean()


def test_two_layers_code_the_codes():
    rng = np.random.default_rng(2)
    x = rng.normal(size=(60, 2)) @ rng.normal(size=(2, 12))
    coder = autoencoder.learn(autoencoder.in_batches(x), Coding(units=(8, 3), iterations=20), rng)
    assert coder.code(x).shape == (60, 3)
    assert ((coder.code(x) > 0) & (coder.code(x) < 1)).all()


def test_batches_make_no_difference():
    rng = np.random.default_rng(4)
    x = rng.normal(size=(200, 3)) @ rng.normal(size=(3, 10)) + 5
    whole, parts = autoencoder.in_batches(x, 200), autoencoder.in_batches(x, 33)
    np.testing.assert_allclose(autoencoder.moments(parts)[0], x.mean(axis=0), rtol=1e-12)
    assert autoencoder.moments(parts)[1] == pytest.approx(x.std(), rel=1e-12)
    at, params = rng.normal(size=2 * 10 * 4 + 14) * 0.3, Coding(units=(6, 3), sparsity=0.7, iterations=12)
    for one, other in zip(*(autoencoder.loss(at, b, 4, params) for b in (whole, parts)), strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-10, atol=1e-12)
    coders = [autoencoder.learn(b, params, np.random.default_rng(5)) for b in (whole, parts)]
    for one, other in zip(*(coder.layers for coder in coders), strict=True):
        np.testing.assert_allclose(one.vector(), other.vector(), rtol=1e-10, atol=1e-10)


def test_memory_holds_one_batch_whatever_their_number():
    def peak(count):
        def batches():
            return (np.random.default_rng(k).normal(size=(500, 30)) for k in range(count))

        tracemalloc.start()
        autoencoder.learn(batches, Coding(units=(8,), iterations=2), np.random.default_rng(0))
        found = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        return found

    assert peak(20) < 1.1 * peak(4)


def test_patches_lie_in_the_mask_and_do_not_know_the_exposure():
    picture, mask = np.random.default_rng(3).uniform(0.1, 1, (20, 24, 3)), np.zeros((20, 24), bool)
    mask[4:15, 5:18] = True
    found = autoencoder.patches(picture, mask, 8, 1000)
    assert found.shape == (4 * 6, 192)
    first = np.log1p(picture[4:12, 5:13] / picture[mask].mean())
    np.testing.assert_allclose(found[0].reshape(8, 8, 3), first)
    np.testing.assert_allclose(autoencoder.patches(7 * picture, mask, 8, 1000), found)
    assert len(autoencoder.patches(picture, mask, 8, 5)) == 5
    assert autoencoder.patches(picture, mask, 12, 5).shape == (0, 432)
