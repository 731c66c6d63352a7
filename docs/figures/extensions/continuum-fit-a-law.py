"""A fit of the law's constants to a curve."""

import subprocess

from page_figures import save

PAIR = ["--material", "brass", "steel", "--radius", "0.004", "0.008"]

subprocess.run(["granwave", "law", *PAIR, "-o", "law.csv"], check=True)
subprocess.run(["granwave", "fit", "law.csv", *PAIR], check=True)
save("fit/figures/fit.png", "curve")
