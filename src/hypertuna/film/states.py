"""States of a tracked frame, and advice to the user when a bad state occurs too often."""

# Numbers of the states, and by number: name, and advice to the user.
OK, LOST, BORDER, MISFIT, UNSEEN = range(5)
STATES = ("ok", "not found", "not whole in the picture", "not fitted by the silhouette", "without a part")
FIXES = {
    LOST: "film with more contrast: a dark fish over a white floor, at a fixed exposure",
    BORDER: "cut the film to the time when the whole fish is in the picture",
    MISFIT: "check the robot and its sections, and that the fish touches no other fish and no wall",
    UNSEEN: "paint the fin dark, or give it a rib 4 mm wide",
}
