"""HTML pages of results.

In reading order: `html` (sections of text, pictures and tables; templates/), `fit` (sections of a fit), `results` (any
result of the package), `studio` (the page of the studio).
"""
