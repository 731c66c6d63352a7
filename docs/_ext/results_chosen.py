"""Rows that the README, the first pages of the site and of the results, and the paper show, and
the names of the suites.
"""

from __future__ import annotations

#: Names of the suites in the picture and in the list of pages.
LABELS = {
    "bands": "Bands and gaps",
    "benchmarks": "Published benchmarks and measurements",
    "composite-chains": "Composite chains",
    "losses": "Damping in contacts",
    "lateral": "Plane crystals between walls",
    "lateral-attenuation": "Plane crystals: scattered diameters",
    "prestress": "Precompression",
    "square-packing-sensors": "Square packings: sensors",
    "square-packing": "Square packings",
    "thesis-2": "Thesis 2: elasto-plastic chains",
    "sphere-contacts": "Thesis 2, 3: contact of two spheres",
    "thesis-3": "Thesis 3: elastic bars",
    "thesis-4": "Thesis 4: elastic and bilinear chains",
    "fcc-impact": "Thesis 5: reference impact",
    "thesis-5": "Thesis 5: packings and blocks",
    "thesis-5-high": "Thesis 5: high inputs, and volumes",
    "confined": "Thesis 6: chains in a tube",
    "confined-legends": "Thesis 6: scales of figures",
    "thesis-7": "Thesis 7: filters",
    "thesis-8": "Thesis 8: switching chain",
    "protection": "Protected targets",
    "tolerance": "Tolerance and friction",
}
_REFERENCE = "second_solver"
_PARTIAL_SLIP = 'with contact.tangential = "partial_slip"'
#: The ten results of the README: words before the quantity, suite, study, starts of the
#: quantities (the first such rows). If several rows share a line, the words before are its
#: name. They are the headline rows of their systems, whether they agree or not.
CHOSEN = (
    (
        "Reference impact, last layer fixed: dissipated fraction, peak contact force / F_y",
        "fcc-impact",
        _REFERENCE,
        ("Dissipated fraction", "Peak contact force"),
    ),
    (
        "Two spheres: deviation of finite elements from the fitted law, 1 to 10 and above 10 yield "
        "overlaps",
        "sphere-contacts",
        "sphere_contact",
        (
            "Deviation of finite elements from the law from 1 to 10 alpha_y: largest, brass, equal",
            "Deviation of finite elements from the law from 10 alpha_y to 0.2 R*: smallest, brass, "
            "equal",
        ),
    ),
    (
        "Elasto-plastic chain: decay per contact, of three impulses together and of the smallest",
        "thesis-2",
        "elastoplastic_decay",
        ("b of one law 2.25", "b: decay of the leading wave per contact, contacts 1 to 7, I 0.046"),
    ),
    ("Bilinear chain, long load: ", "thesis-4", "bilinear_long_load", ("F2, force",)),
    (
        "Composite chain, steel with 3 or 24 brass beads: wave speed between two sensors",
        "composite-chains",
        "measured_speeds",
        (
            "V, N2 = 3, brass of 103 GPa, Hertz's law",
            "V, N2 = 24, brass of 103 GPa, Hertz's law",
        ),
    ),
    (
        "Soft cylinders between walls: front speed, centred-square / hexagonal crystal",
        "lateral",
        "crystals",
        ("Front speed of BCC / HCP, crystals of 40",),
    ),
    (
        "Square packing, in-plane: energy in central chains, edge chains",
        "square-packing",
        "square-in-plane",
        ("Energy in central chains", "Energy in edge chains"),
    ),
    ("Tunnel of cylinders: ", "bands", "tunable_gap", ("Top of the third band, a = 0",)),
    (
        "Measured wave speed, chain of brass / chain of PTFE; computed for impacts at 0.1, 0.3 and "
        "1 m/s",
        "benchmarks",
        "chains_brass_teflon",
        (
            "Speed in brass / speed in PTFE, impact at 0.1 m/s",
            "Speed in brass / speed in PTFE, impact at 0.3 m/s",
            "Speed in brass / speed in PTFE, impact at 1 m/s",
        ),
    ),
    (
        "Oxide sphere on glass: measured tangential restitution at 4.22, 9.84 and 20.22 degrees, "
        f"by default, then {_PARTIAL_SLIP}",
        "benchmarks",
        "impacts_oblique",
        (
            "Tangential restitution measured at 4.22 degrees, oxide, one spring",
            "Tangential restitution measured at 9.84 degrees, oxide, one spring",
            "Tangential restitution measured at 20.22 degrees, oxide, one spring",
            "Tangential restitution measured at 4.22 degrees, oxide, partial slip",
            "Tangential restitution measured at 9.84 degrees, oxide, partial slip",
            "Tangential restitution measured at 20.22 degrees, oxide, partial slip",
        ),
    ),
)
_FCC_SPEED = ("prestress", "packing_speed", ("Speed of small waves, fcc, uniaxial",))
#: Further rows of the first page of results, in the same form; without words before it the name
#: is the quantity.
MORE = (
    (
        "Square packing, out-of-plane: energy in central chains, strikers, impacted spheres",
        "square-packing",
        "square-out-of-plane",
        ("Energy in central chains", "Energy in strikers", "Energy in impacted spheres"),
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
        "Oxide sphere on glass: measured rebound angle at 3.94, 9.72 and 20.31 degrees, "
        f"{_PARTIAL_SLIP}",
        "benchmarks",
        "impacts_oblique",
        (
            "Rebound angle measured at 3.94 degrees, oxide, partial slip",
            "Rebound angle measured at 9.72 degrees, oxide, partial slip",
            "Rebound angle measured at 20.31 degrees, oxide, partial slip",
        ),
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
    ("", "sphere-contacts", "sphere_contact", ("Contact area / Thornton's contact area",)),
    ("Elastic bar: ", "thesis-3", "split_hopkinson", ("Speed, split-hopkinson",)),
    ("Elastic chain, 40 N for 10 ms: ", "thesis-4", "long_load", ("Speed of the front",)),
    (
        "Bilinear chain, short pulse: ",
        "thesis-4",
        "bilinear_pulse",
        ("Factor of sqrt(1 - beta) in 4.22, beta 0.7",),
    ),
    (
        "FCC packing: ",
        "thesis-5",
        "packings",
        ("Dissipated fraction, impact on 7 spheres / on one",),
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
MEASURED = (CHOSEN[9], CHOSEN[4], CHOSEN[8])
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
        "composite-chains",
        "measured_speeds",
        CHOSEN[4][3][:1],
    ),
)
