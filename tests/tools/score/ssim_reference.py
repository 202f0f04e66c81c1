#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Prints the table of scikit-image's scores that scores_test.cpp holds. The pictures are made by the same formulas there.

Usage: /usr/bin/python3 tests/ssim_reference.py      (Debian: python3-skimage)
"""
import numpy as np
from skimage.metrics import peak_signal_noise_ratio, structural_similarity


def pattern(width, height):
    y, x, c = np.meshgrid(np.arange(height), np.arange(width), np.arange(3), indexing="ij")
    return (7 * x + 13 * y + 29 * c + x * y // 5 + 40 * ((x // 8 + y // 8) % 2)) % 256, x, y, c


def disturbed(values, x, y, c, strength):
    noise = (31 * x + 17 * y + 11 * c + x * x // 3) % (2 * strength + 1) - strength
    return np.clip(values + noise, 0, 255)


def luma(rgb):
    return rgb[..., 0] * 0.299 + rgb[..., 1] * 0.587 + rgb[..., 2] * 0.114


def main():
    for width, height, strength in [(64, 48, 11), (33, 57, 60), (160, 90, 3), (11, 11, 100)]:
        photograph, x, y, c = pattern(width, height)
        rendering = disturbed(photograph, x, y, c, strength)
        _, every = structural_similarity(luma(rendering.astype(float)), luma(photograph.astype(float)),
                                         gaussian_weights=True, sigma=1.5, use_sample_covariance=False,
                                         data_range=255, full=True)
        mask = ((x + 2 * y) % 7 < 4)[..., 0]
        psnr = peak_signal_noise_ratio(photograph, rendering, data_range=255)
        print(f"    {{{width}, {height}, {strength}, {psnr:.9f}, {every.mean():.12f}, {every[mask].mean():.12f}}},")


main()
