/* Weights of the search of the site; docs/_ext/search.py reads them from this file.

   Results with equal scores would be in the order of their titles. A room adds to the score of all
   pages whose name begins so: titles and how-tos come first, results and the changelog last. A title
   adds titleWords times the fraction of the query's words that it contains, below 1: it decides
   between results that are equal otherwise. */
var Scorer = {
  rooms: {
    "howto/": 3,
    "tutorials/": 3,
    "start": 3,
    "lammps/": 3,
    "extensions/": 2,
    "explanation/": 3,
    "reference/contributing": -2,
    "explanation/results/": -9,
    "explanation/errata": -4,
    "explanation/coverage": -4,
    "reference/changelog": -13
  },
  titleWords: 0.9,
  wordsOf: (text) => text.toLowerCase().split(/[^a-z0-9_]+/).filter((word) => word),
  query: () => new URLSearchParams(window.location.search).get("q") || "",
  partInTitle: (title, query) => {
    const asked = Scorer.wordsOf(query);
    const words = Scorer.wordsOf(title);
    const matched = asked.filter((word) =>
      words.some((one) => one.startsWith(word.length > 3 ? word.replace(/s$/, "") : word))
    );
    return asked.length ? matched.length / asked.length : 0;
  },
  score: (result) => {
    const [page, title, , description, score] = result;
    const room = Object.keys(Scorer.rooms)
      .filter((name) => page.startsWith(name))
      .reduce((best, name) => (name.length > best.length ? name : best), "");
    // names of Python objects have a description, and scores of their own
    const part = description ? 0 : Scorer.partInTitle(title, Scorer.query());
    return score + (Scorer.rooms[room] || 0) + Scorer.titleWords * part;
  },
  objNameMatch: 11,
  objPartialMatch: 6,
  objPrio: { 0: 15, 1: 5, 2: -5 },
  objPrioDefault: 0,
  title: 15,
  partialTitle: 7,
  term: 5,
  partialTerm: 2
};
