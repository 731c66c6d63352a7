"""Numbers of runs with a past, as columns of a table and of a figure's data."""

from __future__ import annotations

from granwave.analysis.studies.tables import Quantity, of_summary

IMPACT = Quantity("velocity_m_s", "Impact", "m/s", lambda run: run.case.load.velocity)
LEVEL = Quantity("level_N", "Preconditioned to", "N", lambda run: run.level)
PRESSURE = Quantity("pressure_Pa", "Static pressure", "Pa", lambda run: run.pressure)
STATIC_FORCE = Quantity("static_contact_force_N", "Static force of a contact", "N", lambda run: run.static_force)
DISSIPATED = Quantity("dissipated_share", "Dissipated", "% of input", lambda run: run.dissipated, 100.0)
GREW = Quantity("contacts_yielded", "Contacts whose dents grew", "", of_summary("n_plastic_contacts"))
PEAK_FORCE = Quantity("peak_force_N", "Largest contact force", "N", of_summary("peak_force_N"))
TRANSMITTED = Quantity("transmitted_force_N", "Largest force added at the bottom", "N", lambda run: run.transmitted)
ARRIVAL = Quantity("arrival_s", "Arrival there", "µs", lambda run: run.arrival, 1e6)
