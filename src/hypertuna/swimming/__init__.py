"""From a gait to the settled beat, its sweep, gradient and turn."""
