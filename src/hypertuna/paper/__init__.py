"""The ledger: numbers of the paper, computed beside published.

In reading order: `ledger` (entries, and the rules that judge them), `computed` (simulations shared by chapters),
`studies` and `seeds` (stored numbers over seeds of the noise), `chapter` and `chapters/` (what each section of the
paper computes, finds and shows; prose in templates/), `passive` (robots with a spring for joint II), `figures`,
`reproduce` (the list of chapters), `page` (the HTML page). The verdicts that are stored for the studio:
`validation/paper/verdicts.py`.
"""
