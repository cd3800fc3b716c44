# SPDX-License-Identifier: BSD-3-Clause
"""Draws the loss table that TrainRegression writes: python3 plot_loss.py loss.csv loss.png"""

import sys

import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

steps, errors = np.loadtxt(sys.argv[1], delimiter=",", skiprows=1, unpack=True)
window = max(len(steps) // 50, 1)
means = np.convolve(errors, np.ones(window) / window, mode="valid")
figure, axes = plt.subplots(figsize=(6, 3.4), layout="constrained")
axes.plot(steps, errors, color="0.8", linewidth=0.7, label="each step")
axes.plot(steps[window - 1 :], means, color="tab:red", label=f"mean of {window} steps")
axes.set(xlabel="step", ylabel="error, fraction of the variance", yscale="log", xlim=(0, steps[-1]))
axes.legend()
figure.savefig(sys.argv[2], dpi=120)
