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
  wordWeights: {"title": [15, 7], "entry": [12, 6], "section": [9, 4], "text": [5, 2]},
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
  // files of a table of an index, as a list
  filesOf: (files) => (Array.isArray(files) ? files : [files]),
  // files of each word, by place
  places: () => {
    const index = Search._index;
    const stemmer = new Stemmer();
    const table = () => Object.create(null);
    const found = { title: table(), entry: table(), section: table(), text: table() };
    const add = (place, text, file) =>
      splitQuery(text.toLowerCase()).forEach((word) => {
        const stem = stemmer.stemWord(word);
        (found[place][stem] = found[place][stem] || []).push(file);
      });
    index.titles.forEach((title, file) => add("title", title, file));
    // entries without names such as load.velocity
    for (const [entry, places] of Object.entries(index.indexentries))
      if (entry.includes(" ") || !/[._/]/.test(entry))
        places.filter(([, , main]) => main).forEach(([file]) => add("entry", entry, file));
    for (const [place, terms] of [["section", index.titleterms], ["text", index.terms]])
      for (const [stem, files] of Object.entries(terms)) found[place][stem] = Scorer.filesOf(files);
    return found;
  },
  // best weight of a word on each page
  weightsOf: (word, places) => {
    const weights = new Map();
    for (const [place, [whole, part]] of Object.entries(Scorer.wordWeights)) {
      const table = places[place];
      const stems = word in table || word.length < 3 ? [word] : Object.keys(table);
      for (const stem of stems) {
        if (!(stem in table) || !stem.includes(word)) continue;
        const weight = stem === word ? whole : part;
        for (const file of table[stem])
          weights.set(file, Math.max(weight, weights.get(file) || 0));
      }
    }
    return weights;
  },
  pagesWith: (stems, excluded) => {
    const index = Search._index;
    const places = (Scorer.cached = Scorer.cached || Scorer.places());
    const pages = new Map();
    let all = 0;
    for (const word of stems) {
      const weights = Scorer.weightsOf(word, places);
      if (!weights.size) continue;
      const rarity = Math.log(1 + index.docnames.length / weights.size);
      all += rarity;
      for (const [file, weight] of weights) {
        const [sum, covered] = pages.get(file) || [0, 0];
        pages.set(file, [sum + rarity * weight, covered + rarity]);
      }
    }
    const most = Math.max(0, ...[...pages.values()].map(([, covered]) => covered));
    const left = [...excluded].map((word) => Scorer.weightsOf(word, places));
    const results = [];
    for (const [file, [sum, covered]] of pages) {
      if (covered < most / 2 || left.some((weights) => weights.has(file))) continue;
      const score = (sum / all) * (covered / all) ** 2;
      const shown = [index.docnames[file], index.titles[file], "", null, score];
      results.push([...shown, index.filenames[file], SearchResultKind.text]);
    }
    return results;
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
if (typeof Search !== "undefined") Search.performTermsSearch = Scorer.pagesWith;
