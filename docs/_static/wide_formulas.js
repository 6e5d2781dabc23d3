/* Formulas within a line that are wider than the screen scroll within themselves. */
const markWide = () => {
    for (const formula of document.querySelectorAll("mjx-container:not([display])")) {
        formula.classList.remove("wide");
        const line = formula.closest("p, li, td, dd, div");
        if (line && formula.firstElementChild.getBoundingClientRect().right > line.getBoundingClientRect().right + 1)
            formula.classList.add("wide");
    }
};
window.addEventListener("load", () => window.MathJax?.startup?.promise?.then(markWide));
window.addEventListener("resize", markWide);
