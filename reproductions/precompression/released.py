"""A remark on runs that dissipate more than their input."""


def released_energy(runs):
    """Return a sentence if any of the runs dissipates more than its input, otherwise an empty
    text.
    """
    if not any(run["dissipated_fraction"] > 1 for run in runs):
        return ""
    return (
        " More than 100 % is no error: energies count from the static state, and the impact also "
        "releases stored energy of the contacts and lets the static load do work."
    )
