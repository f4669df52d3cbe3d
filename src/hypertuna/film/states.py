"""What may come of a frame."""

OK, LOST, BORDER, MISFIT, UNSEEN = range(5)
STATES = ("ok", "not found", "not whole in the picture", "not fitted by the silhouette", "without a part")
