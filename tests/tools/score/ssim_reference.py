#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Prints the table of reference scores that scores_test.cpp holds. The pictures are made by the same formulas there.

PSNR and SSIM over all pixels are scikit-image's. SSIM over a mask is SciPy's: Gaussian filters of the masked
pictures, divided by those of the mask.

Usage: /usr/bin/python3 tests/tools/score/ssim_reference.py      (Debian: python3-skimage)
"""
import numpy as np
from scipy.ndimage import gaussian_filter
from skimage.metrics import peak_signal_noise_ratio, structural_similarity


def pattern(width, height):
    y, x, c = np.meshgrid(np.arange(height), np.arange(width), np.arange(3), indexing="ij")
    return (7 * x + 13 * y + 29 * c + x * y // 5 + 40 * ((x // 8 + y // 8) % 2)) % 256, x, y, c


def disturbed(values, x, y, c, strength):
    noise = (31 * x + 17 * y + 11 * c + x * x // 3) % (2 * strength + 1) - strength
    return np.clip(values + noise, 0, 255)


def luma(rgb):
    return rgb[..., 0] * 0.299 + rgb[..., 1] * 0.587 + rgb[..., 2] * 0.114


def masked_ssim(a, b, mask):
    def window(values):
        return gaussian_filter(values * mask, sigma=1.5, truncate=3.5, mode="reflect")

    with np.errstate(divide="ignore", invalid="ignore"):
        mean = {name: window(values) / window(np.ones_like(a))
                for name, values in {"a": a, "b": b, "aa": a * a, "bb": b * b, "ab": a * b}.items()}
        c1, c2 = (0.01 * 255) ** 2, (0.03 * 255) ** 2
        product = mean["a"] * mean["b"]
        squares = mean["a"] ** 2 + mean["b"] ** 2
        every = ((2 * product + c1) * (2 * (mean["ab"] - product) + c2)
                 / ((squares + c1) * (mean["aa"] + mean["bb"] - squares + c2)))
    return every[mask].mean()


def main():
    for width, height, strength in [(64, 48, 11), (33, 57, 60), (160, 90, 3), (11, 11, 100)]:
        photograph, x, y, c = pattern(width, height)
        rendering = disturbed(photograph, x, y, c, strength)
        _, every = structural_similarity(luma(rendering.astype(float)), luma(photograph.astype(float)),
                                         gaussian_weights=True, sigma=1.5, use_sample_covariance=False,
                                         data_range=255, full=True)
        mask = ((x + 2 * y) % 7 < 4)[..., 0]
        psnr = peak_signal_noise_ratio(photograph, rendering, data_range=255)
        in_mask = masked_ssim(luma(rendering.astype(float)), luma(photograph.astype(float)), mask)
        everywhere = masked_ssim(luma(rendering.astype(float)), luma(photograph.astype(float)), np.ones_like(mask))
        assert abs(everywhere - every.mean()) < 1e-12
        print(f"    {{{width}, {height}, {strength}, {psnr:.9f}, {every.mean():.12f}, {in_mask:.12f}}},")


main()
