/* The order of hits: pages that answer "how do I" come first, and history comes last. */
var Scorer = {
    places: { howto: 30, getting_started: 12, tutorials: 10, gallery: 4, theory: 4, decisions: -20, results: -20, project: -10 },
    score: ([docname, title, anchor, description, score]) => score + (Scorer.places[docname.split("/")[0]] || 0),
    objNameMatch: 11,
    objPartialMatch: 4,
    objPrio: { 0: 8, 1: 2, 2: -5 },
    objPrioDefault: 0,
    title: 15,
    partialTitle: 7,
    term: 5,
    partialTerm: 2,
};
