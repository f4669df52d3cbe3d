"""The ledger: published beside computed."""
