"""Tank runs: tracks, steady runs, manifests, importers, replay, comparison."""
