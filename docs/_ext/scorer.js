/* Weights of the search of the site; docs/_ext/search.py reads the rooms from this file.

   Results with equal scores would be in the order of their titles. A room adds to the score of all
   pages whose name begins so: titles and how-tos come first, results and the changelog last. */
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
  score: (result) => {
    const room = Object.keys(Scorer.rooms)
      .filter((name) => result[0].startsWith(name))
      .reduce((best, name) => (name.length > best.length ? name : best), "");
    return result[4] + (Scorer.rooms[room] || 0);
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
