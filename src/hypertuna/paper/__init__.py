"""The ledger: numbers of the paper, computed beside published.

In reading order: `ledger` (entries, rules, verdicts), `computed` (simulations shared by chapters), `studies` and
`seeds` (numbers over seeds of the noise, stored), `chapter` and
`chapters/` (what each section of the paper computes, finds and shows; prose in templates/), `figures`, `reproduce` (the
list of chapters), `page` (the HTML page).
"""
