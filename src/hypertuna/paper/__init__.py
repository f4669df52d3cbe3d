"""The ledger: numbers of the paper, computed beside published.

In reading order: `ledger` (entries, rules, verdicts), `computed` (simulations shared by chapters), `studies` and
`seeds` (numbers over seeds of the noise, stored), `chapter` and
`chapters/` (what each section of the paper computes, finds and shows; prose in templates/), `passive` (robots with a
spring for joint II, and their best gaits), `figures` and `figures_passive`, `reproduce` (the list of chapters), `page`
(the HTML page).
"""
