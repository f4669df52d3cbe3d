"""HTML pages of any result, and their templates."""
