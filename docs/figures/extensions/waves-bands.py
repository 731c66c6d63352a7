"""Bands of a precompressed chain."""

import subprocess

from page_figures import save

import granwave as gw

subprocess.run(["granwave", "bands", "precompressed-chain", "-o", "chain"], check=True)
save("chain/figures/bands.png", "chain")
weak = gw.run(
    "precompressed-chain",
    packing__size=80,
    load__velocity=0.01,
    run__end_time=1.2e-3,
    figures=False,
)
save(weak.figure("dispersion"), "dispersion")
