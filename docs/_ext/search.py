"""Check of the search of the built site: words that users search for must find their page among the
first results.

    python docs/_ext/search.py build/docs          # exit status 1, and a line for each word that does not
    python docs/_ext/search.py build/docs WORD     # the first results of a word

The ranking is that of Sphinx's ``searchtools.js`` with the weights and the search of words of
``scorer.js``, on the index that the browser reads: titles, entries of the index, Python objects,
words of the text. A word that does not occur on the page gets an index entry at the passage with
the answer.
"""

from __future__ import annotations

import json
import math
import re
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

FIRST = 3  # results among which the page is expected
FIRST_OF_HEADS = 2  # results among which the page of HEADS is expected
_TITLE = 15
_SHORT = 2  # characters of words that are not looked for within words
_OBJECT = 11
_PART_OF_OBJECT = 6
_PRIORITY = {0: 15, 1: 5, 2: -5}
_INDEX = 100  # of a whole entry
LONG_WORD = 3  # characters above which a final s may be a plural
SCORER = Path(__file__).with_name("scorer.js").read_text(encoding="utf-8")
#: Weights of pages, by the beginning of their names.
ROOMS: dict[str, int] = json.loads(re.search(r"rooms: (\{.*?\})", SCORER, re.DOTALL)[1])
#: Weight of a title that contains all words of the query; it decides between equal results.
TITLE_WORDS = float(re.search(r"titleWords: ([\d.]+)", SCORER)[1])
#: Weights of a word by its place on the page: of the whole word, and of a word that contains it.
WORD_WEIGHTS: dict[str, tuple[int, int]] = json.loads(
    re.search(r"wordWeights: (\{.*?\})", SCORER, re.DOTALL)[1]
)
#: Words that people look for, and the page that answers, by name below ``docs`` without its suffix.
WORDS = {
    "howto/struck-packings": ("impactor", "striker", "projectile", "oblique impact"),
    "howto/target": (
        "armor", "armour", "drop test", "wall force", "energy absorption", "crashworthiness", "sandwich",
        "shock absorber", "protection", "impact attenuation", "helmet", "packaging",
        "force on the bottom", "bottom force",
    ),
    "howto/losses": (
        "Prony", "damping", "coefficient of restitution", "restitution", "viscoelastic",
    ),
    "howto/real-packings": (
        "friction", "set friction", "add friction", "gravity", "polydisperse", "vacancies",
        "preload", "different sizes",
    ),
    "howto/own-places": ("STL", "CAD", "random packing", "sand", "grains from a file"),
    "howto/case-files": ("initial velocity",),
    "howto/check": ("memory", "run time", "disk space", "64 GB", "largest packing", "check a case"),
    "howto/packing-size": ("packing too small", "size of the packing"),
    "howto/compare": ("compare", "compare two runs"),
    "explanation/plastic-zone": ("zone depth",),
    "explanation/comparing": ("truncated values", "decay of the peak force"),
    "explanation/energy": ("energy_balance",),
    "howto/contact-figures": ("arrival time",),
    "howto/boundaries": ("periodic", "boundary conditions", "free surface", "hopper"),
    "howto/contact-laws": ("glass beads", "ceramic beads", "elastic contacts", "Hertz law"),
    "howto/stop-and-resume": ("restart", "restart a run", "resume", "checkpoint"),
    "howto/other-programs": ("OVITO", "ParaView", "VTK", "dump", "MDAnalysis", "export", "csv"),
    "extensions/pictures/films": (
        "movie", "animation", "video", "colour map", "picture for a paper", "section plane",
    ),
    "howto/scans": (
        "scan", "parameter study", "sensitivity", "error bars", "sweep", "replicates", "spread",
        "scatter",
    ),
    "extensions/design/design": ("optimum", "optimisation", "optimization", "design"),
    "extensions/waves/bands": ("band gap", "dispersion", "phonon", "eigenmodes"),
    "extensions/inference/infer": ("force chains", "inverse problem"),
    "howto/read-packings": ("LIGGGHTS", "LIGGGHTS dump", "YADE", "own packing file", "xyz"),
    "howto/python": ("notebook", "pandas", "jupyter", "python", "own axes"),
    "howto/more-questions": ("units", "SI units", "ids of spheres", "error of the results"),
    "howto/cite": ("cite", "licence", "license", "BibTeX"),
    "howto/own-lammps": (
        "MPI", "OpenMPI", "ranks", "two ranks", "np", "number of cores", "own LAMMPS",
    ),
    "extensions/continuum/fit-a-law": ("measured force", "force-displacement"),
    "howto/balance": ("energy conservation",),
    "tutorials/cluster": ("cluster", "Slurm", "submit", "HPC", "scheduler"),
    "tutorials/chain": ("solitary wave", "wave speed", "Hopkinson", "SHPB", "newton's cradle"),
    "tutorials/material-and-tolerances": (
        "own material", "add a material", "poisson ratio", "young's modulus", "yield strength",
        "tolerance", "density",
    ),
    "extensions/continuum/tutorial": ("finite elements", "FEM", "continuum"),
    "tutorials/lammps-script": ("input script", "pair_style", "pair style"),
    "lammps/index": ("examples for LAMMPS", "fix pour", "hybrid"),
    "lammps/chute": ("chute",),
    "lammps/clumps": ("clumps", "rigid bodies"),
    "reference/keys": (
        "load.velocity", "contact.friction", "output.probes", "run.energy_tolerance",
    ),
    "reference/quantities": ("peak_force_N", "peak_reduction", "base_arrival_s"),
    "reference/materials": ("HCP", "BCC", "FCC", "stainless", "aluminium", "PTFE", "teflon"),
    "explanation/contact-law": (
        "contact law", "Hertz", "hysteresis", "plastic", "elastoplastic", "yield force", "F_y",
        "force at first yield",
    ),
    "explanation/timestep": ("timestep", "time step"),
    "explanation/limits": (
        "GPU", "cohesion", "bullet", "ballistic", "fracture", "adhesion", "Windows",
        "limits of the law",
    ),
    "explanation/speed": ("benchmark", "performance"),
    "explanation/results": (
        "validation", "comparison with experiments", "compare with experiments",
    ),
    "start": ("install", "pip", "wheel", "tab completion"),
    "reference/figures": ("figures",),
    "reference/contributing": ("contributing", "new lattice", "new contact law"),
}  # fmt: skip
#: Words whose page is expected among the first two results.
HEADS = {
    "changelog": "reference/changelog",
    "what changed": "reference/changelog",
    "new in 1.0": "reference/changelog",
    "release notes": "reference/changelog",
    "force chains": "howto/contact-figures",
    "fit material": "extensions/continuum/fit-a-law",
    "absorb waves": "howto/boundaries",
    "contacts csv": "howto/other-programs",
    "Thornton": "explanation/contact-law",
    "killed run": "howto/stop-and-resume",
    "group velocity": "extensions/waves/bands",
}
#: Whole questions as users type them, whose page is expected among the first `FIRST` results.
QUESTIONS = {
    "pair style LAMMPS input": "reference/styles/pair_gran_hysteretic",
    "Young's modulus": "reference/materials",
    "striker velocity": "howto/struck-packings",
    "prescribe velocity of striker": "howto/struck-packings",
    "fit measured curve": "extensions/continuum/fit-a-law",
    "units of force summary.json": "reference/quantities",
    "moving piston": "howto/driven-rows",
    "plugin load": "tutorials/lammps-script",
    "build LAMMPS with package": "howto/lammps-package",
    "restart file": "lammps/restart",
    "dump contact forces": "lammps/contacts",
    "fix wall gran": "reference/styles/fix_wall_gran_hysteretic",
    "pair_coeff elastoplastic": "reference/styles/pair_gran_hysteretic",
    "kokkos threads": "howto/own-lammps",
    "read result.h5 in MATLAB": "reference/result-h5",
    "number of MPI processes": "howto/own-lammps",
    "thermo output energy": "reference/styles/compute_gran_hysteretic_energy",
    "freeze bottom layer": "reference/styles/other_commands",
    "rigid body fix": "lammps/clumps",
    "equations of the law": "explanation/contact-law",
    "figure for a paper": "howto/more-questions",
    "which papers": "explanation/results",
    "Slurm with MPI": "tutorials/cluster",
}
#: Passages that the first result of a word opens.
PASSAGES = {
    "zone_depth_90_m": "reference/quantities#zone-depth-90-m",
    "load.velocity": "reference/keys#case-load-velocity",
}


class Result(NamedTuple):
    """A result of a search."""

    page: str
    title: str
    anchor: str
    score: float
    description: str = ""


Index = Mapping[str, Any]


def read_index(site: Path) -> Index:
    """Read the index of a built site."""
    text = (site / "searchindex.js").read_text(encoding="utf-8")
    found: Index = json.loads(text[text.index("(") + 1 : text.rindex(")")])
    return found


def search(
    index: Index, query: str, stem: Callable[[str], str], stopwords: frozenset[str] | set[str]
) -> list[Result]:
    """Return the results of a query, best first.

    Parameters
    ----------
    stem
        Stem of a word, as the index has it.
    stopwords
        Words that are ignored.
    """
    words = [word for word in re.split(r"[^\w]+", query) if word]
    stems = dict.fromkeys(
        stem(word.lower())
        for word in words
        if word.lower() not in stopwords and not re.fullmatch(r"\d+", word)
    )
    asked = query.lower().strip()
    main, others = _entries(index, asked)
    objects = [
        one for word in dict.fromkeys(map(str.lower, words)) for one in _objects(index, word, words)
    ]
    found = [*_titles(index, asked), *main, *objects, *_texts(index, list(stems), stem)]
    # entries that are not marked as the main ones come last
    ordered = [
        *_ordered(_weighted(result, query) for result in found),
        *_ordered(_weighted(result, query) for result in others),
    ]
    first: dict[object, Result] = {}
    for one in ordered:
        first.setdefault((one.page, one.title, one.anchor, one.description), one)
    return list(first.values())


def _weighted(result: Result, query: str) -> Result:
    """Return a result whose score includes the weight of its page, of the longest beginning of its
    name, and the weight of the query's words in its title.
    """
    score = result.score
    beginnings = [name for name in ROOMS if result.page.startswith(name)]
    if beginnings:
        score += ROOMS[max(beginnings, key=len)]
    if not result.description:  # names of Python objects have scores of their own
        score += TITLE_WORDS * part_in_title(result.title, query)
    return result._replace(score=score)


def part_in_title(title: str, query: str) -> float:
    """Return the fraction of the query's words with which words of a title begin; a final s of a
    query's word does not matter.
    """
    asked = _words(query)
    words = _words(title)
    matched = 0
    for word in asked:
        beginning = word.removesuffix("s") if len(word) > LONG_WORD else word
        matched += any(one.startswith(beginning) for one in words)
    return matched / len(asked) if asked else 0.0


def _words(text: str) -> list[str]:
    return re.findall(r"[a-z0-9_]+", text.lower())


def _ordered(found: Iterable[Result]) -> list[Result]:
    return sorted(found, key=lambda one: (-one.score, one.title.lower()))


def _titles(index: Index, asked: str) -> Iterator[Result]:
    names = index["docnames"]
    titles = index["titles"]
    for title, places in index["alltitles"].items():
        if asked in title.lower().strip() and len(asked) >= len(title) / 2:
            for file, anchor in places:
                own = titles[file] == title
                shown = title if own else f"{titles[file]} > {title}"
                score = int(_TITLE * len(asked) / len(title) + 0.5) + own
                yield Result(names[file], shown, f"#{anchor}" if anchor is not None else "", score)


def _entries(index: Index, asked: str) -> tuple[list[Result], list[Result]]:
    """Return entries of the index: the main ones, and the others."""
    found: tuple[list[Result], list[Result]] = ([], [])
    for entry, places in index["indexentries"].items():
        if asked in entry and len(asked) >= len(entry) / 2:
            for file, anchor, main in places:
                score = int(_INDEX * len(asked) / len(entry) + 0.5)
                one = Result(
                    index["docnames"][file],
                    index["titles"][file],
                    f"#{anchor}" if anchor else "",
                    score,
                )
                found[0 if main else 1].append(one)
    return found


def _objects(index: Index, word: str, words: list[str]) -> Iterator[Result]:
    others = {one.lower() for one in words} - {word}
    for prefix, objects in index["objects"].items():
        for file, kind, priority, anchor, name in objects:
            whole = f"{prefix}.{name}" if prefix else name
            lower = whole.lower()
            last = whole.lower().split(".")[-1]
            _, role, label = index["objnames"][str(kind)]
            title = index["titles"][file]
            text = f"{prefix} {name} {label} {title}".lower()
            if word in lower and all(one in text for one in others):
                score = _OBJECT if word in (lower, last) else _PART_OF_OBJECT if word in last else 0
                score += _PRIORITY.get(priority, 0)
                place = f"{role}-{whole}" if anchor == "-" else anchor or whole
                yield Result(
                    index["docnames"][file], whole, f"#{place}", score, f"{label}, in {title}"
                )


#: Files of each stem, by the place of the word: title, entry, section, text.
Places = Mapping[str, Mapping[str, list[int]]]


def _places(index: Index, stem: Callable[[str], str]) -> Places:
    """Return the files of each stem in titles, main entries of the index, titles of sections and
    texts; entries that are names, such as load.velocity, are left out.
    """
    titles: dict[str, list[int]] = {}
    entries: dict[str, list[int]] = {}
    for file, title in enumerate(index["titles"]):
        _add(titles, title, file, stem)
    for entry, places in index["indexentries"].items():
        if " " in entry or not re.search("[._/]", entry):
            for file, _, main in places:
                if main:
                    _add(entries, entry, file, stem)
    sections = {word: _files(files) for word, files in index["titleterms"].items()}
    texts = {word: _files(files) for word, files in index["terms"].items()}
    return {"title": titles, "entry": entries, "section": sections, "text": texts}


def _add(table: dict[str, list[int]], text: str, file: int, stem: Callable[[str], str]) -> None:
    for word in re.findall(r"\w+", text.lower()):
        table.setdefault(stem(word), []).append(file)


def _files(files: int | list[int]) -> list[int]:
    return files if isinstance(files, list) else [files]


def _weights_of(word: str, places: Places) -> dict[int, int]:
    """Return the best weight of a stem on each page that has it, or a word that contains it."""
    weights: dict[int, int] = {}
    for place, (whole, part) in WORD_WEIGHTS.items():
        table = places[place]
        if word in table or len(word) <= _SHORT:
            stems = [word]
        else:
            stems = [one for one in table if word in one]
        for one in stems:
            weight = whole if one == word else part
            for file in table.get(one, ()):
                weights[file] = max(weight, weights.get(file, 0))
    return weights


def _texts(index: Index, stems: list[str], stem: Callable[[str], str]) -> Iterator[Result]:
    """Pages that contain words of the query; see `scorer.js`."""
    places = _places(index, stem)
    sums: dict[int, float] = {}
    covered: dict[int, float] = {}
    total = 0.0
    for word in stems:
        weights = _weights_of(word, places)
        if not weights:
            continue
        rarity = math.log(1 + len(index["docnames"]) / len(weights))
        total += rarity
        for file, weight in weights.items():
            sums[file] = sums.get(file, 0.0) + rarity * weight
            covered[file] = covered.get(file, 0.0) + rarity
    most = max(covered.values(), default=0.0)
    for file, fraction in covered.items():
        if fraction >= most / 2:
            score = sums[file] / total * (fraction / total) ** 2
            yield Result(index["docnames"][file], index["titles"][file], "", score)


def missed(
    index: Index, stem: Callable[[str], str], stopwords: frozenset[str] | set[str]
) -> list[str]:
    """Return a line for each word whose page is not among the first results, or whose first result
    does not open its passage.
    """
    found = []
    for word, passage in PASSAGES.items():
        opened = [f"{one.page}{one.anchor}" for one in search(index, word, stem, stopwords)[:1]]
        if opened != [passage]:
            found.append(
                f"{word}: expected {passage} first, found {', '.join(opened) or 'nothing'}"
            )
    expected = []
    for page, words in WORDS.items():
        expected += [(word, page, FIRST) for word in words]
    expected += [(word, page, FIRST) for word, page in QUESTIONS.items()]
    expected += [(word, page, FIRST_OF_HEADS) for word, page in HEADS.items()]
    for word, page, number in expected:
        first = [one.page for one in search(index, word, stem, stopwords)[:number]]
        if page not in first:
            found.append(
                f"{word}: expected {page} among the first {number} results, "
                f"found {', '.join(first) or 'nothing'}"
            )
    return found


def main(site: str, *query: str) -> int:
    """Check all words, or show the results of one; return the exit status."""
    from sphinx.search.en import SearchEnglish

    language = SearchEnglish({})
    index = read_index(Path(site))
    if query:
        for one in search(index, " ".join(query), language.stem, language.stopwords)[:10]:
            print(f"{one.score:4g}  {one.page}{one.anchor}  {one.title} {one.description}")
        return 0
    faults = missed(index, language.stem, language.stopwords)
    number = sum(map(len, WORDS.values())) + len(QUESTIONS) + len(HEADS) + len(PASSAGES)
    print("\n".join(faults) or f"{number} words find their pages")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
