"""Rows that the README, the first pages of the site and of the results, and the paper show, and
the names of the suites.
"""

from __future__ import annotations

#: Names of the suites in the picture and in the list of pages.
LABELS = {
    "bands": "Bands and gaps",
    "benchmarks": "Published benchmarks and measurements",
    "composite-chains": "Wu et al. 2019: composite chains",
    "losses": "Damping in contacts",
    "lateral": "J. Appl. Mech. 2020: plane crystals",
    "lateral-attenuation": "J. Appl. Mech. 2020: scattered diameters",
    "prestress": "Precompression",
    "square-packing-sensors": "Leonard et al. 2013: sensors",
    "square-packing": "Leonard et al. 2013: square packings",
    "thesis-2": "Pal 2015, 2: elasto-plastic chains",
    "sphere-contacts": "Pal 2015, 2, 3: contact of two spheres",
    "thesis-3": "Pal 2015, 3: elastic bars",
    "thesis-4": "Pal 2015, 4: elastic and bilinear chains",
    "fcc-impact": "Pal 2015, 5: reference impact",
    "thesis-5": "Pal 2015, 5: packings and blocks",
    "thesis-5-high": "Pal 2015, 5: high inputs, and volumes",
    "confined": "Pal 2015, 6: chains in a tube",
    "confined-legends": "Pal 2015, 6: scales of the figures",
    "thesis-7": "Pal 2015, 7: filters",
    "thesis-8": "Pal 2015, 8: switching chain",
    "protection": "Protected targets",
    "tolerance": "Tolerance and friction",
}
_REFERENCE = "second_solver"
_MEASURED_SPEEDS = ("composite-chains", "measured_speeds")
_BRASS_PTFE = ("benchmarks", "chains_brass_teflon")
_OBLIQUE = ("benchmarks", "impacts_oblique")


def _restitution(angle: str, law: str) -> tuple[str, str, str, tuple[str, ...]]:
    """Return the line of the tangential restitution that was measured at an angle of incidence."""
    return (
        f"Tangential restitution, oxide sphere on glass, {angle}°, {law}",
        *_OBLIQUE,
        (f"Tangential restitution measured at {angle} degrees, oxide, {law}",),
    )


def _speed_in_brass(number: int) -> tuple[str, str, str, tuple[str, ...]]:
    """Return the line of the speed in a section of brass beads between two sensors."""
    return (
        f"Wave speed in a steel chain with {number} brass beads",
        *_MEASURED_SPEEDS,
        (f"V, N2 = {number}, brass of 103 GPa, Hertz's law",),
    )


def _ratio_of_speeds(velocity: str) -> tuple[str, str, str, tuple[str, ...]]:
    """Return the line of the speed ratio in chains of brass and of PTFE."""
    return (
        f"Wave speed in brass / in PTFE, computed for an impact at {velocity} m/s",
        *_BRASS_PTFE,
        (f"Speed in brass / speed in PTFE, impact at {velocity} m/s",),
    )


#: The ten results of the README: words before the quantity, suite, study, starts of the
#: quantities (the first such rows). Words that do not end with a colon are the name of the line.
#: They are the headline rows of their systems, whether they agree or not, without
#: verifications of the code.
CHOSEN = (
    (
        "FCC packing: dissipated fraction, impact on seven spheres / on one, equal input energy",
        "thesis-5",
        "packings",
        ("Dissipated fraction, impact on 7 spheres / on one",),
    ),
    (
        "Two spheres: deviation of finite elements from the fitted law, 1 to 10 yield overlaps",
        "sphere-contacts",
        "sphere_contact",
        ("Deviation of finite elements from the law from 1 to 10 alpha_y: largest, brass, equal",),
    ),
    (
        "Elasto-plastic chain: decay per contact, three impulses together",
        "thesis-2",
        "elastoplastic_decay",
        ("b of one law 2.25",),
    ),
    ("Bilinear chain, long load: ", "thesis-4", "bilinear_long_load", ("F2, force",)),
    (
        "Square packing, in-plane: energy in central chains",
        "square-packing",
        "square-in-plane",
        ("Energy in central chains",),
    ),
    (
        "Soft cylinders between walls: front speed, centred-square / hexagonal crystal",
        "lateral",
        "crystals",
        ("Front speed of BCC / HCP, crystals of 40",),
    ),
    _speed_in_brass(3),
    _ratio_of_speeds("1"),
    _restitution("4.22", "one spring"),
    _restitution("4.22", "partial slip"),
)
_FCC_SPEED = ("prestress", "packing_speed", ("Speed of small waves, fcc, uniaxial",))
#: Further rows of the first page of results, in the same form; without words before it the name
#: is the quantity.
MORE = (
    (
        "Reference impact, last layer fixed: dissipated fraction",
        "fcc-impact",
        _REFERENCE,
        ("Dissipated fraction",),
    ),
    ("Tunnel of cylinders: ", "bands", "tunable_gap", ("Top of the third band, a = 0",)),
    (
        "Square packing, out-of-plane: energy in central chains",
        "square-packing",
        "square-out-of-plane",
        ("Energy in central chains",),
    ),
    (
        "Chain with gaps: ",
        "thesis-8",
        "no_cylinders",
        ("Displacement of sphere 10 in a long chain, after the wave",),
    ),
    ("FCC packing: ", *_FCC_SPEED),
    ("", "bands", "resonance", ("Bead on a plane, 0.02 N: frequency of the largest velocity",)),
    (
        "Chain under a static force: ",
        "benchmarks",
        "chains_precompressed",
        ("Speed / c0 at F_m/F0 = 129, F0 = 1 N",),
    ),
    (
        "Rebound angle, oxide sphere on glass, 9.72°, partial slip",
        *_OBLIQUE,
        ("Rebound angle measured at 9.72 degrees, oxide, partial slip",),
    ),
    (
        "",
        "benchmarks",
        "impacts_plane",
        ("Test 5, spin of finite elements at incidence 2.28, partial slip",),
    ),
    (
        "Homogeneous chain: ",
        "composite-chains",
        "homogeneous_chain",
        ("Peak force; source: mesh 0.01 to 0.02 mm",),
    ),
    ("", "losses", "loss", ("Restitution at 10 m/s, time 0.3 µs",)),
    ("", "lateral", "lateral-width-bcc", ("Decay of the peak speed in region 1",)),
    (
        "Plane crystals: ",
        "lateral-attenuation",
        "attenuation",
        ("Decay of HCP / BCC, scatter of 1 %",),
    ),
    ("Precompressed chain: ", "prestress", "waves", ("Speed of the wave, F_m/F0 = 28.57",)),
    (
        "",
        "square-packing-sensors",
        "defects",
        ("Exponent of the wave speed against the force, square packing, in-plane impact, scatter",),
    ),
    (
        "Elasto-plastic chain: ",
        "thesis-2",
        "elastoplastic_decay",
        ("Exponent of the peak force against distance, contacts 15",),
    ),
    ("Elastic bar: ", "thesis-3", "split_hopkinson", ("Speed, split-hopkinson",)),
    ("Elastic chain, 40 N for 10 ms: ", "thesis-4", "long_load", ("Speed of the front",)),
    (
        "Bilinear chain, short pulse: ",
        "thesis-4",
        "bilinear_pulse",
        ("Factor of sqrt(1 - beta) in 4.22, beta 0.7",),
    ),
    (
        "FCC packing and block: ",
        "thesis-5-high",
        "high_inputs",
        ("Largest difference of the volumes with the same dissipated fraction, spheres at 3.6 J",),
    ),
    (
        "Chain in a tube: ",
        "confined-legends",
        "legends",
        ("Slope of ln(decay of the force) against delta_hat, model of the source, on the scale",),
    ),
    (
        "Chain in a tube: ",
        "confined",
        "confined_scaling",
        ("Exponent of speed against velocity, n = 8",),
    ),
    ("Filter: ", "thesis-7", "peaks", ("Length of the leading wave in beads at contact 121",)),
    (
        "Switch: ",
        "thesis-8",
        "switch",
        ("First peak at sphere 21, open gaps, 2 cylinders, friction 0",),
    ),
    ("Sphere on a target: ", "protection", "protected-checks", ("Peak force, rigid wall",)),
)
#: Published measurements on the first page of the site.
MEASURED = (
    _restitution("4.22", "one spring"),
    _restitution("4.22", "partial slip"),
    _restitution("9.84", "partial slip"),
    _restitution("20.22", "partial slip"),
    _speed_in_brass(3),
    _speed_in_brass(24),
    _ratio_of_speeds("0.1"),
    _ratio_of_speeds("1"),
    (
        "Wave speed in brass, for the measured speed in PTFE",
        *_BRASS_PTFE,
        ("Speed in brass at the impact",),
    ),
)
#: Rows of the paper, with the names of their quantities there; few columns, as its page is narrow.
IN_PAPER = (
    (
        "Dissipated fraction, 155 520 brass spheres",
        "fcc-impact",
        _REFERENCE,
        ("Dissipated fraction",),
    ),
    ("Force in a bilinear chain after its fronts have met", *CHOSEN[3][1:]),
    (
        "Energy in the central chains of a square packing",
        "square-packing",
        "square-in-plane",
        ("Energy in central chains",),
    ),
    ("Speed of small waves in a compressed FCC packing", *_FCC_SPEED),
    (
        "Wave speed divided by sound speed, precompressed chain",
        "benchmarks",
        "chains_precompressed",
        ("Speed / c0 at F_m/F0 = 129,",),
    ),
    (
        "Tangential restitution at 20.22 degrees, measured; ours with partial slip",
        "benchmarks",
        "impacts_oblique",
        ("Tangential restitution measured at 20.22 degrees, oxide, partial slip",),
    ),
    (
        "Speed in a brass section of a steel chain, measured",
        *_speed_in_brass(3)[1:],
    ),
)
