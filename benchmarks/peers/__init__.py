"""The same swimming model in other people's tools, to compare speeds with."""
