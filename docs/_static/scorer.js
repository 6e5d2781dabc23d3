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

/* Before the search begins, which is when the page has been read. */
document.addEventListener("readystatechange", () => {
    if (typeof Search === "undefined" || document.readyState !== "interactive") return;

    /* A page is one hit, the best of its own; results come with the best last. */
    const perform = Search._performSearch;
    Search._performSearch = (...given) => {
        const seen = new Set();
        return perform(...given).reverse().filter(([page]) => !seen.has(page) && seen.add(page)).reverse();
    };

    /* Snippets are sentences of the page: the first paragraph that has the words, else the first one. */
    Search.makeSearchSummary = (text, keywords) => {
        const page = new DOMParser().parseFromString(text, "text/html");
        const paragraphs = [...page.querySelectorAll(".bd-article :is(p, dd, td, pre)")]
            .map((paragraph) => paragraph.textContent.trim())
            .filter((words) => words.length > 20);
        const words = [...keywords].map((word) => word.toLowerCase());
        const having = (paragraph) => words.filter((word) => paragraph.toLowerCase().includes(word)).length;
        const most = Math.max(0, ...paragraphs.map(having));
        const found = paragraphs.find((paragraph) => having(paragraph) === most) || "";
        const place = Math.max(0, Math.min(...words.map((word) => found.toLowerCase().indexOf(word)).filter((k) => k >= 0), 1e6));
        const start = place < 1e6 && place > 160 ? place - 100 : 0;
        const summary = document.createElement("p");
        summary.classList.add("context");
        summary.textContent = (start ? "… " : "") + found.slice(start, start + 240) + (found.length > start + 240 ? " …" : "");
        return summary;
    };
});
